"""Fields of small cells as a uniform grid over x, y that a ray walks cell by cell.

Each cell lists the facets over it and their z range. Facets commonly end on the lines between
cells, to the rounding of their corners: so a facet is listed only where it reaches more than
`MARGIN` of a cell over a line, and a ray visits all cells that it comes as near to. Which facet is
met is decided by the formula of `triangle` alone: the least distance, and among equals the least
number, as in `bvh`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes_array import gather_row
from mpfcad.optics.search.grid.walk import start_walk, walk_on
from mpfcad.optics.search.tiling import MOST_TILES, arrive, into_tile, rounding, to_zone


class Grid(NamedTuple):
    """A uniform grid over the facets of a tile.

    Attributes
    ----------
    count
        (2,) int64, cells along x and y
    cell
        (c, 4) float64, column of x after column: lowest and highest z [mm] of the facets listed,
        where their list begins, how many they are
    corner
        (3e, 4) float64, three rows for each place of a list: the corners [mm] and the outward unit
        normal of its facet
    facet
        (e,) int64, the facets' numbers in the order of the mesh; those at the tile's sides are
        listed again beyond the opposite ones
    """

    count: NDArray[np.int64]  # type: ignore[assignment]  # a tuple has a `count` of its own
    cell: NDArray[np.float64]
    corner: NDArray[np.float64]
    facet: NDArray[np.int64]


@kernel
def grid_hit(grid, size, low, high, x, y, z, dx, dy, dz, inside):
    """Return the next facet a ray meets: (place or -1, x, y, z, shift x, shift y, normal).

    The ray starts at (x, y, z) [mm] in the tile of `size` (width, length); low, high: lowest and
    highest z of the top. `place` is that in the grid's lists. Shifts [mm] lead back to the
    coordinates before; place -1: the ray leaves the zone of the top without a hit; -2: it was lost
    (a hole).
    """
    side = 1.0 if inside else -1.0
    slack = rounding(size, high)
    x, y, z = to_zone(low, high, x, y, z, dx, dy, dz, inside, True)
    shift_x, shift_y = 0.0, 0.0
    for _ in range(MOST_TILES):
        turn_x, turn_y = into_tile(size[0], x), into_tile(size[1], y)
        x, y = x - turn_x, y - turn_y
        shift_x, shift_y = shift_x + turn_x, shift_y + turn_y
        walk = start_walk(grid, size, low, high, x, y, z, dx, dy, dz)
        walking = True
        while walking:
            walk, walking = walk_on(grid, walk, x, y, z, dx, dy, dz, side, slack, walking)
        ways = walk.to_x, walk.to_y, walk.edge, walk.leave
        met, turning, x, y, z, turn_x, turn_y = arrive(
            size, ways, walk.place >= 0, walk.best, x, y, z, dx, dy, dz, True
        )
        shift_x, shift_y = shift_x + turn_x, shift_y + turn_y
        if met:
            _, nx, ny, nz = gather_row(grid.corner, walk.place * 3 + 2)
            return walk.place, x, y, z, shift_x, shift_y, nx, ny, nz
        if not turning:
            lost = inside == (dz > 0.0)
            return (-2 if lost else -1), x, y, z, shift_x, shift_y, 0.0, 0.0, 1.0
    return -2, x, y, z, shift_x, shift_y, 0.0, 0.0, 1.0
