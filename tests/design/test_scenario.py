"""The scenario programme: what it raises, its derivative, its constraints."""

import numpy as np
import pytest

from mpfcad.design import (
    Constraint,
    Correction,
    FilmState,
    Goal,
    Scenarios,
    drawn_contrasts,
    find_likely,
    find_optimum,
)
from mpfcad.design.cosine import limits
from mpfcad.design.scenario import _tell

CONSTRAINT = Constraint(25.0, 75.0, 40.0, 3)
PITCH, CELLS = 16.0, 24
POSITION = np.arange(128) / 128
NONE = Correction.none()


def print_states(more):
    """Return the film as designed and with less and more contrast of C than meant."""
    return (
        FilmState(),
        FilmState(lambda c: 80 - (80 - c) * (1 - more)),
        FilmState(lambda c: 80 - (80 - c) * (1 + more)),
    )


def scenarios(states, z, rest, limit):
    """Return draws z of one input of the film, -1, 0 and 1 its states; `rest` of the others."""
    below, above = z * (z - 1) / 2, z * (z + 1) / 2
    weight = np.stack([1 - below - above, below, above], axis=1)
    return Scenarios(states, weight, weight, rest, POSITION, limit)


@pytest.fixture(scope="module")
def nominal(lamps):
    flat = np.array([50.0, 0, 0, 0])
    return find_optimum(flat, lamps, NONE, CONSTRAINT, Goal(), PITCH)


@pytest.fixture(scope="module")
def printed():
    rng = np.random.default_rng(3)
    z = rng.standard_normal(200)
    # The mean of the other inputs' effect is not 0: the nominal map is not the likeliest.
    tilt = 0.006 + 0.003 * rng.standard_normal(200)
    return scenarios(print_states(0.2), z, tilt[:, None] * np.cos(2 * np.pi * POSITION), 0.006)


def test_the_likeliest_map_beats_the_nominal_one(lamps, nominal, printed):
    found = find_likely(nominal, lamps, NONE, CONSTRAINT, printed, PITCH)
    before, after = (
        printed.share(drawn_contrasts(c, lamps, NONE, printed)) for c in (nominal, found)
    )
    assert before < 0.6 and after > before + 0.15
    matrix, bound = limits(CONSTRAINT, PITCH)
    assert (matrix @ found <= bound + 1e-6).all()


def test_without_widths_the_nominal_map_stays(lamps, nominal):
    sure = scenarios(print_states(0.1), np.zeros(20), np.zeros((20, 128)), 0.006)
    found = find_likely(nominal, lamps, NONE, CONSTRAINT, sure, PITCH)
    assert sure.share(drawn_contrasts(found, lamps, NONE, sure)) == 1.0
    assert np.abs(found - nominal).max() < 0.5


def test_the_film_shifted_the_other_way_is_its_mirror_image(lamps, nominal):
    both = [
        _tell(nominal, lamps, NONE, Scenarios(
            (FilmState(), FilmState(shift=s)), np.zeros((1, 2)), np.zeros((1, 2)),
            np.zeros((1, 128)), POSITION, 0.01,
        ))
        for s in (0.05, -0.05)
    ]  # fmt: skip
    np.testing.assert_allclose(both[0].cosine, both[1].cosine, atol=1e-6)
    np.testing.assert_allclose(both[0].sine, -both[1].sine, atol=1e-6)
    assert np.abs(both[0].sine[1]).max() > 1e-4


def test_the_derivative_is_that_of_differences(lamps):
    nominal = np.array([50.0, 5.0, 1.0, 0.5])
    states = (*print_states(0.2), FilmState(shift=0.04))
    one = Scenarios(states, np.zeros((1, 4)), np.zeros((1, 4)), np.zeros((1, 128)), POSITION, 0.01)
    told = _tell(nominal, lamps, NONE, one, slopes=True)
    for k in range(len(nominal)):
        step = 0.05 * (np.arange(len(nominal)) == k)
        high, low = (_tell(nominal + s * step, lamps, NONE, one) for s in (1, -1))
        for name in ("cosine", "sine"):
            difference = (getattr(high, name) - getattr(low, name)) / 0.1
            np.testing.assert_allclose(
                getattr(told, f"{name}_slope")[..., k], difference, atol=3e-6
            )


def test_a_correction_moves_every_state(lamps, nominal):
    one = scenarios(print_states(0.2), np.zeros(3), np.zeros((3, 128)), 0.01)
    known = Correction(1.0, np.array([0.02, 0, 0, 0]))
    assert drawn_contrasts(nominal, lamps, known, one) == pytest.approx(0.02, abs=1e-3)
