"""The random numbers of eight paths at once: those of `sampling`, from generators in lanes."""

from numba import uint64

from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import any_of, real, select
from mpfcad.optics.lanes_array import load_lines
from mpfcad.optics.net import DIMENSIONS, NET
from mpfcad.optics.sampling import BLOCK, HAS_SPARE, KEYS, SPARE, net_number, philox4x32, start_path

_TO_UNIT = 2.0**-53


@kernel
def start_net_paths(rng, seed, stream, path, points, count):
    """Set the first `count` of rng (8, 8) as `start_net_path` does, for paths that follow `path`.

    Return them as lanes: (key0, key1, path0, path1, stream, draw, spare).
    """
    for i in range(count):
        start_path(rng[i], seed, stream, path + uint64(i))
        turn = (path + uint64(i)) // points
        net = (turn // uint64(NET)) * points + (path + uint64(i)) % points
        # Until the keys are drawn, these hold the net and the point of it.
        rng[i, BLOCK], rng[i, HAS_SPARE] = net & uint64(0xFFFFFFFF), net >> uint64(32)
        rng[i, SPARE] = turn % uint64(NET)
    key0, key1, path0, path1, stream, net0, index, net1 = load_lines(rng)
    a, b, _, _ = philox4x32((net0 ^ net0) | KEYS, stream, net0, net1, key0, key1)
    spare = (((a << 32) | b) & -NET) | index
    return key0, key1, path0, path1, stream, (net0 ^ net0) - DIMENSIONS, spare


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
