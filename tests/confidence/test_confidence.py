"""Widths carried to the contrast: factorial, slopes, closed forms, what to measure."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest

from mpfcad.confidence import (
    STEP,
    Factor,
    Response,
    correlation,
    draw_steps,
    factorial_steps,
    fit_slopes,
    likely_contrast,
    rank_measurements,
    read_covariance,
    shares_of_variance,
)
from mpfcad.errors import InputError
from mpfcad.gate import Gate
from mpfcad.job import ConfidenceTable

U = np.arange(128) / 128
COSINE = np.cos(2 * np.pi * U)[:, None]


def factor(name, sigma=1.0, **values):
    return Factor(name, values.pop("value", 0.0), sigma, **values)


def response(start, slope, bend=None, noise=0.0):
    """Return a response of the first cosine alone, with errors `noise`."""
    slope = np.array(slope, float)[:, None]
    bend = np.zeros_like(slope) if bend is None else np.array(bend, float)[:, None]
    spread = np.full((len(slope), 1, 1), noise**2)
    one = np.array([[noise**2]])
    return Response(
        np.array([start]), one, slope, spread, bend, np.where(bend != 0, 1, 0)[..., None] * spread,
        COSINE,
    )  # fmt: skip


@pytest.mark.parametrize(("count", "runs"), [(1, 32), (13, 32), (16, 32), (17, 64), (40, 128)])
def test_main_effects_are_free_of_each_other_and_of_pairs(count, runs):
    steps = factorial_steps(count)
    assert steps.shape == (runs, count) and (np.abs(steps) == STEP).all()
    signs = steps / STEP
    assert np.array_equal(signs.T @ signs, runs * np.eye(count))
    assert (signs.sum(axis=0) == 0).all()
    pairs = [signs[:, i] * signs[:, j] for i in range(count) for j in range(i)]
    if pairs:
        assert np.abs(signs.T @ np.array(pairs).T).max() == 0


def test_slopes_are_found_with_their_errors():
    rng = np.random.default_rng(91)
    steps, true = factorial_steps(5), rng.normal(size=(5, 3))
    off = []
    for _ in range(300):
        found = 1 + steps @ true + 0.1 * rng.normal(size=(32, 3))
        slope, covariance = fit_slopes(steps, found)
        off.append((slope - true) / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)))
    # Student's t of 26 degrees: variance 26/24; 4500 values tell it to 2 %.
    assert np.var(off) == pytest.approx(26 / 24, rel=0.09)
    # Products of two inputs leave the slopes alone.
    crossed = 1 + steps @ true + 3 * (steps[:, :1] * steps[:, 1:2])
    assert np.allclose(fit_slopes(steps, crossed)[0], true)


@pytest.mark.parametrize(("start", "slope"), [(0.005, 0.012), (0.02, 0.004), (0.0, 0.01)])
def test_the_probability_is_that_of_the_closed_form(start, slope):
    one = [factor("a")]
    steps = draw_steps(one, np.eye(1), 5)
    found = likely_contrast(response(start, [slope]), steps, 0.012, 1).probability
    normal = NormalDist(start, slope)
    share = normal.cdf(0.012) - normal.cdf(-0.012)
    # 4000 draws: 0.8 % at most; 4 sigma.
    assert found.value == pytest.approx(share, abs=0.032)
    assert found.low <= found.value <= found.high


def test_noise_in_the_traces_widens_the_interval_and_is_no_bias():
    one = [factor(f"f{i}") for i in range(12)]
    steps = draw_steps(one, np.eye(12), 5)
    true = np.r_[0.008, np.zeros(11)]
    exact = likely_contrast(response(0.004, true), steps, 0.012, 1).probability
    rng = np.random.default_rng(92)
    noise, held, values = 0.0015, 0, []
    for i in range(20):
        seen = response(
            0.004 + noise * rng.normal(), true + noise * rng.normal(size=12), noise=noise
        )
        found = likely_contrast(seen, steps, 0.012, i).probability
        held += found.low - 0.01 <= exact.value <= found.high + 0.01
        values.append(found.value)
    assert held >= 16
    assert np.median(values) == pytest.approx(exact.value, abs=0.07)


def test_an_effect_that_noise_hides_is_not_known_to_be_none():
    one = [factor("a")]
    steps = draw_steps(one, np.eye(1), 5)
    found = likely_contrast(response(0.01, [1e-6], noise=0.002), steps, 0.02, 1)
    # The start alone is known to 0.002; half of its 95 % interval is 0.0039.
    assert found.contrast.low < 0.01 - 0.003 and found.contrast.high > 0.01 + 0.003
    assert likely_contrast(response(0.01, [1e-6], noise=0.006), steps, 0.02, 1).probability.low < 1


@pytest.mark.parametrize(("start", "slope"), [(0.007, 0.0), (0.004, 0.0015), (0.004, 0.008)])
def test_the_range_holds_the_contrasts_that_the_inputs_give(start, slope):
    # Four coefficients, of which the truth has one, and noise in all of them.
    basis = np.cos(2 * np.pi * np.outer(U, [1, 2, 3, 4]))
    steps = draw_steps([factor("a")], np.eye(1), 5)[:1000]
    one, nothing, noise = np.eye(4)[0], np.zeros((1, 4)), 0.001
    spread = noise**2 * np.eye(4)

    def of(start, slope, spread):
        return Response(
            start, spread, slope[None], spread[None], nothing, 0 * spread[None], basis
        )  # fmt: skip

    true = of(start * one, slope * one, 0 * spread).contrast(steps)
    rng, held = np.random.default_rng(93), []
    for i in range(40):
        seen = of(
            start * one + noise * rng.normal(size=4),
            slope * one + noise * rng.normal(size=4),
            spread,
        )
        found = likely_contrast(seen, steps, 0.012, i).contrast
        held.append(np.mean((found.low <= true) & (true <= found.high)))
    # 95 % of what the inputs give, in the mean of the traces; of 40 it scatters by 2 %.
    assert np.mean(held) >= 0.93


def test_a_bend_moves_the_contrast_one_way():
    one = [factor("resin_percent", 10.0, is_curved=True)]
    steps = draw_steps(one, np.eye(1), 5)
    straight = likely_contrast(response(0.0, [0.001]), steps, 0.012, 1).contrast
    bent = likely_contrast(response(0.0, [0.001], [0.01]), steps, 0.012, 1).contrast
    # z² has the mean 1 and the median 0.455.
    assert straight.value < 0.001 and bent.value == pytest.approx(0.00455, rel=0.1)


def test_correlated_inputs_cancel():
    two = [factor("a"), factor("b")]
    between = correlation(two, (["a", "b"], np.array([[1.0, -0.999], [-0.999, 1.0]])))
    together = response(0.0, [0.01, 0.01])
    alone = likely_contrast(together, draw_steps(two, np.eye(2), 5), 0.012, 1)
    tied = likely_contrast(together, draw_steps(two, between, 5), 0.012, 1)
    assert tied.contrast.high < 0.002 < alone.contrast.high
    assert shares_of_variance(together, np.eye(2)) == pytest.approx([0.5, 0.5])


def test_steps_stay_where_an_input_can_be():
    one = factor("share", 0.2, value=0.1, low=0.0, high=1.0)
    steps = draw_steps([one], np.eye(1), 5)[:, 0]
    values = one.value + one.sigma * steps
    assert values.min() == pytest.approx(0.0, abs=1e-12) and values.max() > 0.5


def test_what_narrows_most_comes_first():
    names = ["top_sheet_sigma", "thickness_mm", "film_index", "unheard_of"]
    sizes = [0.03, 0.3, 0.01, 1.0]
    some = [factor(n, s, value=0.35) for n, s in zip(names, sizes, strict=True)]
    steps = draw_steps(some, np.eye(4), 5)
    found = rank_measurements(response(0.004, [0.01, 0.004, 0.001, 0.002]), some, steps, 0.018)
    assert found[0]["measurement"] == "BTDF of the top sheet"
    assert found[0]["inputs"] == ["top_sheet_sigma"]
    assert found[0]["contrast_spread"] < 0.6 * found[0]["contrast_spread_before"]
    assert "unheard_of" not in [name for row in found for name in row["inputs"]]
    assert found[0]["probability_if_confirmed"] > found[-1]["probability_if_confirmed"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a,b\n1,2\n2,1\n", "eigenvalue -1: expected a positive one"),
        ("a,b\n1,0.5\n0.4,1\n", "not symmetric"),
        ("a,b\n1,0\n", "1 rows of numbers: expected 2 rows of 2"),
        ("a\nx\n", "expected a row of names, then numbers"),
        ("a\nnan\n", "a, a: nan: expected a finite number"),
        ("a,b\n1,0\n0,inf\n", "b, b: inf: expected a finite number"),
        ("a,a\n1,0\n0,1\n", "a: named twice: expected each input once"),
        ("a,b\n1,0\n0\n", "2 rows of numbers: expected 2 rows of 2"),
        ("", "0 rows of numbers: expected some rows"),
    ],
)
def test_a_covariance_is_refused_in_one_line(tmp_path, text, says):
    path = tmp_path / "c.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as error:
        read_covariance(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("names", "matrix", "says"),
    [
        (["a", "b"], [[1.0, 2.0]], "expected 2 rows of as many numbers"),
        (["a", "b"], [[1.0, 0.0], [0.0]], "expected 2 rows of as many numbers"),
        ([], [], "expected some rows"),
        (["a", "a"], [[1.0, 0.0], [0.0, 1.0]], "a: named twice"),
        (["a"], [[float("nan")]], "a, a: nan: expected a finite number"),
        (["a"], [[-1.0]], "eigenvalue -1"),
        (["a", "b"], [[1.0, 0.5], [0.4, 1.0]], "not symmetric"),
    ],
)
def test_a_jobs_own_covariance_is_held_to_the_same(names, matrix, says):
    with pytest.raises(ValueError, match=says):
        ConfidenceTable(names=names, matrix=matrix)


def test_an_input_is_not_wider_than_what_it_can_be():
    with pytest.raises(InputError, match=r"share: sigma: 1e\+300: expected .* up to 1"):
        Factor("share", 0.5, 1e300, 0.0, 1.0)


def test_a_covariance_is_read(tmp_path):
    path = tmp_path / "c.csv"
    path.write_text("a, b\n4, 1\n1, 9\n")
    names, matrix = read_covariance(path)
    found = correlation([factor("b", 3.0), factor("c"), factor("a", 2.0)], (names, matrix))
    assert found[0, 2] == pytest.approx(1 / 6) and found[0, 1] == 0 and found[1, 1] == 1


@pytest.mark.parametrize(
    ("interval", "outcome"),
    [((0.92, 0.97), "PASS"), ((0.85, 0.93), "INCONCLUSIVE"), ((0.5, 0.6), "FAIL")],
)
def test_the_gate_is_decided_by_the_interval(interval, outcome):
    gate = Gate("confidence", 0.9, 0.9, interval, at_least=True)
    assert gate.outcome == outcome
    assert replace(gate, interval=(float("nan"), float("nan"))).outcome != "PASS"
