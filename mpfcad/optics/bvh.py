"""Any film top as a tree of boxes over its triangles: the accelerator for what nothing else takes.

Nodes have up to eight children and leaves up to eight triangles; both are tested eight at a time
(`lanes`), after Wald, Benthin and Boulos, "Getting rid of packets", 2008. Children are met nearest
first. The film repeats as a tile: a ray that leaves one side comes back in at the opposite one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import LANES, any_of, bits, lowest_bit, select, spread
from mpfcad.optics.lanes_array import load, local_floats, local_wholes, store
from mpfcad.optics.triangle import BEHIND, aim_at, facet_distance, on_edge, turned

_STACK = 256


class Bvh(NamedTuple):
    """A box tree over triangles.

    Attributes
    ----------
    box
        (6n, 8) float32 [mm], for each node the low and high x, y, z of its children, rounded
        outward
    child
        (n, 8) int32, a node's number, or -1 - number of a leaf; any where there is none
    corner
        (9l, 8) float64 [mm], for each leaf the corners of its triangles, x, y, z each; places left
        over repeat the first corner
    facet
        (l, 8) int32, the triangles' numbers in `normal`, -1 where none; those at the tile's sides
        are there again beyond the opposite ones
    normal
        (t, 3) float64, outward unit normals in the order of the mesh
    """

    box: NDArray[np.float32]
    child: NDArray[np.int32]
    corner: NDArray[np.float64]
    facet: NDArray[np.int32]
    normal: NDArray[np.float64]


@kernel
def _inverse(component):
    return 1.0 / component if component != 0.0 else math.inf


@kernel
def _slab(near, far, box, first, last, origin, inverse):
    """Narrow [near, far] to the boxes' slabs; a NaN (ray in a face) counts as inside."""
    first, last = (load(box, first) - origin) * inverse, (load(box, last) - origin) * inverse
    return select(first > near, first, near), select(last < far, last, far)


@kernel
def _corner(bvh, row, ray, axes):
    """Return a corner of eight facets, relative to a ray's start and turned."""
    return (
        load(bvh.corner, row + axes[0]) - ray[0],
        load(bvh.corner, row + axes[1]) - ray[1],
        load(bvh.corner, row + axes[2]) - ray[2],
    )


@kernel
def closest_facet(bvh, ox, oy, oz, dx, dy, dz, side, slack, farthest):
    """Return (facet or -1, distance) of the first facet up to `farthest` that faces `side`.

    A facet over which the ray starts by no more than the rounding of its start, `slack` [mm], is
    met at distance 0.
    """
    aim = aim_at(dx, dy, dz, side)
    axes = turned(aim.by_x, aim.by_y, 0, 1, 2)
    start = turned(aim.by_x, aim.by_y, ox, oy, oz)
    ix, iy, iz = _inverse(dx), _inverse(dy), _inverse(dz)
    # Rows of the faces by which the ray comes into a box, and of those by which it leaves.
    x_in, y_in, z_in = 0 if ix > 0.0 else 3, 1 if iy > 0.0 else 4, 2 if iz > 0.0 else 5
    x_out, y_out, z_out = 3 - x_in, 5 - y_in, 7 - z_in
    behind = -BEHIND * slack
    node_of = local_wholes(_STACK)
    near_of = local_floats(_STACK)
    lane = local_floats(LANES)
    best = farthest
    found = -1
    node, depth = 0, 0
    while True:
        if node < 0:
            number = -1 - node
            a = _corner(bvh, 9 * number, start, axes)
            b = _corner(bvh, 9 * number + 3, start, axes)
            c = _corner(bvh, 9 * number + 6, start, axes)
            met, beyond, distance = facet_distance(aim, a, b, c, slack)
            met = met & (distance >= behind) & (distance <= best)
            if any_of(met & beyond):
                met = met & ((beyond ^ True) | on_edge(aim, a, b, c, slack))
            mask = bits(met)
            if mask:
                store(lane, 0, distance)
            while mask:
                i = lowest_bit(mask)
                mask &= mask - 1
                facet = bvh.facet[number, i]
                reach = lane[i]
                if reach < 0.0:
                    n = bvh.normal[facet]
                    row = 9 * number
                    px, py = bvh.corner[row, i] - ox, bvh.corner[row + 1, i] - oy
                    pz = bvh.corner[row + 2, i] - oz
                    # By its plane: of a sliver the distance is known to far less than its height.
                    if side * (n[0] * px + n[1] * py + n[2] * pz) < -slack:
                        continue
                    reach = 0.0
                # Of facets at one distance, the first in the mesh: whatever the tree.
                if reach < best or (reach == best and (found < 0 or facet < found)):
                    best, found = reach, facet
        else:
            box = 6 * node
            near, far = spread(behind), spread(best)
            near, far = _slab(near, far, bvh.box, box + x_in, box + x_out, ox, ix)
            near, far = _slab(near, far, bvh.box, box + y_in, box + y_out, oy, iy)
            near, far = _slab(near, far, bvh.box, box + z_in, box + z_out, oz, iz)
            mask = bits(near <= far)
            if mask:
                first = lowest_bit(mask)
                mask &= mask - 1
                if mask == 0:
                    node = bvh.child[node, first]
                    continue
                store(lane, 0, near)
                node_of[depth], near_of[depth] = bvh.child[node, first], lane[first]
                bottom = depth
                depth += 1
                while mask:
                    i = lowest_bit(mask)
                    mask &= mask - 1
                    # The nearest lies on top of the stack.
                    entry = lane[i]
                    k = depth
                    while k > bottom and near_of[k - 1] < entry:
                        near_of[k], node_of[k] = near_of[k - 1], node_of[k - 1]
                        k -= 1
                    near_of[k], node_of[k] = entry, bvh.child[node, i]
                    depth += 1
        while depth > 0 and near_of[depth - 1] > best:
            depth -= 1
        if depth == 0:
            return found, best
        depth -= 1
        node = node_of[depth]


