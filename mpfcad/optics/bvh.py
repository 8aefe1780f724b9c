"""Any film top as a tree of boxes over its triangles: the accelerator for what nothing else takes.

Nodes have up to eight children and leaves up to eight triangles; both are tested eight at a time
(`lanes`), after Wald, Benthin and Boulos, "Getting rid of packets", 2008. Children are met nearest
first. The film repeats as a tile: a ray that leaves one side comes back in at the opposite one.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.bvh_walk import closest_facet
from mpfcad.optics.kernel import kernel
from mpfcad.optics.triangle import BEHIND


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
