"""A fit on made-up backlights: intervals hold, noise feigns nothing, advice is right."""

import numpy as np
import pytest
from factory import (
    CLEAR_FILM,
    FIGURES,
    FLAT_FILM,
    NEW_FILM,
    VIEWS,
    Factory,
    exactly,
    measured,
    unknowns,
)

from mpfcad.confidence import Factor
from mpfcad.errors import InputError
from mpfcad.fit import Datum, Figured, build_unknowns, rank_next, search_values
from mpfcad.fit.linear import fit_line
from mpfcad.fit.posterior import fit_values
from mpfcad.fit.reading import luminance
from mpfcad.fit.search import distinct_steps, later_lines

FILMS = (NEW_FILM, FLAT_FILM, CLEAR_FILM)


def draws(count, noise, seed):
    """Return (off/σ of each value (count, 5), whether each film's interval held (count, 3))."""
    sought = unknowns()
    rng = np.random.Generator(np.random.Philox(seed))
    values, films = [], []
    for number in range(count):
        factory = Factory(noise, 1000 * seed + number)
        true = np.r_[rng.normal(size=4), 0.1 * rng.normal()]
        found = search_values(factory, VIEWS, measured(factory, true, rng), sought)
        found = later_lines(factory, [f.view for f in FILMS], found, sought)
        left = np.sqrt(np.diag(found.posterior.covariance))
        values.append((found.posterior.steps - true) / left)
        films.append([_holds(factory, found, figured, true) for figured in FILMS])
    return np.array(values), np.array(films)


def _holds(factory, found, figured, true):
    low, high = found.posterior.interval(figured, found.lines)
    assert low[0] >= 0
    return low[0] <= exactly(factory, figured, true)[0] <= high[0]


def test_intervals_hold_hidden_values():
    values, films = draws(8, 0.001, 3)
    # 40 intervals of 95 %: fewer than 33 hold with a probability of 0.2 %.
    assert np.count_nonzero(np.abs(values) < 1.96) >= 33
    assert np.count_nonzero(films) >= 19  # of 24


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0003, 0.001, 0.003])
def test_intervals_hold_hidden_values_of_forty_factories(noise):
    values, films = draws(40, noise, 4)
    share = np.mean(np.abs(values) < 1.96, axis=0)
    print(f"noise {noise}: held {share}, all {share.mean():.3f}, films' figures {films.mean(0)}")
    assert 0.90 <= share.mean() <= 0.99
    assert share.min() >= 0.8 and films.mean(0).min() >= 0.85 and films.mean() >= 0.90


def test_noise_of_slopes_feigns_no_knowledge():
    """Readings that hang on nothing leave the prior as it was, although each slope is noise."""
    rng = np.random.default_rng(8)
    sought = unknowns(luminance_too=False)
    left = []
    for _ in range(20):
        steps = 1.5 * (1 - 2 * rng.integers(0, 2, (32, 4)))
        found = 0.02 * rng.normal(size=(32, 4)) + np.array([8.9, 0.01, 0.0, 0.0])
        line = fit_line(
            np.zeros(4), steps, found, found.mean(axis=0), np.eye(4) * 1e-8, np.ones(4, bool)
        )
        figured = FIGURES[1][0]
        lines = {("a", "pitch"): line, ("b", "pitch"): line}
        datum = Datum(FIGURES[0][0], np.exp(line.start[:1]), np.array([[1e-4]]))
        left.append(np.diag(fit_values(lines, [datum], sought).covariance))
        assert figured.predict(lines, np.zeros(4)) == pytest.approx(1.0)
    assert np.mean(left) > 0.9


