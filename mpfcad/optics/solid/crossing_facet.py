"""Where the facets of any closed mesh cross or touch each other.

Pairs whose boxes overlap come from a tree; of each pair the edges of one are tried against the
other (Moeller, A fast triangle-triangle intersection test, 1997, tells planes apart the same way).
A determinant below its rounding error counts as zero: in doubt facets touch.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.solid.crossing_section import Contact

_CHUNK = 200_000
#: Of a determinant of three vectors, over the product of their largest components.
_ROUNDING = 2e-15


def facet_contact(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> Contact | None:
    """Return where closed facets meet but in shared edges and corners, or a body is inverted."""
    corner = vertex[facet]
    thick = _area2(corner) > _ROUNDING * np.ptp(corner, axis=1).max(axis=1) ** 2
    facet, corner = facet[thick], corner[thick]
    for i, j in _near_pairs(corner):
        found = _pair_contact(vertex, facet[i], facet[j])
        if found is not None:
            return found
    return _pinched(vertex, facet) or _inverted_body(vertex, facet)


def _area2(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return np.linalg.norm(across, axis=1)


def _near_pairs(corner: NDArray[np.float64]) -> Iterator[tuple[NDArray, NDArray]]:
    """Yield pairs i < j of facets with overlapping boxes, some at a time.

    A few large facets (an underside's) would be over everything in a tree of x and y, so those
    are tried against what shares their heights.
    """
    low, high = corner.min(axis=1), corner.max(axis=1)
    spread = np.prod((high - low)[:, :2], axis=1)
    large = spread > 1000 * np.median(spread)
    rank = np.arange(len(corner))
    small = rank[~large]
    yield from _overlapping(low, high, small, small)
    levels = np.unique(np.stack([low[large, 2], high[large, 2]], axis=1), axis=0)
    for bottom, top in levels:
        own = rank[large & (low[:, 2] == bottom) & (high[:, 2] == top)]
        beside = rank[(low[:, 2] <= top) & (high[:, 2] >= bottom)]
        for i, j in _overlapping(low, high, own, beside, twice=True):
            once = ~large[j] | (i < j)
            yield i[once], j[once]


def _overlapping(
    low: NDArray, high: NDArray, own: NDArray, beside: NDArray, twice: bool = False
) -> Iterator[tuple[NDArray, NDArray]]:
    import shapely

    if len(own) == 0:
        return
    box = shapely.box(*low[:, :2].T, *high[:, :2].T)
    tree = shapely.STRtree(box[beside])
    for first in range(0, len(own), 20_000):
        part = own[first : first + 20_000]
        i, j = tree.query(box[part])
        i, j = part[i], beside[j]
        good = (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
        good &= (i != j) if twice else (i < j)
        i, j = i[good], j[good]
        for k in range(0, len(i), _CHUNK):
            yield i[k : k + _CHUNK], j[k : k + _CHUNK]


def _pair_contact(vertex: NDArray, a: NDArray[np.int64], b: NDArray[np.int64]) -> Contact | None:
    """Return the first contact of facets a with facets b, both (n, 3)."""
    same = a[:, :, None] == b[:, None, :]
    shared = same.sum(axis=(1, 2))
    if (shared == 3).any():
        return "touches itself", vertex[a[shared == 3][0]].mean(axis=0)
    edge = shared == 2
    # Rolled so that the corner that is not shared comes first.
    d = _rolled(a[edge], (~same[edge].any(axis=2)).argmax(axis=1))
    e = _rolled(b[edge], (~same[edge].any(axis=1)).argmax(axis=1))
    folded = _folded(*(vertex[v] for v in (d[:, 1], d[:, 2], d[:, 0], e[:, 0])))
    if folded is not None:
        return "touches itself", folded
    one = shared == 1
    d = _rolled(a[one], same[one].any(axis=2).argmax(axis=1))
    e = _rolled(b[one], same[one].any(axis=1).argmax(axis=1))
    none = shared == 0
    for x, y, edges in ((d, e, (1,)), (a[none], b[none], (0, 1, 2))):
        x, y = _apart(vertex, x, y, len(edges))
        y, x = _apart(vertex, y, x, len(edges))
        for k in edges:
            for s, t in ((x, y), (y, x)):
                ends = vertex[s[:, k]], vertex[s[:, (k + 1) % 3]]
                found = _segment_contact(*ends, *(vertex[t[:, m]] for m in range(3)))
                if found is not None:
                    return found
    return None


def _rolled(facet: NDArray[np.int64], first: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.take_along_axis(facet, (first[:, None] + np.arange(3)) % 3, axis=1)


def _apart(vertex: NDArray, x: NDArray, y: NDArray, edges: int) -> tuple[NDArray, NDArray]:
    """Return the pairs without those where y lies on one side of x, but for a shared corner 0."""
    a, b, c = (vertex[x[:, k]] for k in range(3))
    rest = (0, 1, 2) if edges == 3 else (1, 2)
    sign = np.stack([_side(a, b, c, vertex[y[:, k]]) for k in rest])
    keep = ~((sign > 0).all(axis=0) | (sign < 0).all(axis=0))
    return x[keep], y[keep]


def _side(a: NDArray, b: NDArray, c: NDArray, d: NDArray) -> NDArray[np.float64]:
    """Return the determinant of b-a, c-a, d-a, (n,); exactly 0 where it is within its rounding."""
    u, v, w = b - a, c - a, d - a
    value = np.einsum("ij,ij->i", np.cross(u, v), w)
    size = np.abs(u).max(axis=1) * np.abs(v).max(axis=1) * np.abs(w).max(axis=1)
    return np.where(np.abs(value) <= _ROUNDING * size, 0.0, value)


def _folded(u: NDArray, v: NDArray, d: NDArray, e: NDArray) -> NDArray[np.float64] | None:
    """Return the middle of the first edge uv whose facets, on to d and e, lie on each other."""
    flat = _side(u, v, d, e) == 0
    turned = np.einsum("ij,ij->i", np.cross(v - u, d - u), np.cross(v - u, e - u)) > 0
    on = np.flatnonzero(flat & turned)
    return (u[on[0]] + v[on[0]]) / 2 if len(on) else None


def _segment_contact(p: NDArray, q: NDArray, a: NDArray, b: NDArray, c: NDArray) -> Contact | None:
    """Return the first place where a segment pq meets its triangle abc, borders included."""
    above, below = _side(a, b, c, p), _side(a, b, c, q)
    flat = (above == 0) & (below == 0)
    on = np.flatnonzero((above * below <= 0) & ~flat)
    turns = np.stack([_side(p[on], q[on], x[on], y[on]) for x, y in ((a, b), (b, c), (c, a))])
    inside = (turns >= 0).all(axis=0) | (turns <= 0).all(axis=0)
    if inside.any():
        k = int(inside.argmax())
        n = on[k]
        proper = above[n] * below[n] < 0 and (turns[:, k] != 0).all()
        place = p[n] + above[n] / (above[n] - below[n]) * (q[n] - p[n])
        return ("crosses itself" if proper else "touches itself"), place
    on = np.flatnonzero(flat)
    place = _flat_contact(*(v[on] for v in (p, q, a, b, c)))
    return None if place is None else ("touches itself", place)


def _flat_contact(
    p: NDArray, q: NDArray, a: NDArray, b: NDArray, c: NDArray
) -> NDArray[np.float64] | None:
    """Return the first place where a segment meets a triangle in the same plane."""
    if len(p) == 0:
        return None
    # Seen along the largest component of the plane's normal.
    drop = np.abs(np.cross(b - a, c - a)).argmax(axis=1)
    keep = np.array([(1, 2), (2, 0), (0, 1)])[drop]
    p2, q2, a2, b2, c2 = (np.take_along_axis(v, keep, axis=1) for v in (p, q, a, b, c))
    turns = np.stack([_turn(x, y, p2) for x, y in ((a2, b2), (b2, c2), (c2, a2))])
    hit = (turns >= 0).all(axis=0) | (turns <= 0).all(axis=0)
    for x, y in ((a2, b2), (b2, c2), (c2, a2)):
        hit |= _segments_meet(p2, q2, x, y)
    if not hit.any():
        return None
    n = int(hit.argmax())
    triangle = np.stack([a[n], b[n], c[n]])
    low = np.maximum(np.minimum(p[n], q[n]), triangle.min(axis=0))
    return (low + np.minimum(np.maximum(p[n], q[n]), triangle.max(axis=0))) / 2


def _turn(a: NDArray, b: NDArray, c: NDArray) -> NDArray[np.float64]:
    u, v = b - a, c - a
    value = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    size = np.abs(u).max(axis=1) * np.abs(v).max(axis=1)
    return np.where(np.abs(value) <= _ROUNDING * size, 0.0, value)


def _segments_meet(p: NDArray, q: NDArray, a: NDArray, b: NDArray) -> NDArray[np.bool_]:
    """Return which segments pq and ab of a plane meet, ends included, (n,)."""
    one, two, three, four = _turn(a, b, p), _turn(a, b, q), _turn(p, q, a), _turn(p, q, b)
    meet = (one * two <= 0) & (three * four <= 0)
    line = (one == 0) & (two == 0) & (three == 0) & (four == 0)
    over = (np.maximum(p, q) >= np.minimum(a, b)) & (np.maximum(a, b) >= np.minimum(p, q))
    return np.where(line, over.all(axis=1), meet)


def _pinched(vertex: NDArray, facet: NDArray[np.int64]) -> Contact | None:
    """Return a vertex whose facets are more than one fan: two parts touch in a point there."""
    # Corners of facets that share an edge and a vertex are joined; a fan is what hangs together.
    corner = np.arange(facet.size).reshape(facet.shape)
    start, end = facet, np.roll(facet, -1, axis=1)
    order = np.lexsort((np.minimum(start, end).ravel(), np.maximum(start, end).ravel()))
    one, other = order[::2], order[1::2]
    after = np.roll(corner, -1, axis=1).ravel()
    links = np.stack(
        [np.r_[corner.ravel()[one], after[one]], np.r_[after[other], corner.ravel()[other]]]
    )
    _, fan = joined(links, facet.size)
    flat = facet.ravel()
    first = np.full(len(vertex), -1)
    first[flat] = fan
    torn = np.flatnonzero(first[flat] != fan)
    return ("touches itself", vertex[flat[torn[0]]]) if len(torn) else None


def joined(links: NDArray[np.int64], count: int) -> tuple[int, NDArray[np.int32]]:
    """Return how many parts pairs (2, n) of numbers below `count` leave, and the part of each."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(links.shape[1]), links), shape=(count, count))
    return connected_components(graph, directed=False)


def _inverted_body(vertex: NDArray, facet: NDArray[np.int64]) -> Contact | None:
    """Return a place on a body that is oriented the wrong way for what it lies in."""
    _, part = joined(np.stack([facet[:, :2].ravel(), facet[:, 1:].ravel()]), len(vertex))
    place, volume, depth, _ = nesting(vertex, facet, part[facet[:, 0]])
    wrong = np.flatnonzero(depth != (volume < 0))
    return ("a body is inverted", place[wrong[0]]) if len(wrong) else None


def nesting(
    vertex: NDArray, facet: NDArray[np.int64], part: NDArray[np.integer]
) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Return of each part of a mesh a place on it, its volume, and how deep in others it lies.

    part: (n,) of each facet. The depth counts others' facets above the place by their sense, or,
    what comes last, whether their number is odd.
    """
    import shapely

    names, part = np.unique(part, return_inverse=True)
    count = len(names)
    corner = vertex[facet]
    a, b, c = (corner[:, k] - vertex.mean(axis=0) for k in range(3))
    volume = np.bincount(part, np.einsum("ij,ij->i", a, np.cross(b, c)), count) / 6
    up = np.cross(b - a, c - a)[:, 2]
    # A place on the facet of each body that spreads most; hardly a corner lies above it.
    order = np.lexsort((np.abs(up), part))
    first = order[np.r_[np.flatnonzero(np.diff(part[order])), len(order) - 1]]
    start = np.einsum("k,ikj->ij", [0.381966, 0.414214, 0.20382], corner[first])
    if count == 1:
        return start, volume, np.zeros(1), np.zeros(1, bool)
    low, high = corner.min(axis=1), corner.max(axis=1)
    tree = shapely.STRtree(shapely.box(*low[:, :2].T, *high[:, :2].T))
    which, above = tree.query(shapely.points(start[:, :2]))
    good = (part[above] != which) & (up[above] != 0)
    which, above = which[good], above[good]
    sense = np.sign(up[above])
    a, b, c = (corner[above, k] for k in range(3))
    flat = [point[:, :2] for point in (a, b, c)]
    turns = np.stack([_turn(flat[k], flat[(k + 1) % 3], start[which, :2]) for k in range(3)])
    over = _side(a, b, c, start[which]) * sense < 0
    hit = (turns * sense > 0).all(axis=0) & over
    odd = np.bincount(which[hit], minlength=count) % 2 == 1
    return start, volume, np.bincount(which[hit], sense[hit], count), odd
