"""The random numbers of eight paths at once: those of `sampling`, from generators in lanes."""

import numpy as np
from numba import int64

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import LANES, any_of, real, select, spread
from mpfcad.optics.base.lanes_array import load
from mpfcad.optics.base.net import DIMENSIONS, NET
from mpfcad.optics.base.sampling import KEYS, net_number, philox4x32

_TO_UNIT = 2.0**-53
_LOW = 0xFFFFFFFF
_NET_DIGITS = NET.bit_length() - 1
_COUNT = np.arange(LANES, dtype=np.int64).reshape(1, LANES)


@kernel
def start_net_paths(seed, stream, path, points):
    """Return the generators of eight paths from `path` on, as `start_net_path` sets them.

    (key0, key1, path0, path1, stream, draw, spare), and each path's point.
    """
    number = load(_COUNT, 0)
    turn = spread(int64(path // points))
    point = number + int64(path % points)
    around = int64(points)
    while any_of(point >= around):
        over = select(point >= around, 1, 0)
        point, turn = point - over * around, turn + over
    number = number + int64(path)
    path0, path1 = number & _LOW, number >> 32
    key0, key1 = spread(int64(seed)) & _LOW, spread(int64(seed)) >> 32
    stream = spread(int64(stream))
    net = (turn >> _NET_DIGITS) * around + point
    every = (net ^ net) | KEYS
    a, b, _, _ = philox4x32(every, stream, net & _LOW, net >> 32, key0, key1)
    spare = (((a << 32) | b) & -NET) | (turn & (NET - 1))
    return key0, key1, path0, path1, stream, (net ^ net) - DIMENSIONS, spare, point


@kernel
def next_two(key0, key1, path0, path1, stream, draw, spare, has):
    """Return the next two numbers of each path, uniform in [0, 1), and the last of its next draw.

    The arguments are a generator's entries, `has` a mask.
    """
    fore, aft = spare, spare
    if any_of(draw > -2):
        a, b, c, d = philox4x32(select(draw < 0, 0, draw), stream, path0, path1, key0, key1)
        fore, aft = (a << 32) | b, (c << 32) | d
    one, two = select(has, spare, fore), select(has | (draw < 0), fore, aft)
    if any_of(draw < 0):
        one = select(draw < 0, net_number(spare, draw), one)
        two = select(draw < -1, net_number(spare, draw + 1), two)
    return real(one >> 11) * _TO_UNIT, real(two >> 11) * _TO_UNIT, aft


@kernel
def take(draw, spare, has, aft, one, both):
    """Return (draw, spare, has) after `one` or `both` of the next two numbers were used."""
    of_net = draw < 0
    rest = of_net ^ True
    # The last of the net, and the first of the draw after it.
    across = both & (draw == -1)
    drawn = ((both | (one & (has ^ True))) & rest) | across
    steps = select(of_net, select(both, 2, select(one, 1, 0)), select(drawn, 1, 0))
    return draw + steps, select(drawn, aft, spare), (has ^ (one & rest)) | across
