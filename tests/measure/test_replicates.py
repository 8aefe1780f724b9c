"""Standard errors from independent nets are honest: intervals hold as often as they say."""

import numpy as np
import pytest
from harness import CONCAVE, film_mesh

from mpfcad.measure import Estimate, reach
from mpfcad.measure.estimate import estimate_sum
from mpfcad.optics.base.recorder import Tally, freedom_of_sum
from mpfcad.optics.element import Film
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source
from mpfcad.record import ratio

RUNS = 400


def test_intervals_of_a_film_hold_the_truth(tmp_path):
    # Three points, 4 nets each. Seeds 1000 … 1399.
    scene = build_scene([Film(film_mesh(tmp_path, [CONCAVE] * 4), 1.5)], below=1.0)
    source = Source(EYE, np.full(3, 0.1), 0.05)
    tallies = [trace(scene, source, 4, seed=1000 + seed) for seed in range(RUNS)]
    value = np.array([t.radiance for t in tallies])
    error = np.array([t.radiance_error for t in tallies])
    alone = np.sqrt([(t.score2 / t.paths - t.radiance**2) / t.paths for t in tallies])
    # The mean of all runs stands for the truth, its error a 20th of theirs.
    off = np.abs(value - value.mean(axis=0))
    assert 0.93 <= np.mean(off <= reach(tallies[0].radiance_freedom) * error) <= 0.97
    # A normal distribution's intervals are too narrow: t of about 8 degrees of freedom.
    assert np.mean(off <= reach() * error) < 0.935
    # Paths taken as independent would say an error more than 1.8 times as large as it is.
    assert alone.mean() > 1.8 * error.mean()
    assert np.mean(off <= 1.96 * alone) > 0.998


def pooled(rng, points, blocks):
    """Return points' squared errors and variances, these scattered as 30 degrees say."""
    paths = 512 * blocks
    own = 30 / rng.chisquare(30, points)
    sums = 512 * rng.normal(size=(blocks, points)) * np.sqrt(own / 512)
    score = sums.sum(axis=0)
    # Paths whose variance is 1 whatever their mean is.
    score2 = paths * (1 + (score / paths) ** 2)
    block2 = (sums**2).sum(axis=0)
    tally = Tally(score, score2, block2, np.zeros(1), np.zeros(1), paths, blocks)
    return tally.radiance_error**2, own / paths


@pytest.mark.parametrize(("points", "blocks"), [(1, 4), (6, 2), (6, 8), (33, 4)])
def test_degrees_of_freedom_are_those_of_the_errors_scatter(points, blocks):
    rng = np.random.default_rng(81)
    said, true = np.swapaxes([pooled(rng, points, blocks) for _ in range(6000)], 0, 1)
    for weight in (np.eye(points)[0], np.ones(points)):
        freedom = freedom_of_sum(weight, np.ones(points), blocks)
        share = (said @ weight) / (true @ weight)
        # A variance of f degrees scatters by 2/f of its square, told here to 2 … 4 %.
        assert 2 * share.mean() ** 2 / share.var() == pytest.approx(freedom, rel=0.15)


def test_degrees_of_freedom_at_their_ends():
    alike = np.ones(10)
    assert freedom_of_sum(np.eye(10)[3], alike, np.inf) == np.inf
    assert freedom_of_sum(alike[:1], alike[:1], 5) == pytest.approx(4)
    assert freedom_of_sum(alike, alike, 5) == pytest.approx(40)
    many = np.ones(100_000)
    assert freedom_of_sum(np.r_[1.0, np.zeros(99_999)], many, 5) == pytest.approx(34, rel=0.001)
    # A point without error tells nothing about that of others.
    assert freedom_of_sum(np.array([1.0, 1.0]), np.array([0.5, 0.0]), 5) == pytest.approx(4)
    assert np.isfinite(freedom_of_sum(alike, np.zeros(10), 5))


def test_an_interval_is_students():
    # Quantiles of t from Student's table: 3.182 of 3 degrees, 2.042 of 30; 1.960 of a normal one.
    for freedom, wide in ((3, 3.182), (30, 2.042), (np.inf, 1.960)):
        one = Estimate.student(10.0, 0.5, freedom)
        assert (one.low, one.high) == pytest.approx((10 - wide / 2, 10 + wide / 2), abs=3e-4)
        assert one.half_width == pytest.approx(wide / 2, abs=3e-4)
    # Hundreds of replicates: within 1 % of a normal one's.
    assert reach(240) == pytest.approx(reach(), rel=0.01)


def test_a_sum_has_the_errors_of_its_points():
    weight, value, error = np.array([2.0, -1.0]), np.array([3.0, 5.0]), np.array([0.3, 0.8])
    one = estimate_sum(weight, value, error, np.inf)
    assert (one.value, one.standard_error) == pytest.approx((1.0, 1.0))
    assert one.half_width == pytest.approx(reach())


def described(value, error, freedom):
    one = Estimate.student(value, error, freedom)
    return {"value": value, "ci95": [one.low, one.high], "standard_error": error}


def test_a_ratio_keeps_what_its_parts_know_of_their_errors():
    found = ratio(described(8.0, 0.3, np.inf), described(4.0, 0.2, np.inf))
    error = 2 * np.hypot(0.3 / 8, 0.2 / 4)
    assert (found["value"], found["standard_error"]) == pytest.approx((2.0, error))
    assert found["ci95"] == pytest.approx([2 - reach() * error, 2 + reach() * error])
    # Against a figure that is known, it is the other's interval.
    found = ratio(described(8.0, 0.3, 3), described(4.0, 1e-9, 3))
    assert found["ci95"] == pytest.approx([2 - reach(3) * 0.075, 2 + reach(3) * 0.075])
