"""Where the cross-section of a mesh drawn along y crosses or touches itself."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: What is wrong and where [mm].
Contact = tuple[str, NDArray[np.float64]]

#: Share of the end faces' area that may be turned over: slivers that rounding does that to.
_TURNED = 1e-6


class Section(NamedTuple):
    """The cross-section of an extruded mesh, and its two end faces.

    Attributes
    ----------
    point
        (p, 2) float64, (x, z) [mm]
    edge
        (e, 2) int64, numbers of the points of a segment; its solid lies on the right
    low
        y of the near end face [mm]
    cap
        (c, 3) int64, points of the facets of both end faces, clockwise
    """

    point: NDArray[np.float64]
    edge: NDArray[np.int64]
    low: float
    cap: NDArray[np.int64]


def extruded_section(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> Section | None:
    """Return the cross-section of a closed mesh, or None where it is not one drawn along y."""
    low, high = vertex[:, 1].min(), vertex[:, 1].max()
    near = vertex[:, 1] == low
    if not (near | (vertex[:, 1] == high)).all():
        return None
    # A pair of numbers as one complex: sorted as one.
    flat, number = np.unique(vertex[:, 0] + 1j * vertex[:, 2], return_inverse=True)
    ends = near[facet].sum(axis=1)
    number = number[facet]
    edges = []
    for count in (2, 1):
        # Of two corners on one end face and one on the other, the last is over one of the others.
        wall, odd = number[ends == count], near[facet[ends == count]] == (count == 1)
        first = (odd.argmax(axis=1) + 1) % 3
        row = np.arange(len(wall))
        p, q, over = (wall[row, (first + k) % 3] for k in range(3))
        if ((over != p) & (over != q)).any():
            return None
        edges.append(np.stack([p, q] if count == 2 else [q, p], axis=1))
    ordered = [e[np.lexsort(e.T)] for e in edges]
    if ordered[0].shape != ordered[1].shape or (ordered[0] != ordered[1]).any():
        return None
    cap = np.concatenate([number[ends == 3][:, ::-1], number[ends == 0]])
    return Section(np.stack([flat.real, flat.imag], axis=1), edges[0], float(low), cap)


def section_contact(section: Section) -> Contact | None:
    """Return where a section's segments meet but in shared ends, or its bodies lie wrongly."""
    import shapely

    ends = section.point[section.edge]
    line = shapely.linestrings(ends)
    tree = shapely.STRtree(line)
    i, j = tree.query(line, predicate="intersects")
    i, j = i[i < j], j[i < j]
    a, b = section.edge[i], section.edge[j]
    joined = (a[:, :, None] == b[:, None, :]).any(axis=(1, 2))
    wrong = np.flatnonzero(~joined)
    if len(wrong):
        # The first in the mesh's own order: that of the tree is its library's.
        first = wrong[np.lexsort((j[wrong], i[wrong]))[0]]
        one, other = line[i[first]], line[j[first]]
        # Lines that run along each other neither cross nor, in this sense, touch.
        what = "crosses itself" if shapely.crosses(one, other) else "touches itself"
        where = shapely.centroid(shapely.intersection(one, other))
        return what, np.array([where.x, section.low, where.y])
    folded = _folded(section, a[joined], b[joined])
    if folded is not None:
        return "touches itself", _place(section, folded)
    return _inverted_body(section, tree) or _folded_end(section)


def _folded(
    section: Section, a: NDArray[np.int64], b: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Return where two joined segments lie on each other, or more than two join."""
    times = np.bincount(section.edge.ravel())
    if times.max() > 2:
        return section.point[times.argmax()]
    # Each segment as a vector from the joint.
    forward = a[:, 1] == b[:, 0]
    joint = np.where(forward, a[:, 1], a[:, 0])
    p = section.point[np.where(forward, a[:, 0], a[:, 1])] - section.point[joint]
    q = section.point[np.where(forward, b[:, 1], b[:, 0])] - section.point[joint]
    across = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    on = np.flatnonzero((across == 0) & ((p * q).sum(axis=1) > 0))
    return section.point[joint[on[0]]] if len(on) else None


def _folded_end(section: Section) -> Contact | None:
    """Return where an end face lies on itself."""
    area = _doubled_area(section.point[section.cap])
    if area.clip(0).sum() > _TURNED * np.abs(area).sum():
        middle = section.point[section.cap[area.argmax()]].mean(axis=0)
        return "touches itself", _place(section, middle)
    return None


def _doubled_area(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _inverted_body(section: Section, tree: Any) -> Contact | None:
    """Return a place on an outline that runs the wrong way round for what it lies in."""
    import shapely
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edge, point = section.edge, section.point
    graph = coo_array((np.ones(len(edge)), edge.T), shape=(len(point), len(point)))
    count, body = connected_components(graph, directed=False)
    body = body[edge[:, 0]]
    if count == 1:
        return None
    a, b = point[edge[:, 0]], point[edge[:, 1]]
    area = np.bincount(body, (b[:, 0] - a[:, 0]) * (a[:, 1] + b[:, 1]) / 2, count)
    # The longest step along x of each outline, at a place where hardly a corner lies above.
    reach = np.abs(b[:, 0] - a[:, 0])
    order = np.lexsort((reach, body))
    first = order[np.r_[np.flatnonzero(np.diff(body[order])), len(order) - 1]]
    start = a[first] + 0.381966 * (b[first] - a[first])
    top = np.stack([start[:, 0], np.full(count, point[:, 1].max() + 1.0)], axis=1)
    which, above = tree.query(shapely.linestrings(np.stack([start, top], axis=1)), "intersects")
    other = body[above] != which
    sense = np.sign(b[above, 0] - a[above, 0])[other]
    depth = np.bincount(which[other], sense, count)
    wrong = np.flatnonzero(depth != (area < 0))
    return ("a body is inverted", _place(section, start[wrong[0]])) if len(wrong) else None


def _place(section: Section, point: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([point[0], section.low, point[1]])
