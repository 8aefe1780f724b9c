"""The random numbers of eight paths at once: those of `sampling`, from generators in lanes."""

import numpy as np
from numba import int64

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import LANES, any_of, real, select, spread
from mpfcad.optics.base.lanes_array import gather_first_half, load, load_from, store
from mpfcad.optics.base.net import DIMENSIONS, NET
from mpfcad.optics.base.sampling import KEYS, net_number, philox4x32

_TO_UNIT = 2.0**-53
_LOW = 0xFFFFFFFF
_NET_DIGITS = NET.bit_length() - 1
_COUNT = np.arange(LANES, dtype=np.int64).reshape(1, LANES)


@kernel
def net_keys(seed, stream, path, points, keys):
    """Put into keys (n, 8) those of the net of a path, of each of `points`, then round again."""
    net = int64(path // points) >> _NET_DIGITS
    for i in range(len(keys)):
        point = _around(LANES * i, points)
        store(keys, i, _net_key(seed, stream, net * int64(points) + point))


@kernel
def _around(first, points):
    """Return eight numbers from `first` on, modulo the number of points."""
    around = int64(points)
    point = load(_COUNT, 0) + int64(first) % around
    while any_of(point >= around):
        point = point - select(point >= around, around, 0)
    return point


@kernel
def _net_key(seed, stream, net):
    """Return the keys of eight nets, the lowest digits 0."""
    key0, key1 = spread(int64(seed)) & _LOW, spread(int64(seed)) >> 32
    every = (net ^ net) | KEYS
    a, b, _, _ = philox4x32(every, spread(int64(stream)), net & _LOW, net >> 32, key0, key1)
    return ((a << 32) | b) & -NET


@kernel
def start_net_paths(seed, stream, first, path, points, keys):
    """Return the generators of eight paths from `path` on, as `start_net_path` sets them.

    (key0, key1, path0, path1, stream, draw, spare), and each path's point. `keys` are the
    `net_keys` of path `first`.
    """
    begin, start = int64(path // points), int64(path % points)
    around = int64(points)
    turn, point = spread(begin), load(_COUNT, 0) + start
    while any_of(point >= around):
        over = select(point >= around, 1, 0)
        point, turn = point - over * around, turn + over
    number = load(_COUNT, 0) + int64(path)
    # Of the last path no later turn than this.
    end = begin if start + LANES <= around else begin + LANES
    net = int64(first // points) >> _NET_DIGITS
    known = begin >> _NET_DIGITS == net and end >> _NET_DIGITS == net
    if known and start + LANES <= LANES * len(keys):
        key = load_from(keys, start)
    else:
        key = _net_key(seed, stream, (turn >> _NET_DIGITS) * around + point)
    key0, key1 = spread(int64(seed)) & _LOW, spread(int64(seed)) >> 32
    draw = spread(-DIMENSIONS)
    return (
        key0, key1, number & _LOW, number >> 32, spread(int64(stream)), draw,
        key | (turn & (NET - 1)), point,
    )  # fmt: skip


@kernel
def net_share(spare, draw):
    """Return the numbers of eight paths of a net at a draw, uniform in [0, 1)."""
    return real(net_number(spare, draw) >> 11) * _TO_UNIT


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


@kernel
def next_one(rng, ray, stream, draw, spare, has, wanted):
    """Return the next number of each path that wants one, and the last of its next draw.

    `ray` are the rows of `rng` (…, 8) that hold the generators.
    """
    one, aft = spare, spare
    drawn = wanted & (draw >= 0) & (has ^ True)
    if any_of(drawn):
        key0, key1, path0, path1 = gather_first_half(rng, ray)
        a, b, c, d = philox4x32(select(drawn, draw, 0), stream, path0, path1, key0, key1)
        one, aft = select(drawn, (a << 32) | b, one), (c << 32) | d
    of_net = wanted & (draw < 0)
    if any_of(of_net):
        one = select(of_net, net_number(spare, draw), one)
    return real(one >> 11) * _TO_UNIT, aft


@kernel
def take_one(draw, spare, has, aft, used):
    """Return (draw, spare, has) after the next number was used."""
    rest = used & (draw >= 0)
    drawn = rest & (has ^ True)
    steps = select(drawn | (used & (draw < 0)), 1, 0)
    return draw + steps, select(drawn, aft, spare), has ^ rest
