"""Any film top as a tree of boxes over its triangles: the accelerator for what is not extruded.

Binary tree, split where the surface-area heuristic in 16 bins is least (Wald, "On fast construction
of SAH-based bounding volume hierarchies", 2007), laid out depth first with skip links (Smits,
"Efficiency issues for ray tracing", 1998), so that a walk needs no stack. The film repeats as a
tile: a ray that leaves one side comes back in at the opposite one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mpfcad.optics.kernel import kernel
from mpfcad.optics.mesh import FilmMesh
from mpfcad.optics.triangle import triangle_distance

_BINS = 16
_LEAF = 4


class Bvh(NamedTuple):
    """A box tree over triangles.

    Attributes
    ----------
    box
        (n, 6) float64 [mm], low and high corner of each node
    leaf
        (n, 2) int64, first triangle and their number; none in an inner node
    skip
        (n,) int64, the node to go on with when a node's box is missed; when it is met, the next one
    corner
        (t, 9) float64 [mm], corners of the triangles, in leaf order
    normal
        (t, 3) float64, their outward unit normals
    """

    box: NDArray[np.float64]
    leaf: NDArray[np.int64]
    skip: NDArray[np.int64]
    corner: NDArray[np.float64]
    normal: NDArray[np.float64]


def build_bvh(mesh: FilmMesh) -> Bvh:
    """Return the tree over the top facets of a film mesh."""
    corner = mesh.vertex[mesh.top]
    low, high = corner.min(axis=1), corner.max(axis=1)
    order, box, leaf, skip = _build(low, high, (low + high) / 2)
    corner = corner[order]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # Widen the boxes by the rounding of the slab test, so that no facet on a face is lost.
    margin = 8 * np.finfo(float).eps * max(mesh.size)
    box[:, :3] -= margin
    box[:, 3:] += margin
    return Bvh(box, leaf, skip, np.ascontiguousarray(corner.reshape(-1, 9)), normal)


@njit(cache=True)
def _build(low, high, centre):
    """Return (order (t,), box (n, 6), leaf (n, 2), skip (n,)) of the tree over boxes low…high."""
    count = len(centre)
    order = np.arange(count)
    box = np.empty((2 * count, 6))
    leaf = np.zeros((2 * count, 2), np.int64)
    parent = np.empty(2 * count, np.int64)
    stack = [(-1, 0, count)]
    used = 0
    while len(stack) > 0:
        above, first, last = stack.pop()
        node = used
        parent[node] = above
        used += 1
        for axis in range(3):
            box[node, axis] = np.inf
            box[node, 3 + axis] = -np.inf
            for i in range(first, last):
                box[node, axis] = min(box[node, axis], low[order[i], axis])
                box[node, 3 + axis] = max(box[node, 3 + axis], high[order[i], axis])
        middle = first
        if last - first > _LEAF:
            middle = _partition(order, low, high, centre, first, last)
        if middle in (first, last):
            leaf[node, 0] = first
            leaf[node, 1] = last - first
            continue
        stack.append((node, middle, last))
        stack.append((node, first, middle))
    size = np.ones(used, np.int64)
    for node in range(used - 1, 0, -1):
        size[parent[node]] += size[node]
    return order, box[:used].copy(), leaf[:used].copy(), np.arange(used) + size


@njit
def _partition(order, low, high, centre, first, last):
    """Reorder order[first:last] about the best split and return where it lies."""
    best, best_axis, best_bin = np.inf, -1, 0
    for axis in range(3):
        start, extent = _spread(order, centre, axis, first, last)
        if extent <= 0.0:
            continue
        cost, at = _best_bin(order, low, high, centre, axis, start, extent, first, last)
        if cost < best:
            best, best_axis, best_bin = cost, axis, at
    if best_axis < 0:
        return (first + last) // 2 if last - first > 4 * _LEAF else first
    start, extent = _spread(order, centre, best_axis, first, last)
    i, j = first, last - 1
    while i <= j:
        if _bin(centre[order[i], best_axis], start, extent) <= best_bin:
            i += 1
        else:
            order[i], order[j] = order[j], order[i]
            j -= 1
    return i


@njit
def _spread(order, centre, axis, first, last):
    """Return lowest value and range of the centres along an axis."""
    start, end = np.inf, -np.inf
    for i in range(first, last):
        start = min(start, centre[order[i], axis])
        end = max(end, centre[order[i], axis])
    return start, end - start


@njit
def _bin(value, start, extent):
    return min(_BINS - 1, int((value - start) / extent * _BINS))


@njit
def _best_bin(order, low, high, centre, axis, start, extent, first, last):
    """Return (cost, bin) of the cheapest split along an axis."""
    number = np.zeros(_BINS)
    bounds = np.empty((_BINS, 6))
    bounds[:, :3] = np.inf
    bounds[:, 3:] = -np.inf
    for i in range(first, last):
        t = order[i]
        b = _bin(centre[t, axis], start, extent)
        number[b] += 1
        for d in range(3):
            bounds[b, d] = min(bounds[b, d], low[t, d])
            bounds[b, 3 + d] = max(bounds[b, 3 + d], high[t, d])
    best, at = np.inf, 0
    for split in range(_BINS - 1):
        cost = 0.0
        filled = True
        for begin, end in ((0, split + 1), (split + 1, _BINS)):
            total = number[begin:end].sum()
            if total == 0:
                filled = False
                break
            a = bounds[begin:end, 3].max() - bounds[begin:end, 0].min()
            b = bounds[begin:end, 4].max() - bounds[begin:end, 1].min()
            c = bounds[begin:end, 5].max() - bounds[begin:end, 2].min()
            cost += total * (a * b + b * c + c * a)
        if filled and cost < best:
            best, at = cost, split
    return best, at


@kernel
def closest_facet(bvh, ox, oy, oz, dx, dy, dz, side, nearest, farthest):
    """Return (facet or -1, distance) of the first facet in [nearest, farthest] facing `side`."""
    ix, iy, iz = _inverse(dx), _inverse(dy), _inverse(dz)
    best = farthest
    found = -1
    node = 0
    while node < len(bvh.skip):
        if not _meets_box(bvh.box, node, ox, oy, oz, ix, iy, iz, nearest, best):
            node = bvh.skip[node]
            continue
        first = bvh.leaf[node, 0]
        for t in range(first, first + bvh.leaf[node, 1]):
            distance = triangle_distance(bvh.corner, t, ox, oy, oz, dx, dy, dz, side)
            if nearest <= distance <= best and (distance < best or found < 0):
                best = distance
                found = t
        node += 1
    return found, best


@kernel
def _inverse(component):
    return 1.0 / component if component != 0.0 else math.inf


@kernel
def _meets_box(box, node, ox, oy, oz, ix, iy, iz, nearest, farthest):
    """Return whether a ray meets a node's box; a NaN (ray in a face) counts as inside."""
    for low, high, o, i in (
        (box[node, 0], box[node, 3], ox, ix),
        (box[node, 1], box[node, 4], oy, iy),
        (box[node, 2], box[node, 5], oz, iz),
    ):
        a = (low - o) * i
        b = (high - o) * i
        if a > b:
            a, b = b, a
        if a > nearest:
            nearest = a
        if b < farthest:
            farthest = b
        if nearest > farthest * (1.0 + 4e-16) + 1e-300:
            return False
    return True


