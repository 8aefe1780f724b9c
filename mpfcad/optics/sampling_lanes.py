"""The random numbers of eight paths at once: those of `sampling`, from generators in lanes."""

from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import real, select
from mpfcad.optics.sampling import philox4x32

_TO_UNIT = 2.0**-53


@kernel
def next_two(key0, key1, path0, path1, stream, draw, spare, has):
    """Return the next two numbers of each path, uniform in [0, 1), and the last of its next draw.

    The arguments are a generator's entries, `has` a mask.
    """
    a, b, c, d = philox4x32(draw, stream, path0, path1, key0, key1)
    fore, aft = (a << 32) | b, (c << 32) | d
    one = real(select(has, spare, fore) >> 11) * _TO_UNIT
    two = real(select(has, fore, aft) >> 11) * _TO_UNIT
    return one, two, aft


@kernel
def take(draw, spare, has, aft, one, both):
    """Return (draw, spare, has) after `one` or `both` of the next two numbers were used."""
    drawn = both | (one & (has ^ True))
    return select(drawn, draw + 1, draw), select(drawn, aft, spare), has ^ one
