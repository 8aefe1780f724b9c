"""How a ray comes to the zone of a film's top, and from tile to tile: one ray or eight."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import floor, magnitude, select
from mpfcad.optics.search.triangle import BEHIND

#: Tiles after which a ray counts as lost.
MOST_TILES = 1_000_000


@kernel
def rounding(size, high):
    """Return the rounding [mm] of coordinates in the tile."""
    return 16 * 2.3e-16 * max(size[0], size[1], high)


@kernel
def to_zone(low, high, x, y, z, dx, dy, dz, inside, fresh):
    """Return the point at which a fresh ray comes to the zone of the top, low…high [mm]."""
    upward = dz > 0.0
    below, above = inside & upward & (z < low), ((inside | upward) ^ True) & (z > high)
    free = select(below, (low - z) / dz, select(above, (high - z) / dz, 0.0))
    free = select(fresh & (below | above), free, 0.0)
    return x + free * dx, y + free * dy, z + free * dz


@kernel
def into_tile(extent, at):
    """Return what to take from a coordinate so that it lies in the tile [mm]."""
    return select((at >= 0.0) & (at <= extent), 0.0, floor(at / extent)) * extent


@kernel
def ways_out(size, low, high, x, y, z, dx, dy, dz):
    """Return distances [mm] (to the sides along x, along y, to the nearer, out of the zone, reach).

    `reach`: how far facets count that are met in this tile.
    """
    width, length = size
    slack = rounding(size, high)
    to_x = (select(dx > 0.0, width, 0.0) - x) / dx
    to_x = select(magnitude(dx) > 0.0, to_x, float("inf"))
    to_y = (select(dy > 0.0, length, 0.0) - y) / dy
    to_y = select(magnitude(dy) > 0.0, to_y, float("inf"))
    edge = select(to_x < to_y, to_x, to_y)
    edge = select(edge > 0.0, edge, 0.0)
    # Leaving the zone is known to the rounding of z over the slope: much, for a grazing ray.
    leave = (select(dz > 0.0, high, low) - z) / dz + slack / magnitude(dz)
    leave = select(magnitude(dz) > 0.0, leave, float("inf"))
    # And leaving the tile.
    beyond_x = to_x + select(magnitude(dx) > 0.0, slack / magnitude(dx), 0.0)
    beyond_y = to_y + select(magnitude(dy) > 0.0, slack / magnitude(dy), 0.0)
    reach = select(beyond_x < beyond_y, beyond_x, beyond_y)
    # Of a sliver the distance is known to less than the rounding of places.
    reach = select(reach < leave, reach, leave) + BEHIND * slack
    return to_x, to_y, edge, leave, reach


@kernel
def arrive(size, ways, met, distance, x, y, z, dx, dy, dz, done):
    """Return (met, turning, x, y, z, shift x, shift y) of the rays whose way over a tile is done.

    Those that met a facet, at a distance, are put there, and those that turn into the next tile on
    its side; the others leave the zone of the top. `ways` is what `ways_out` gave but the last;
    shifts [mm] lead back to the coordinates before.
    """
    to_x, to_y, edge, leave = ways
    width, length = size
    met = done & met
    # A ray that leaves zone and tile at once may still meet the neighbour's facets there.
    turning = done & ((leave < edge) ^ True) & (met ^ True)
    flight = select(met, distance, edge)
    moved = met | turning
    x = select(moved, x + flight * dx, x)
    y = select(moved, y + flight * dy, y)
    z = select(moved, z + flight * dz, z)
    # Exactly onto the opposite side of the tile.
    over = turning & (to_x <= edge)
    x = select(over, select(dx > 0.0, 0.0, width), x)
    shift_x = select(over, select(dx > 0.0, width, -width), 0.0)
    over = turning & (to_y <= edge)
    y = select(over, select(dy > 0.0, 0.0, length), y)
    shift_y = select(over, select(dy > 0.0, length, -length), 0.0)
    return met, turning, x, y, z, shift_x, shift_y
