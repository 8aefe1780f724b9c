"""How a ray walks over the cells of a section, one ray or eight (`lanes`).

In one step it looks at one segment of its cell and, after the last, goes on to the next cell: so
eight rays with lists of different lengths do not wait for each other.
"""

from typing import NamedTuple

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import floor, magnitude, root, select, whole
from mpfcad.optics.base.lanes_array import gather_row

#: Steps after which a ray counts as lost.
_MOST_STEPS = 1e8


class SectionWalk(NamedTuple):
    """A ray's way over a section; of one ray or eight.

    Attributes
    ----------
    x, z, shift
        where it came into the zone [mm], x in the tile that it is in; what leads back to the
        coordinates before [mm]
    ux, uz, speed, flown
        its direction in the cross-section; share of the path that lies there; way into the zone
    column, row, entry, end
        the cell it is in; places in the lists of the segment to look at and of that after the last
    best, place, hit_x, hit_z, hit_shift
        distance [mm] to the nearest segment yet; its place in the lists or -1; where, and `shift`
    turns, steps
        tiles and steps on the way
    """

    x: float
    z: float
    shift: float
    ux: float
    uz: float
    speed: float
    flown: float
    column: float
    row: float
    entry: float
    end: float
    best: float
    place: float
    hit_x: float
    hit_z: float
    hit_shift: float
    turns: float
    steps: float


@kernel
def _clip(value, most):
    return select(value > 0.0, select(value < most, value, most), 0.0)


@kernel
def _steps_of(section, width, low, high):
    """Return columns, rows and the width and height [mm] of a cell."""
    columns, rows = float(section.shape[0]), float(section.shape[1])
    step_z = (high - low) / rows
    return columns, rows, width / columns, (step_z if step_z > 0.0 else width)


@kernel
def start_section(section, width, low, high, x, z, dx, dz, active):
    """Return a ray's walk from (x, z) [mm], and whether there is one: it may miss the zone.

    low, high: lowest and highest z of the section; only rays that are `active` count.
    """
    columns, rows, step_x, step_z = _steps_of(section, width, low, high)
    speed = root(dx * dx + dz * dz)
    level = (speed > 0.0) ^ True
    ux, uz = select(level, 0.0, dx / speed), select(level, 0.0, dz / speed)
    below, above = (z < low) & (uz > 0.0), (z > high) & (uz < 0.0)
    comes = below | above
    flown = select(comes, (select(below, low, high) - z) / uz, 0.0)
    misses = ((z < low) | (z > high)) & (comes ^ True)
    x, z = x + flown * ux, z + flown * uz
    shift = floor(x / width) * width
    x = x - shift
    walking = active & ((misses | level) ^ True)
    # A lane without a ray has no place, and reads none.
    column = _clip(floor(select(walking, x, 0.0) / step_x), columns - 1.0)
    row = _clip(floor((select(walking, z, low) - low) / step_z), rows - 1.0)
    entry, end, _, _ = gather_row(section.cell, whole(row * columns + column))
    zero = x - x
    walk = SectionWalk(
        x, z, shift, ux, uz, speed, flown, column, row, entry, end,
        select(walking, float("inf"), float("inf")), select(walking, -1.0, -1.0),
        zero, zero, zero, select(walking, 0.0, 0.0), select(walking, 0.0, 0.0),
    )  # fmt: skip
    return walk, walking


