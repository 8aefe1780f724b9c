"""How a ray walks over the cells of a grid, one ray or eight (`lanes`).

Column by column along the axis on which it is faster, and through the one or two rows that it
passes there (after Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", 1987).
"""

from typing import NamedTuple

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import any_of, copy_sign, floor, magnitude, select, whole
from mpfcad.optics.base.lanes_array import gather, gather_row
from mpfcad.optics.search.tiling import ways_out
from mpfcad.optics.search.triangle import BEHIND, aim_at, facet_distance, on_edge, turned

#: How far [cells] a facet may reach over a line unlisted; a ray's reach is wider by its rounding.
MARGIN = 1 / 64
_REACH = MARGIN * 1.001
_STEEP = 1e-12


class Walk(NamedTuple):
    """A ray's way over a tile; of one ray or eight.

    Attributes
    ----------
    to_x, to_y, edge, leave
        distance [mm] to the tile's sides, to the nearer, and out of the zone of the top
    best, place
        distance [mm] to the nearest facet yet, or how far is searched; its place in the lists or -1
    along_x, p, q, speed_p, speed_q
        whether it is faster along x; start [cells] and speed [cells/mm] along that axis and across
    column, last, row, rows
        the cell it is in, along p and across; the last column; rows after this one in the column
    low, high
        z range [mm] of the ray in the column
    """

    to_x: float
    to_y: float
    edge: float
    leave: float
    best: float
    place: int
    along_x: bool
    p: float
    q: float
    speed_p: float
    speed_q: float
    column: float
    last: float
    row: float
    rows: float
    low: float
    high: float


@kernel
def _clip(value, most):
    return select(value > 0.0, select(value < most, value, most), 0.0)


@kernel
def _enter(walk, z, dz, column, across):
    """Return (nearest distance, row, rows after it, lowest z, highest z) in a column."""
    step = copy_sign(1.0, walk.speed_p)
    steep = magnitude(walk.speed_p) < _STEEP
    begin = select(walk.speed_p < 0.0, column + 1.0, column) - step * _REACH
    near = select(steep, 0.0, (begin - walk.p) / walk.speed_p)
    far = (begin + step * (1.0 + 2.0 * _REACH) - walk.p) / walk.speed_p
    near = select(near > 0.0, near, 0.0)
    far = select(steep | (far > walk.best), walk.best, far)
    a, b = walk.q + near * walk.speed_q, walk.q + far * walk.speed_q
    first = _clip(floor(select(a < b, a, b) - _REACH), across)
    final = _clip(floor(select(a < b, b, a) + _REACH), across)
    a, b = z + near * dz, z + far * dz
    row = select(walk.speed_q < 0.0, final, first)
    return near, row, final - first, select(a < b, a, b), select(a < b, b, a)


@kernel
def start_walk(grid, size, low, high, x, y, z, dx, dy, dz):
    """Return the walk of a ray from (x, y, z) [mm] in the tile, through the zone low…high."""
    width, length = size
    nx, ny = float(grid.count[0]), float(grid.count[1])
    to_x, to_y, edge, leave, best = ways_out(size, low, high, x, y, z, dx, dy, dz)
    p, q = x * (nx / width), y * (ny / length)
    # A speed of -0 is 0: it has no sign to step by.
    speed_p, speed_q = dx * (nx / width) + 0.0, dy * (ny / length) + 0.0
    along_x = magnitude(speed_p) >= magnitude(speed_q)
    p, q = select(along_x, p, q), select(along_x, q, p)
    speed_p, speed_q = select(along_x, speed_p, speed_q), select(along_x, speed_q, speed_p)
    step = copy_sign(_REACH, speed_p)
    most = select(along_x, nx - 1.0, ny - 1.0)
    column = _clip(floor(p - step), most)
    last = _clip(floor(p + best * speed_p + step), most)
    none = select(along_x, -1, -1)
    walk = Walk(
        to_x, to_y, edge, leave, best, none, along_x, p, q, speed_p, speed_q,
        column, last, column, column, z, z,
    )  # fmt: skip
    across = select(along_x, ny - 1.0, nx - 1.0)
    _, row, rows, lowest, highest = _enter(walk, z, dz, column, across)
    return _with(walk, best, none, column, row, rows, lowest, highest)


@kernel
def no_walk(zero, nowhere, no):
    """Return the walks of lanes that are empty."""
    z = zero
    return Walk(z, z, z, z, z, nowhere, no, z, z, z, z, z, z, z, z, z, z)


