"""Harmonics, 9-point contrast and the screen's uniformity: closed forms, bias and coverage."""

import numpy as np
import pytest

from mpfcad.measure import (
    contrast_of_curve,
    fit_curve,
    fit_harmonics,
    harmonic_amplitude,
    relative_spread,
)
from mpfcad.measure.contrast.contrast import contrast_of_points
from mpfcad.measure.uniformity import METERS, SCREEN_POINTS, uniformity

U = np.linspace(0, 1, 33)
PITCH = 2 * np.pi * U
ERROR = np.full(33, 0.5)


def test_a_cosine_has_its_amplitude_and_spread():
    luminance = 1000 * (1 + 0.03 * np.cos(PITCH) - 0.04 * np.sin(PITCH) + 0.01 * np.cos(2 * PITCH))
    fit = fit_harmonics(U, luminance, ERROR)
    assert harmonic_amplitude(fit, 1).value == pytest.approx(0.05, rel=1e-4)
    assert harmonic_amplitude(fit, 2).value == pytest.approx(0.01, rel=1e-3)
    assert harmonic_amplitude(fit, 3).value < 0.0003
    assert relative_spread(fit).value == pytest.approx(np.sqrt((0.05**2 + 0.01**2) / 2), rel=1e-3)
    assert fit.at(0.25).value == pytest.approx(950, rel=1e-4)


def test_noise_alone_has_no_spread():
    rng = np.random.default_rng(1)
    found = []
    for _ in range(300):
        fit = fit_harmonics(U, 1000 + rng.normal(size=33) * 5, np.full(33, 5.0))
        found.append((relative_spread(fit), harmonic_amplitude(fit, 1)))
    for figures in zip(*found, strict=True):
        # The interval ends at 0 nearly always: the truth is at the lowest value there is.
        assert np.mean([figure.low == 0 for figure in figures]) > 0.93


@pytest.mark.parametrize("amplitude", [0.0015, 0.0025, 0.004, 0.02])
def test_the_spreads_interval_covers(amplitude):
    rng = np.random.default_rng(2)
    luminance = 1000 * (1 + amplitude * np.cos(PITCH))
    inside = [0, 0]
    for _ in range(400):
        fit = fit_harmonics(U, luminance + rng.normal(size=33) * 5, np.full(33, 5.0))
        for i, (figure, truth) in enumerate(
            [
                (relative_spread(fit), amplitude / np.sqrt(2)),
                (harmonic_amplitude(fit, 1), amplitude),
            ]
        ):
            inside[i] += figure.low <= truth <= figure.high
    # The share shall be 0.93 … 0.975 (small amplitudes can only be read too large), ± 2.5 sigma.
    for share in np.array(inside) / 400:
        assert share >= 0.93 - 2.5 * np.sqrt(0.93 * 0.07 / 400)
        assert share <= 0.975 + 2.5 * np.sqrt(0.975 * 0.025 / 400)


def test_nine_points_are_every_fourth_of_the_thirty_three():
    luminance = 1000 * (1 + 0.02 * np.cos(PITCH) + 0.01 * np.cos(3 * PITCH + 0.4))
    fit = fit_curve(U, luminance, np.full(33, 1e-3))
    every = luminance[::4]
    assert len(every) == 9
    exact = (every.max() - every.min()) / (every.max() + every.min())
    nine = contrast_of_curve(fit, points=9)
    assert nine.value == pytest.approx(exact, abs=1e-5)
    thirty_three = contrast_of_curve(fit, points=33).value
    assert nine.value <= thirty_three <= contrast_of_curve(fit).value + 1e-6


def test_screen_points():
    assert [len(METERS[count]) for count in (5, 9, 13)] == [5, 9, 13]
    five, nine = (SCREEN_POINTS[list(METERS[count])] for count in (5, 9))
    assert sorted(map(tuple, five)) == [
        (0.25, 0.25), (0.25, 0.75), (0.5, 0.5), (0.75, 0.25), (0.75, 0.75)
    ]  # fmt: skip
    assert set(nine.ravel()) == {0.1, 0.5, 0.9}
    assert len({tuple(point) for point in SCREEN_POINTS}) == 13


def test_uniformity_in_closed_form():
    found = uniformity(np.array([90.0, 100.0, 80.0]), np.full(3, 1e-6))
    assert found.value == pytest.approx(0.8, abs=1e-6)
    assert found.low <= found.value <= found.high
    assert uniformity(np.full(9, 50.0), np.zeros(9)).value == 1
    assert contrast_of_points(np.array([90.0, 110.0]), np.full(2, 1e-6)).value == pytest.approx(0.1)


@pytest.mark.parametrize("drop", [0.0, 0.01, 0.05])
def test_the_uniformitys_interval_covers_and_has_no_bias(drop):
    rng = np.random.default_rng(3)
    truth = 1000 * (1 - drop * np.linspace(0, 1, 13))
    error = np.full(13, 5.0)
    noisy = truth + rng.normal(size=(150, 13)) * error
    found = [uniformity(values, error) for values in noisy]
    inside = sum(figure.low <= 1 - drop <= figure.high + 1e-12 for figure in found)
    # 95 % of 150 is 142.5 ± 2.7; the shape's own noise takes some.
    assert inside >= 134, inside
    plain_bias = np.mean(noisy.min(axis=1) / noisy.max(axis=1)) - (1 - drop)
    bias = np.median([figure.value for figure in found]) - (1 - drop)
    assert abs(bias) < 0.6 * abs(plain_bias)