@kernel
def walk_section(section, width, low, high, walk, side, slack, walking):
    """Look at a segment, and go on to the next cell after the last: (walk, whether it goes on).

    `side` is 1 where the ray is inside the film, else -1; only rays that are walking count.
    """
    columns, rows, step_x, step_z = _steps_of(section, width, low, high)
    x, z, ux, uz, shift = walk.x, walk.z, walk.ux, walk.uz, walk.shift
    best, place, column, row = walk.best, walk.place, walk.column, walk.row
    looks = walking & (walk.entry < walk.end)
    ax, az, bx, bz = gather_row(section.line, whole(select(looks, walk.entry, 0.0)))
    right, up = side * ux, side * uz
    a = right * (az - z) - up * (ax - x)
    b = right * (bz - z) - up * (bx - x)
    part = a / (a - b)
    part = select(part > 0.0, select(part < 1.0, part, 1.0), 0.0)
    at_x, at_z = ax + part * (bx - ax), az + part * (bz - az)
    distance = (at_x - x) * ux + (at_z - z) * uz
    met = looks & (a >= -slack) & (b <= slack) & (a > b)
    met = met & (distance >= -slack) & (distance < best)
    best, place = select(met, distance, best), select(met, walk.entry, place)
    hit_x, hit_z = select(met, at_x, walk.hit_x), select(met, at_z, walk.hit_z)
    hit_shift = select(met, shift, walk.hit_shift)
    entry = walk.entry + 1.0
    # The last of the cell: where the ray leaves it.
    over = walking & (entry >= walk.end)
    ahead_x, ahead_z = ux > 0.0, uz > 0.0
    flat, upright = magnitude(uz) > 0.0, magnitude(ux) > 0.0
    to_x = ((column + select(ahead_x, 1.0, 0.0)) * step_x - x) / ux
    to_z = (low + (row + select(ahead_z, 1.0, 0.0)) * step_z - z) / uz
    to_x = select(upright, to_x, float("inf"))
    to_z = select(flat, to_z, float("inf"))
    across = to_x < to_z
    found = over & (place >= 0.0) & (best <= select(across, to_x, to_z))
    on = over & (found ^ True)
    across = on & across
    column = column + select(across, select(ahead_x, 1.0, -1.0), 0.0)
    row = row + select(on & (across ^ True), select(ahead_z, 1.0, -1.0), 0.0)
    wraps = across & ((column < 0.0) | (column >= columns))
    turn = select(wraps, select(ahead_x, width, -width), 0.0)
    column = select(wraps, select(column < 0.0, columns - 1.0, 0.0), column)
    x, shift, turns = x - turn, shift + turn, walk.turns + select(wraps, 1.0, 0.0)
    steps = walk.steps + 1.0
    # Nothing at this height in a whole tile.
    stuck = wraps & ((turns > 1.0) & (flat ^ True) | (steps > _MOST_STEPS))
    left = on & ((row < 0.0) | (row >= rows))
    walking = walking & ((found | left | stuck) ^ True)
    fresh = on & walking
    first, last, _, _ = gather_row(section.cell, whole(select(fresh, row * columns + column, 0.0)))
    walk = SectionWalk(
        x, z, shift, ux, uz, walk.speed, walk.flown, column, row,
        select(fresh, first, entry), select(fresh, last, walk.end),
        best, place, hit_x, hit_z, hit_shift, turns, steps,
    )  # fmt: skip
    return walk, walking


@kernel
def section_end(walk, stays, astray):
    """Return where a walk has ended: (met, lost, distance, x, z, shift).

    `stays`: there was none, as the ray misses the zone; `astray`: a ray of its side that leaves the
    zone without meeting a segment has come through a hole.
    """
    met = (walk.place >= 0.0) & (stays ^ True)
    distance = select(met, walk.flown + walk.best, walk.flown)
    distance = select(distance > 0.0, distance, 0.0) / walk.speed
    moves = walk.speed > 0.0
    distance = select(moves, distance, 0.0)
    x, z = select(met, walk.hit_x, walk.x), select(met, walk.hit_z, walk.z)
    shift = select(met, walk.hit_shift, walk.shift)
    uz = magnitude(walk.uz)
    # Level in the section it never leaves.
    endless = (stays ^ True) & (((uz > 0.0) ^ True) | (walk.steps > _MOST_STEPS))
    lost = (met ^ True) & (astray | endless | (moves ^ True))
    return met, lost, distance, x, z, shift


@kernel
def section_hit(section, width, low, high, underside, x, z, dx, dz, inside):
    """Return the next segment that a ray meets: (its place or -1, distance, x, z, shift).

    The ray starts at (x, z) [mm], inside or outside the film; low, high: lowest and highest z of
    the section. `shift` [mm] is what to add to x to be in the same coordinates as before; place -1:
    the ray leaves the section's heights without a hit, -2: it was lost.
    """
    side = 1.0 if inside else -1.0
    slack = section_slack(width, high)
    walk, walking = start_section(section, width, low, high, x, z, dx, dz, True)
    stays = not walking
    while walking:
        walk, walking = walk_section(section, width, low, high, walk, side, slack, walking)
    astray = is_astray(underside, inside, dz)
    met, lost, distance, x, z, shift = section_end(walk, stays, astray)
    place = int(walk.place) if met else -1
    return (-2 if lost else place), distance, x, z, shift


@kernel
def section_slack(width, high):
    """Return the rounding [mm] of coordinates in the tile."""
    return 16 * 2.3e-16 * max(width, high)


@kernel
def is_astray(underside, inside, dz):
    """Return whether a ray that meets nothing more has come through a hole.

    From inside there is only the flat underside to reach without a segment, from it no air.
    """
    rises = dz > 0.0
    # (rises or no underside) and inside, or (falls over an underside) and outside.
    return (inside ^ True) ^ (rises | (underside ^ True))