@kernel
def bvh_hit(bvh, size, low, high, x, y, z, dx, dy, dz, inside):
    """Return the next facet a ray meets: (facet or -1, x, y, z, shift x, shift y).

    The ray starts at (x, y, z) [mm] in the tile of `size` (width, length); low, high: lowest and
    highest z of the top. Shifts [mm] lead back to the coordinates before; facet -1: the ray leaves
    the zone of the top without a hit; -2: it was lost (a hole).
    """
    width, length = size
    slack = 16 * 2.3e-16 * max(width, length, high)
    side = 1.0 if inside else -1.0
    shift_x = 0.0
    shift_y = 0.0
    upward = dz > 0.0
    # Free flight up (or down) to the zone of the top.
    free = (low - z) / dz if inside and upward and z < low else 0.0
    if not inside and not upward and z > high:
        free = (high - z) / dz
    x += free * dx
    y += free * dy
    z += free * dz
    # Leaving the zone is known to the rounding of z over the slope: much, for a grazing ray.
    leave = math.inf
    if dz != 0.0:
        leave = ((high if upward else low) - z) / dz + slack / abs(dz)
    for _ in range(1_000_000):
        turn_x = math.floor(x / width) if not 0.0 <= x <= width else 0.0
        turn_y = math.floor(y / length) if not 0.0 <= y <= length else 0.0
        x -= turn_x * width
        y -= turn_y * length
        shift_x += turn_x * width
        shift_y += turn_y * length
        to_x = ((width if dx > 0.0 else 0.0) - x) / dx if dx != 0.0 else math.inf
        to_y = ((length if dy > 0.0 else 0.0) - y) / dy if dy != 0.0 else math.inf
        edge = max(0.0, min(to_x, to_y))
        reach = min(edge, leave) + slack
        facet, distance = closest_facet(bvh, x, y, z, dx, dy, dz, side, -slack, reach)
        if facet >= 0:
            x, y, z = x + distance * dx, y + distance * dy, z + distance * dz
            return facet, x, y, z, shift_x, shift_y
        # A ray that leaves zone and tile at once may still meet the neighbour's facets there.
        if leave < edge:
            lost = inside == upward
            return (-2 if lost else -1), x, y, z, shift_x, shift_y
        x += edge * dx
        y += edge * dy
        z += edge * dz
        leave -= edge
        # Exactly onto the opposite side of the tile.
        if to_x <= edge:
            x = 0.0 if dx > 0.0 else width
            shift_x += width if dx > 0.0 else -width
        if to_y <= edge:
            y = 0.0 if dy > 0.0 else length
            shift_y += length if dy > 0.0 else -length
    return -2, x, y, z, shift_x, shift_y