@kernel
def _with(walk, best, place, column, row, rows, low, high):
    """Return a walk with another state."""
    return Walk(
        walk.to_x, walk.to_y, walk.edge, walk.leave, best, place,
        walk.along_x, walk.p, walk.q, walk.speed_p, walk.speed_q, column, walk.last, row, rows,
        low, high,
    )  # fmt: skip


@kernel
def choose(mask, a, b):
    """Return the walks of a where the mask holds, else of b."""
    return Walk(
        select(mask, a.to_x, b.to_x), select(mask, a.to_y, b.to_y), select(mask, a.edge, b.edge),
        select(mask, a.leave, b.leave), select(mask, a.best, b.best),
        select(mask, a.place, b.place), select(mask, a.along_x, b.along_x), select(mask, a.p, b.p),
        select(mask, a.q, b.q), select(mask, a.speed_p, b.speed_p),
        select(mask, a.speed_q, b.speed_q), select(mask, a.column, b.column),
        select(mask, a.last, b.last), select(mask, a.row, b.row), select(mask, a.rows, b.rows),
        select(mask, a.low, b.low), select(mask, a.high, b.high),
    )  # fmt: skip


@kernel
def walk_on(grid, walk, x, y, z, dx, dy, dz, side, slack, walking):
    """Visit the cell in which a ray is and go on to the next: (walk, whether it goes on).

    `side` is 1 where the ray is inside the film, else -1; only rays that are walking count.
    """
    nx, ny = float(grid.count[0]), float(grid.count[1])
    x_cell = select(walk.along_x, walk.column, walk.row)
    y_cell = select(walk.along_x, walk.row, walk.column)
    # A ray that waits for others to arrive steps on with them, out of the grid: it reads no cell.
    cell = select(walking, whole(x_cell * ny + y_cell), 0)
    low, high, begin, number = gather_row(grid.cell, cell)
    best, place = walk.best, walk.place
    near = walking & (low <= walk.high) & (high >= walk.low)
    number = select(near, number, 0.0)
    begin = whole(begin)
    aim = aim_at(dx, dy, dz, side)
    behind = -BEHIND * slack
    done = 0.0
    while any_of(number > done):
        entry = select(number > done, begin, 0)
        ax, ay, az, bx = gather_row(grid.corner, entry * 3)
        by, bz, cx, cy = gather_row(grid.corner, entry * 3 + 1)
        cz, _, _, _ = gather_row(grid.corner, entry * 3 + 2)
        a = turned(aim.by_x, aim.by_y, ax - x, ay - y, az - z)
        b = turned(aim.by_x, aim.by_y, bx - x, by - y, bz - z)
        c = turned(aim.by_x, aim.by_y, cx - x, cy - y, cz - z)
        met, beyond, distance = facet_distance(aim, a, b, c, slack)
        met = met & (number > done) & (distance >= behind) & (distance <= best)
        over = distance < 0.0
        if any_of(met & (beyond | over)):
            met = met & ((beyond ^ True) | on_edge(aim, a, b, c, slack))
            _, across_x, across_y, across_z = gather_row(grid.corner, entry * 3 + 2)
            gap = (ax - x) * across_x + (ay - y) * across_y + (az - z) * across_z
            met = met & ((distance >= 0.0) | (side * gap >= -slack))
            distance = select(over, 0.0, distance)
        again = met & (place >= 0) & (distance == best)
        if any_of(again):
            later = gather(grid.facet, entry) >= gather(grid.facet, select(again, place, 0))
            met = met & ((again & later) ^ True)
        best = select(met, distance, best)
        place = select(met, entry, place)
        begin = begin + 1
        done += 1.0
    more = walk.rows > 0.0
    row = select(more, walk.row + copy_sign(1.0, walk.speed_q), walk.row)
    rows = select(more, walk.rows - 1.0, walk.rows)
    column = select(more, walk.column, walk.column + copy_sign(1.0, walk.speed_p))
    ended = (more ^ True) & (walk.column == walk.last)
    walk = _with(walk, best, place, column, row, rows, walk.low, walk.high)
    fresh = walking & ((more | ended) ^ True)
    if any_of(fresh):
        across = select(walk.along_x, ny - 1.0, nx - 1.0)
        near, row, rows, low, high = _enter(walk, z, dz, column, across)
        ended = ended | (fresh & (near > best))
        walk = _with(
            walk, best, place, column, select(fresh, row, walk.row), select(fresh, rows, walk.rows),
            select(fresh, low, walk.low), select(fresh, high, walk.high),
        )  # fmt: skip
    return walk, walking & (ended ^ True)
