"""Owen-scrambled nets: what makes them nets, that each point is uniform, and what they gain."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
from harness import within
from numba import njit, uint64
from oracle.ray import Philox

from mpfcad.optics.base.lanes_array import load_from, scatter_line, store
from mpfcad.optics.base.net import DIMENSIONS, NET, direction_numbers
from mpfcad.optics.base.sampling import RNG_SIZE, start_net_path, uniform
from mpfcad.optics.base.sampling_lanes import net_keys, next_one, start_net_paths, take_one
from mpfcad.store.kernel import kept


@kept
@njit
def _draws(seed, stream, first, points, out):
    rng = np.zeros(RNG_SIZE, np.uint64)
    for i in range(len(out)):
        start_net_path(rng, uint64(seed), uint64(stream), uint64(first + i), uint64(points))
        for d in range(out.shape[1]):
            out[i, d] = uniform(rng)


def draws(count, numbers=DIMENSIONS + 4, *, seed=1, first=0, points=1):
    out = np.empty((count, numbers))
    _draws(np.uint64(seed), 0, first, points, out)
    return out


def test_direction_numbers_are_the_published_ones():
    from scipy.stats import qmc

    points = np.zeros((NET, DIMENSIONS), np.int64)
    for d in range(DIMENSIONS):
        for bit, number in enumerate(direction_numbers(d)):
            points[np.arange(NET) >> bit & 1 == 1, d] ^= number
    published = qmc.Sobol(DIMENSIONS, scramble=False).random(NET) * 2**10
    # There they come in another order.
    assert set(map(tuple, points.tolist())) == set(map(tuple, published.astype(int).tolist()))


@pytest.mark.parametrize(("seed", "path", "points"), [(1, 0, 1), (2**63 + 5, 12_345_678_901, 33)])
def test_kernel_and_oracle_draw_the_same_numbers(seed, path, points):
    for p, row in enumerate(draws(5, seed=seed, first=path, points=points)):
        oracle = Philox(seed, 0, path + p, points)
        assert [oracle() for _ in row] == row.tolist()


@kept
@njit(error_model="numpy", _nrt=False)
def _eight(seed, first, path, points, keys, rows, rng, out):
    """Draw numbers of eight paths from `path` on; keys (n, 8) become those of path `first`."""
    seed, stream, points = uint64(seed), uint64(0), uint64(points)
    net_keys(seed, stream, uint64(first), points, keys)
    row = load_from(rows, 0)
    key0, key1, path0, path1, stream, draw, spare, _ = start_net_paths(
        seed, stream, uint64(first), uint64(path), points, keys
    )
    scatter_line(rng, row, key0, key1, path0, path1, stream, draw, spare, row ^ row)
    has, every = row < 0, row >= 0
    for d in range(len(out)):
        number, aft = next_one(rng, row, stream, draw, spare, has, every)
        draw, spare, has = take_one(draw, spare, has, aft, every)
        store(out, d, number)


@pytest.mark.parametrize(
    ("first", "path", "points"),
    [(0, 0, 32), (0, 512 * 32 - 8, 32), (0, 512 * 32, 32), (33 * 512, 33 * 1024 - 3, 33),
     (0, 511, 1), (512, 1023, 1), (0, 1530, 3), (2**33 * 512 * 5, 2**33 * 512 * 5 + 777, 5)],
)  # fmt: skip
def test_eight_paths_draw_what_each_of_them_draws_alone(first, path, points):
    # Also where some of them are of the next net, whose keys are not those kept.
    keys = np.zeros((-(-points // 8) + 1, 8), np.int64)
    out, rng = np.empty((DIMENSIONS + 6, 8)), np.zeros((8, RNG_SIZE), np.uint64)
    _eight(7, first, path, points, keys, np.arange(8), rng, out)
    alone = draws(8, DIMENSIONS + 6, seed=7, first=path, points=points)
    assert np.array_equal(out.T, alone)


@pytest.mark.parametrize("points", [1, 3])
def test_a_block_has_one_point_in_each_part(points):
    block = draws(NET * points, first=4 * NET * points, points=points)
    for point in range(points):
        mine = block[point::points]
        for d in range(DIMENSIONS):
            assert len(np.unique(np.floor(mine[:, d] * NET))) == NET
        # In the first two dimensions also all boxes of 2⁻ᵃ by 2⁻ᵇ, a + b = 9.
        for a in range(10):
            box = np.floor(mine[:, 0] * 2**a) * NET + np.floor(mine[:, 1] * 2 ** (9 - a))
            assert len(np.unique(box)) == NET
        # From there on they are Philox's: a part holds any number.
        assert len(np.unique(np.floor(mine[:, DIMENSIONS] * NET))) < 0.75 * NET
    assert len(np.unique(block)) == block.size


def test_each_point_of_a_net_is_uniform_over_the_nets():
    nets = draws(4000 * NET, DIMENSIONS).reshape(4000, NET, DIMENSIONS)
    for i in (0, 1, 2, 100, 511):
        count = np.stack([np.histogram(nets[:, i, d], 16, (0, 1))[0] for d in range(DIMENSIONS)])
        within(((count - 250) ** 2 / 250).sum(axis=1), 15, np.sqrt(30), 5)
        # Dimensions of one point are independent of each other; fixed seed, 5 sigma of 1/√4000.
        correlation = np.corrcoef(nets[:, i].T) - np.eye(DIMENSIONS)
        assert np.abs(correlation).max() < 5 / np.sqrt(4000)
    neighbours = np.corrcoef(nets[:-1, 7].T, nets[1:, 7].T)[:DIMENSIONS, DIMENSIONS:]
    assert np.abs(neighbours).max() < 5 / np.sqrt(4000)


def test_the_digits_are_permuted_independently_in_each_part():
    # Owen's scramble: whether the third digit is turned is chosen anew for each first two digits.
    nets = draws(4000 * NET, 1).reshape(4000, NET)
    raw = np.array([sum((i >> b & 1) << (9 - b) for b in range(10)) for i in range(NET)])
    for a, b in itertools.combinations((0, 256, 512, 768), 2):
        turned = [np.floor(nets[:, np.flatnonzero(raw == v)[0]] * 8) % 2 for v in (a, b)]
        within(np.mean(turned[0] == turned[1]), 0.5, 0.5 / np.sqrt(4000), 4)


def test_a_smooth_integral_has_far_less_spread_than_with_independent_points():
    nets = draws(300 * NET, 3).reshape(300, NET, 3)
    means = np.prod(1 + np.cos(3 * nets), axis=2).mean(axis=1)
    one = np.prod(1 + np.cos(3 * nets), axis=2).var()
    truth = (1 + np.sin(3) / 3) ** 3
    # Independent points would leave one/512; a net of three smooth dimensions under a hundredth.
    assert means.var() < one / NET / 100
    within(means.mean(), truth, means.std() / np.sqrt(300), 4)


#: Eight paths, of which one is at its net's third number and the others are long past theirs.
_MIXED = """
import numpy as np
from numba import njit
from mpfcad.optics.base import lanes_array
from mpfcad.optics.base.sampling_lanes import next_two

@njit(error_model="numpy", _nrt=False)
def draw(state, out):
    draws, spare = lanes_array.load(state, 0), lanes_array.load(state, 1)
    one, two, _ = next_two(spare, spare, spare, spare, spare, draws, spare, spare < spare)
    lanes_array.store(out, 0, one)
    lanes_array.store(out, 1, two)

def drawn(draws):
    out = np.zeros((2, 8))
    draw(np.array([draws, range(500, 508)]), out)
    return out

far = drawn([-10, *range(2 * 10**6, 9 * 10**6, 10**6)])
alone = drawn([-10] * 8)
assert (far[:, 0] == alone[:, 0]).all(), far
assert (far >= 0).all() and (far < 1).all()
"""


def test_a_path_long_past_its_net_looks_nothing_up_beyond_the_table():
    # In a process of its own: a read of memory that is not there would end this one.
    done = subprocess.run([sys.executable, "-c", _MIXED], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
