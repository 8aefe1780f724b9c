"""How rays in lanes come into the layers of a section, and from strip to strip."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import any_of, floor, magnitude, select, whole
from mpfcad.optics.base.lanes_array import gather_line, gather_row

#: Rays that are flatter go through a band from strip to strip.
_LEVEL = 1e-4


@kernel
def layers_entry(layers, width, low, high, banded, x, z, dx, dz):
    """Return where a ray comes into the zone of the section, or leaves its band: (part, shift).

    The zone is from `low` to `high` [mm]; rays that are `banded` are within its band.
    Less `shift` [mm] the ray's x is in the coordinates in which the entry lies in [0, width]; x and
    dx are leaned.
    """
    upward = dz > 0.0
    begin, end = select(banded, layers.lean[1], high), select(banded, layers.lean[2], low)
    flight = (select(upward, end, begin) - z) / dz
    entry = x + select(flight > 0.0, flight, 0.0) * dx
    shift = floor(entry / width) * width
    entry = entry - shift
    entry = select(entry > 0.0, select(entry < width, entry, width), 0.0)
    cells = 0.25 * len(layers.cell)
    place = entry * (cells / width)
    place = floor(select(place < cells - 1.0, place, cells - 1.0))
    row = 4.0 * place + select(upward, 1.0, 0.0) + select(banded, 2.0, 0.0)
    first, after, between, strip = gather_row(layers.cell, whole(row))
    part = select(entry >= between, after, first)
    several = strip >= 0.0
    while any_of(several):
        end, lowest, highest, below = gather_row(layers.strip, whole(select(several, strip, 0.0)))
        up, down = select(banded, below + 1.0, lowest), select(banded, below, highest)
        part = select(several, select(upward, up, down), part)
        several = several & (entry >= end)
        strip = strip + 1.0
    return part, shift


@kernel
def part_data(layers, part):
    """Return a part's `run_data` and the rest of its `Layers.range`.

    (ends, level under it, level over it, what z is to be multiplied by, whether the film is over
    it, part under it, part over it)
    """
    part = whole(part)
    x0, z0, x1, z1, a, b, c, density = gather_line(layers.part, part)
    first, last, start, low, high, turn, below, above = gather_line(layers.range, part)
    ends = x0, z0, x1, z1, a, b, c, density, first, last, start
    hill = magnitude(turn) > 1.5
    return ends, low, high, select(hill, 0.5, 1.0) * turn, hill, below, above


@kernel
def part_across(under, low, high, turn, below, above, z, dz):
    """Return what is across the cell that a ray under or over a part is in: (part, spared, body).

    Part -1: none. It is spared if there is none, or the ray goes off from it and is beyond all of
    it; a body in the cell's way may be met before the part. z and dz are not turned.
    """
    other = select(under, below, above)
    number = floor(other)
    side = select(under, turn, -1.0 * turn)
    beyond = (z - turn * select(under, low, high)) * side > 0.0
    return number, (other < 0.0) | ((dz * side >= 0.0) & beyond), other > number


@kernel
def next_part(layers, ends, level, part, under, x, z, dx, dz):
    """Return the part to look at in the next strip, what to take from x, and whether it is spared.

    (part, shift, gone, banded): gone rays come to the `level` of the zone, in the next strip,
    without meeting anything; banded ones come to it in the band. x, dx are leaned; z and dz are not
    turned.
    """
    right, upward = dx > 0.0, dz > 0.0
    speed, rise = magnitude(dx), select(right, dz, -dz)
    x0, _, x1, _, _, _, _, _, _, _, _ = ends
    way = (select(right, x1, x0) - x) * rise
    row = part * 8.0 + select(upward, 4.0, 0.0) + select(under, 2.0, 0.0)
    row = row + select(right, 1.0, 0.0)
    below, split, above, shift, end, clear, clear_above, _ = gather_line(layers.aside, whole(row))
    passes = (split - z) * speed - way >= 0.0
    part, clear = select(passes, below, above), select(passes, clear, clear_above)
    while any_of(part < 0.0):
        asks = part < 0.0
        below, split, above, _, _, low, high, _ = gather_line(
            layers.aside, whole(select(asks, -1.0 - part, 0.0))
        )
        passes = (split - z) * speed - way >= 0.0
        part = select(asks, select(passes, below, above), part)
        clear = select(asks, select(passes, low, high), clear)
    side = select(upward, -1.0, 1.0)
    gone = ((clear - z) * side > 0.0) & (dz * side < 0.0)
    gone = gone & (((end - x) * rise - (level - z) * speed) * side < 0.0)
    bottom, top = layers.lean[1], layers.lean[2]
    banded = ((bottom - z) * speed < way) & ((top - z) * speed > way)
    return part, shift, gone, banded & (magnitude(dz) > _LEVEL * speed)
