"""How a ray goes down a tree of boxes to the first facet, eight children or facets at a time."""

import math
from typing import NamedTuple

from mpfcad.optics.base.kernel import entry, kernel
from mpfcad.optics.base.lanes import LANES, any_of, bits, lowest_bit, select, spread
from mpfcad.optics.base.lanes_array import load, local_floats, local_wholes, store
from mpfcad.optics.search.triangle import BEHIND, Aim, aim_at, facet_distance, on_edge, turned

_STACK = 256


class _Ray(NamedTuple):
    """A ray for the tree: where it starts, how it goes, and how it is aimed at facets.

    Attributes
    ----------
    x, y, z
        start [mm]
    ix, iy, iz
        1 over the direction's components, infinite where 0
    side, slack
        1: facets count that it leaves through, -1: that it enters; rounding of its start [mm]
    aim, axes, start
        its projection; the axes, and its start, `turned` as that asks
    """

    x: float
    y: float
    z: float
    ix: float
    iy: float
    iz: float
    side: float
    slack: float
    aim: Aim
    axes: tuple[int, int, int]
    start: tuple[float, float, float]


@kernel
def _inverse(component):
    return 1.0 / component if component != 0.0 else math.inf


@kernel
def _slab(near, far, box, first, last, origin, inverse):
    """Narrow [near, far] to the boxes' slabs; a NaN (ray in a face) counts as inside."""
    first, last = (load(box, first) - origin) * inverse, (load(box, last) - origin) * inverse
    return select(first > near, first, near), select(last < far, last, far)


@kernel
def _corner(bvh, row, ray):
    """Return a corner of eight facets, relative to a ray's start and turned."""
    return (
        load(bvh.corner, row + ray.axes[0]) - ray.start[0],
        load(bvh.corner, row + ray.axes[1]) - ray.start[1],
        load(bvh.corner, row + ray.axes[2]) - ray.start[2],
    )


@kernel
def _children(bvh, node, ray, nearest, farthest):
    """Return (distances, mask) of a node's children whose boxes a ray meets between two."""
    # Rows of the faces by which the ray comes into a box; it leaves by the opposite ones.
    x_in, y_in, z_in = (
        0 if ray.ix > 0.0 else 3, 1 if ray.iy > 0.0 else 4, 2 if ray.iz > 0.0 else 5
    )  # fmt: skip
    box = 6 * node
    near, far = spread(nearest), spread(farthest)
    near, far = _slab(near, far, bvh.box, box + x_in, box + 3 - x_in, ray.x, ray.ix)
    near, far = _slab(near, far, bvh.box, box + y_in, box + 5 - y_in, ray.y, ray.iy)
    near, far = _slab(near, far, bvh.box, box + z_in, box + 7 - z_in, ray.z, ray.iz)
    return near, bits(near <= far)


@kernel
def _in_leaf(bvh, number, ray, lane, best, found):
    """Return (distance, facet) of the nearest of a leaf's facets and what was found before."""
    row = 9 * number
    a, b, c = _corner(bvh, row, ray), _corner(bvh, row + 3, ray), _corner(bvh, row + 6, ray)
    met, beyond, distance = facet_distance(ray.aim, a, b, c, ray.slack)
    met = met & (distance >= -BEHIND * ray.slack) & (distance <= best)
    if any_of(met & beyond):
        met = met & ((beyond ^ True) | on_edge(ray.aim, a, b, c, ray.slack))
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
            x, y = bvh.corner[row, i] - ray.x, bvh.corner[row + 1, i] - ray.y
            z = bvh.corner[row + 2, i] - ray.z
            # By its plane: of a sliver the distance is known to far less than its height.
            if ray.side * (n[0] * x + n[1] * y + n[2] * z) < -ray.slack:
                continue
            reach = 0.0
        # Of facets at one distance, the first in the mesh: whatever the tree.
        if reach < best or (reach == best and (found < 0 or facet < found)):
            best, found = reach, facet
    return best, found


@kernel
def closest_facet(bvh, ox, oy, oz, dx, dy, dz, side, slack, farthest):
    """Return (facet or -1, distance) of the first facet up to `farthest` that faces `side`.

    A facet over which the ray starts by no more than the rounding of its start, `slack` [mm], is
    met at distance 0.
    """
    aim = aim_at(dx, dy, dz, side)
    axes = turned(aim.by_x, aim.by_y, 0, 1, 2)
    start = turned(aim.by_x, aim.by_y, ox, oy, oz)
    ray = _Ray(
        ox, oy, oz, _inverse(dx), _inverse(dy), _inverse(dz), side, slack, aim, axes, start
    )  # fmt: skip
    node_of = local_wholes(_STACK)
    near_of = local_floats(_STACK)
    lane = local_floats(LANES)
    best, found = farthest, -1
    node, depth = 0, 0
    while True:
        if node < 0:
            best, found = _in_leaf(bvh, -1 - node, ray, lane, best, found)
        else:
            near, mask = _children(bvh, node, ray, -BEHIND * slack, best)
            if mask & (mask - 1):
                store(lane, 0, near)
            elif mask:
                node = bvh.child[node, lowest_bit(mask)]
                continue
            bottom = depth
            while mask:
                i = lowest_bit(mask)
                mask &= mask - 1
                # The nearest lies on top of the stack.
                k = depth
                while k > bottom and near_of[k - 1] < lane[i]:
                    near_of[k], node_of[k] = near_of[k - 1], node_of[k - 1]
                    k -= 1
                near_of[k], node_of[k] = lane[i], bvh.child[node, i]
                depth += 1
        while depth > 0 and near_of[depth - 1] > best:
            depth -= 1
        if depth == 0:
            return found, best
        depth -= 1
        node = node_of[depth]


@entry
def closest_facets(bvh, origin, direction, found):
    """Put the first facet that each ray leaves through, or -1, into found (n,) int64.

    origin, direction: (n, 3) float64 [mm], unit.
    """
    for i in range(len(found)):
        o, d = origin[i], direction[i]
        found[i], _ = closest_facet(bvh, o[0], o[1], o[2], d[0], d[1], d[2], 1.0, 0.0, math.inf)
