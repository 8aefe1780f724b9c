"""Overlapping bodies of a mesh made one by manifold3d: in the cross-section, or as solids."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.solid.crossing_section import Section

Solid = tuple[NDArray[np.float64], NDArray[np.int64]]


def unite_section(section: Section, high: float) -> Solid | None:
    """Return the mesh from section.low to `high` [mm] of what the outlines enclose, or None.

    What they run about once or more often anticlockwise is enclosed, whatever crosses.
    """
    from manifold3d import CrossSection, FillRule, triangulate

    outlines = [section.point[loop[::-1]] for loop in _outlines(section.edge)]
    rings = []
    # Corners that lie in a line within a tenth of a nanometre are none: where bodies met in it.
    for ring in CrossSection(outlines, FillRule.Positive).simplify(1e-7).to_polygons():
        ring = np.asarray(ring).astype(np.float32).astype(float)
        ring = ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)]
        if len(ring) > 2:
            rings.append(ring)
    if not rings:
        return None
    flat = np.concatenate(rings)
    count = len(flat)
    ahead = np.concatenate([np.roll(np.arange(len(r)), -1) for r in rings])
    ahead += np.repeat(np.cumsum([0] + [len(r) for r in rings[:-1]]), [len(r) for r in rings])
    own = np.arange(count)
    cap = np.asarray(triangulate(rings), np.int64)
    # Anticlockwise with x to the right and z up is outward for the near end face.
    walls = [(ahead, own, own + count), (ahead, own + count, ahead + count)]
    facet = np.concatenate([np.stack(w, axis=1) for w in walls] + [cap, cap[:, ::-1] + count])
    ends = [np.c_[flat[:, 0], np.full(count, y), flat[:, 1]] for y in (section.low, high)]
    return np.concatenate(ends), facet


def _outlines(edge: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Return closed lines of points that use each segment once."""
    # Where several lines pass a point it does not matter which goes on where.
    after = np.empty(len(edge), np.int64)
    after[np.argsort(edge[:, 1], kind="stable")] = np.argsort(edge[:, 0], kind="stable")
    follow, seen, lines = after.tolist(), [False] * len(edge), []
    for first in range(len(edge)):
        line, k = [], first
        while not seen[k]:
            seen[k] = True
            line.append(k)
            k = follow[k]
        if line:
            lines.append(edge[line, 0])
    return lines


def unite_bodies(
    vertex: NDArray[np.float64], facet: NDArray[np.int64], part: NDArray[np.integer]
) -> Solid | None:
    """Return the union of the parts that look outward less those that look inward, or None.

    None where manifold3d takes a part for no solid. part: (n,) of each facet.
    """
    from manifold3d import Error, Manifold, Mesh64, OpType

    solids: tuple[list[Manifold], list[Manifold]] = ([], [])
    for name in np.unique(part):
        own, number = np.unique(facet[part == name], return_inverse=True)
        number = number.reshape(-1, 3).astype(np.uint64)
        a, b, c = (vertex[own][number[:, k]] - vertex[own[0]] for k in range(3))
        inward = np.einsum("ij,ij->", a, np.cross(b, c)) < 0
        solid = Manifold(Mesh64(vertex[own], number[:, ::-1] if inward else number))
        if solid.status() != Error.NoError:
            return None
        solids[int(inward)].append(solid)
    if not solids[0]:
        return None
    whole = Manifold.batch_boolean(solids[0], OpType.Add)
    if solids[1]:
        whole = whole - Manifold.batch_boolean(solids[1], OpType.Add)
    # Corners that float32 would make one are one already.
    mesh = whole.simplify(
        4 * float(np.spacing(np.abs(vertex).max().astype(np.float32)))
    ).to_mesh64()
    point = np.asarray(mesh.vert_properties)[:, :3].astype(np.float32).astype(float)
    return point, np.asarray(mesh.tri_verts, np.int64)