def test_a_limit_that_is_kept_says_nothing_and_one_that_is_not_pulls():
    factory = Factory(0.0003, 5)
    sought = unknowns()
    figured = FIGURES[0][0]
    middle = exactly(factory, figured, np.zeros(5))
    far, near = middle * 0.5, middle * 1.5
    (kept, pulled) = (
        search_values(factory, VIEWS, [Datum(figured, v, np.array([[100.0]]), side=1)], sought)
        for v in (far, near)
    )
    assert kept.posterior.freedom == 0 and np.abs(kept.posterior.steps).max() < 0.1
    assert pulled.posterior.predicted(figured, pulled.lines)[0] == pytest.approx(near, rel=0.02)


def test_what_is_left_and_what_narrows_it():
    rng = np.random.Generator(np.random.Philox(6))
    factory, sought = Factory(0.0003, 6), unknowns()
    found = search_values(factory, VIEWS, measured(factory, np.zeros(5), rng)[:2], sought)
    flux = FIGURES[4][0]
    rated = rank_next(
        found.posterior, sought, found.lines, [(flux, np.array([[0.004**2]]))], [NEW_FILM]
    )
    left = {row["measurement"]: row["left"] for row in rated}
    assert flux.name in left and "BTDF of the top sheet" in left
    assert [row["left"] for row in rated] == sorted(left.values())
    assert all(0 < value <= 1 + 1e-9 for value in left.values())
    # What it promises comes true: the same fit with that measurement.
    more = [*measured(factory, np.zeros(5), rng)[:2]]
    more.append(Datum(flux, exactly(factory, flux, np.zeros(5)), np.array([[0.004**2]])))
    then = search_values(factory, VIEWS, more, sought)
    before, after = (one.posterior.predicted(NEW_FILM, one.lines)[1:] for one in (found, then))
    of_values = [np.sqrt((total - noise)[0, 0]) for total, noise in (before, after)]
    assert of_values[1] / of_values[0] == pytest.approx(left[flux.name], abs=0.1)


class OneValue:
    """A smooth response to one value; view b does not depend on it. No noise: runs repeat."""

    def trace(self, view, steps, *, middle):
        z = float(steps[0]) if view[0] == "a" else 0.0
        found = np.array([8.9 + 0.03 * z + 0.001 * z**2, 0.01])
        return found, np.eye(2) * (1e-8 if middle else 1e-7)

    def active(self, view):
        return np.array([view[0] == "a"])

    def known(self, view):
        return np.zeros((1, 2))


def test_one_value_is_fitted_and_one_that_a_view_does_not_have():
    sought = build_unknowns([Factor("top_sheet_sigma", 0.35, 0.028, 0.0, 10.0)], set(), set())
    ratio = Figured("a over b", VIEWS[0], luminance, VIEWS[1])
    true = 0.8
    value = np.exp([0.03 * true + 0.001 * true**2])
    datum = Datum(ratio, value, np.array([[0.003**2]]))
    found = search_values(OneValue(), VIEWS[:2], [datum], sought).posterior
    left = float(np.sqrt(found.covariance[0, 0]))
    # A prior of 1 beside a measurement of 0.003 / 0.03 = 0.1.
    assert left == pytest.approx(0.1, rel=0.15)
    assert found.steps[0] == pytest.approx(true, abs=0.5 * left)


def test_no_run_repeats_another():
    for count in (1, 2, 3, 5, 16, 17):
        steps = distinct_steps(count)
        assert len(np.unique(steps, axis=0)) == len(steps)
        square = steps.T @ steps
        assert np.allclose(square, np.diag(np.diag(square))) and np.allclose(steps.sum(0), 0)


def test_correlations_of_the_prior_stand_in_the_posterior():
    factors = [Factor("a", 1.0, 0.1), Factor("b", 2.0, 0.2)]
    matrix = np.array([[0.01, 0.018], [0.018, 0.04]])
    sought = build_unknowns(factors, set(), set(), (["a", "b"], matrix))
    assert np.linalg.inv(sought.information)[0, 1] == pytest.approx(0.9)
    with pytest.raises(InputError, match="covariance: not positive"):
        build_unknowns(factors, set(), set(), (["a", "b"], np.array([[0.01, 0.02], [0.02, 0.04]])))
