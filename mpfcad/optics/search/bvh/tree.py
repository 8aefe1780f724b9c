"""Any film top as a tree of boxes over its triangles: the accelerator for what nothing else takes.

Nodes have up to eight children and leaves up to eight triangles; both are tested eight at a time
(`lanes`), after Wald, Benthin and Boulos, "Getting rid of packets", 2008. Children are met nearest
first. The film repeats as a tile: a ray that leaves one side comes back in at the opposite one.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.search.bvh.walk import closest_facet
from mpfcad.optics.search.tiling import MOST_TILES, arrive, into_tile, rounding, to_zone, ways_out


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
    side = 1.0 if inside else -1.0
    slack = rounding(size, high)
    x, y, z = to_zone(low, high, x, y, z, dx, dy, dz, inside, True)
    shift_x, shift_y = 0.0, 0.0
    for _ in range(MOST_TILES):
        turn_x, turn_y = into_tile(size[0], x), into_tile(size[1], y)
        x, y = x - turn_x, y - turn_y
        shift_x, shift_y = shift_x + turn_x, shift_y + turn_y
        to_x, to_y, edge, leave, reach = ways_out(size, low, high, x, y, z, dx, dy, dz)
        facet, distance = closest_facet(bvh, x, y, z, dx, dy, dz, side, slack, reach)
        ways = to_x, to_y, edge, leave
        met, turning, x, y, z, turn_x, turn_y = arrive(
            size, ways, facet >= 0, distance, x, y, z, dx, dy, dz, True
        )
        shift_x, shift_y = shift_x + turn_x, shift_y + turn_y
        if met or not turning:
            return facet, x, y, z, shift_x, shift_y
    return -2, x, y, z, shift_x, shift_y