@njit(nogil=True, cache=True, error_model="numpy", _nrt=False)
def closest_facets(bvh, origin, direction, found):
    """Put the first facet that each ray leaves through, or -1, into found (n,) int64.

    origin, direction: (n, 3) float64 [mm], unit.
    """
    for i in range(len(found)):
        o, d = origin[i], direction[i]
        found[i], _ = closest_facet(bvh, o[0], o[1], o[2], d[0], d[1], d[2], 1.0, 0.0, math.inf)


@kernel
def bvh_hit(bvh, size, low, high, x, y, z, dx, dy, dz, inside):
    """Return the next facet a ray meets: (facet or -1, x, y, z, shift x, shift y).

    The ray starts at (x, y, z) [mm] in the tile of `size` (width, length); low, high: lowest and
    highest z of the facets. Shifts [mm] lead back to the coordinates before; facet -1: the ray
    leaves these heights without a hit; -2: it never does.
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
        # Leaving zone and tile is known to the rounding over the slope: much, for a grazing ray.
        leave = math.inf
        if dz != 0.0:
            leave = ((high if upward else low) - z) / dz + slack / abs(dz)
        beyond = math.inf
        if dx != 0.0:
            beyond = to_x + slack / abs(dx)
        if dy != 0.0:
            beyond = min(beyond, to_y + slack / abs(dy))
        # Of a sliver the distance is known to less than the rounding of places.
        reach = min(beyond, leave) + BEHIND * slack
        facet, distance = closest_facet(bvh, x, y, z, dx, dy, dz, side, slack, reach)
        if facet >= 0:
            x, y, z = x + distance * dx, y + distance * dy, z + distance * dz
            return facet, x, y, z, shift_x, shift_y
        # A ray that leaves zone and tile at once may still meet the neighbour's facets there.
        if leave < edge:
            return -1, x, y, z, shift_x, shift_y
        x += edge * dx
        y += edge * dy
        z += edge * dz
        # Exactly onto the opposite side of the tile.
        if to_x <= edge:
            x = 0.0 if dx > 0.0 else width
            shift_x += width if dx > 0.0 else -width
        if to_y <= edge:
            y = 0.0 if dy > 0.0 else length
            shift_y += length if dy > 0.0 else -length
    return -2, x, y, z, shift_x, shift_y
