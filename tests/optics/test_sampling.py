"""Random numbers and the directions drawn with them."""

import math

import numpy as np
import pytest
from harness import compiled, within
from hypothesis import given
from hypothesis import strategies as st
from oracle.ray import Philox

from mpfcad.optics.base import sampling

disk, gaussian_pair, turn, uniform = map(
    compiled, (sampling.disk, sampling.gaussian_pair, sampling.turn, sampling.uniform)
)
henyey_greenstein_cosine = compiled(sampling.henyey_greenstein_cosine)
philox4x32, start_path = compiled(sampling.philox4x32), compiled(sampling.start_path)

ONES = 0xFFFFFFFF


def started(seed=1, stream=0, path=0):
    rng = np.zeros(sampling.RNG_SIZE, np.uint64)
    start_path(rng, np.uint64(seed), np.uint64(stream), np.uint64(path))
    return rng


def draws(count, **key):
    rng = started(**key)
    return np.array([uniform(rng) for _ in range(count)])


@pytest.mark.parametrize(
    ("counter", "key", "words"),
    [
        # Known answers of the Random123 library (Salmon et al., SC11), philox4x32 with 10 rounds.
        ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
        ((ONES,) * 4, (ONES,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
        (
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xA4093822, 0x299F31D0),
            (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
        ),
    ],
)
def test_philox_gives_the_published_words(counter, key, words):
    got = philox4x32(*(np.uint64(v) for v in (*counter, *key)))
    assert tuple(int(w) for w in got) == words


@given(seed=st.integers(0, 2**64 - 1), stream=st.integers(0, 2**32 - 1), path=st.integers(0, 2**63))
def test_kernel_and_oracle_draw_the_same_numbers(seed, stream, path):
    rng = started(seed, stream, path)
    oracle = Philox(seed, stream, path)
    assert [uniform(rng) for _ in range(7)] == [oracle() for _ in range(7)]


def test_a_path_draws_the_same_whatever_was_drawn_before():
    rng = started(path=3)
    for _ in range(5):
        uniform(rng)
    start_path(rng, np.uint64(1), np.uint64(0), np.uint64(4))
    assert (np.array([uniform(rng) for _ in range(20)]) == draws(20, path=4)).all()


@pytest.mark.parametrize("other", [{"path": 1}, {"seed": 2}, {"stream": 1}, {"path": 2**32}])
def test_neighbouring_paths_seeds_and_streams_are_independent(other):
    a, b = draws(20_000), draws(20_000, **other)
    # Correlation of independent numbers: standard error 1/√n; fixed seeds, 4 sigma.
    within(np.corrcoef(a, b)[0, 1], 0.0, 1 / math.sqrt(len(a)), 4)
    assert not np.isin(a, b).any()


def test_numbers_are_uniform_within_and_across_paths():
    across = np.array([draws(3, path=p) for p in range(20_000)])
    for sample in (draws(20_000), across[:, 0], across[:, 1], across[:, 2]):
        assert sample.min() >= 0 and sample.max() < 1
        count, _ = np.histogram(sample, 64, (0, 1))
        expected = len(sample) / 64
        chi2 = ((count - expected) ** 2 / expected).sum()
        within(chi2, 63, math.sqrt(2 * 63), 4)


@given(g=st.floats(-0.98, 0.98))
def test_henyey_greenstein_has_mean_cosine_g(g):
    # Substituting u by an even grid integrates the sampling formula itself: midpoint rule, whose
    # error is far below 1e-3 for |g| <= 0.98.
    u = (np.arange(4000) + 0.5) / 4000
    cosine = np.array([henyey_greenstein_cosine(g, v) for v in u])
    assert (np.abs(cosine) <= 1).all()
    assert cosine.mean() == pytest.approx(g, abs=1e-3)


def test_henyey_greenstein_follows_its_density():
    g = 0.8
    # Cumulative share below cos: (1-g²)/(2g) · (1/√(1+g²-2g cos) - 1/(1+g)).
    for u in (0.05, 0.3, 0.7, 0.99):
        cosine = henyey_greenstein_cosine(g, u)
        share = (1 - g * g) / (2 * g) * (1 / math.sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g))
        assert share == pytest.approx(u, abs=1e-12)


def test_disk_is_uniform():
    rng = started(seed=5)
    points = np.array([disk(rng) for _ in range(40_000)])
    n = len(points)
    square = (points**2).sum(axis=1)
    # kx, ky: mean 0, variance 1/4; k² uniform in 0…1; hence mean cosine 2/3 of a Lambertian.
    within(points.mean(axis=0), 0, 0.5 / math.sqrt(n), 4)
    within(square.mean(), 0.5, math.sqrt(1 / 12 / n), 4)
    within((square < 0.1).mean(), 0.1, math.sqrt(0.09 / n), 4)
    within(np.sqrt(1 - square).mean(), 2 / 3, math.sqrt(1 / 18 / n), 4)


def test_gaussian_pair_has_unit_variance_and_no_correlation():
    rng = started(seed=6)
    pairs = np.array([gaussian_pair(rng) for _ in range(40_000)])
    n = len(pairs)
    within(pairs.mean(axis=0), 0, 1 / math.sqrt(n), 4)
    within((pairs**2).mean(axis=0), 1, math.sqrt(2 / n), 4)
    within((pairs**4).mean(), 3, math.sqrt(96 / (2 * n)), 4)
    within(pairs.prod(axis=1).mean(), 0, 1 / math.sqrt(n), 4)


@given(
    polar=st.floats(0, math.pi), azimuth=st.floats(0, 7), cosine=st.floats(-1, 1),
    turned=st.floats(0, 7),
)  # fmt: skip
def test_turn_gives_a_unit_vector_at_the_asked_angle(polar, azimuth, cosine, turned):
    d = np.array(
        [math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth), math.cos(polar)]
    )
    e = np.array(turn(*d, cosine, turned))
    assert np.linalg.norm(e) == pytest.approx(1, abs=1e-14)
    assert d @ e == pytest.approx(cosine, abs=1e-12)
