"""What the eye makes of a cell: its worst harmonic against the threshold, its SEMU."""

import math

import numpy as np
import pytest

from mpfcad.measure.cell.series import CellSeries
from mpfcad.measure.cell.visible import semu, worst_harmonic
from mpfcad.measure.eye import PANEL_TRANSMITTANCE, threshold_contrast

MEAN, SIZE = 8000.0, (12.0, 9.0)


def series(amplitude: dict[tuple[int, int], float], error: float = 1e-6) -> CellSeries:
    """Return a series of cosines, their harmonics and amplitudes over the mean."""
    order = np.array([(0, 0), *((max(2 * a - 1, 0), max(2 * b - 1, 0)) for a, b in amplitude)])
    value = MEAN * np.array([1.0, *amplitude.values()])
    return CellSeries(order, value, np.eye(len(value)) * (error * MEAN) ** 2, 1000.0, 0.0)


@pytest.mark.parametrize("pair", [(1, 0), (0, 2), (1, 1)])
def test_one_harmonic_is_the_worst_at_its_own_wavelength(pair):
    found = worst_harmonic(series({pair: 0.01}), SIZE, 600.0)
    wavelength = 1 / math.hypot(pair[0] / SIZE[0], pair[1] / SIZE[1])
    threshold = threshold_contrast(wavelength, 600.0, MEAN * PANEL_TRANSMITTANCE)
    assert found.harmonic == pair and found.wavelength == pytest.approx(wavelength)
    assert found.over_threshold.value == pytest.approx(0.01 / threshold, rel=1e-4)
    low, high = found.over_threshold.low, found.over_threshold.high
    assert low < found.over_threshold.value < high


def test_the_worst_is_that_which_the_eye_sees_best_not_the_largest():
    # From far away 36 mm stripes lie where the eye is best, 3 mm ones where it sees little.
    mixed = series({(1, 0): 0.004, (12, 0): 0.006})
    assert worst_harmonic(mixed, (36.0, 36.0), 3000.0).harmonic == (1, 0)
    assert worst_harmonic(series({}), SIZE, 600.0) is None


def test_semu_of_half_a_cell():
    """Cos is above the mean on half of the cell, by 2/π of its amplitude: both parts' means."""
    found = semu(series({(1, 0): 0.03}), SIZE)
    area = SIZE[0] * SIZE[1] / 2
    step, ground = 2 * 0.03 * 2 / math.pi, 1 - 0.03 * 2 / math.pi
    expected = 100 * step / ground / (1.97 / area**0.33 + 0.72)
    assert found.area == pytest.approx(area, rel=0.05)
    assert found.value.value == pytest.approx(expected, rel=0.01)
    assert found.part == "above"  # over the darker ground the same step is the larger share
    assert found.value.low < found.value.value < found.value.high


def test_semu_interval_holds_the_noise_of_the_step():
    """95 % of 400 draws of a series' noise leave the step in its interval."""
    rng = np.random.Generator(np.random.Philox(3))
    true = series({(1, 0): 0.03}, error=0.002)
    expected = semu(true, SIZE).value.value
    inside = 0
    for _ in range(400):
        noise = rng.standard_normal(2) * 0.002 * MEAN
        drawn = CellSeries(true.order, true.coefficient + noise, true.covariance, 1000.0, 0.0)
        one = semu(drawn, SIZE).value
        inside += one.low <= expected <= one.high
    # Binomial: σ = 1.1 %.
    assert 0.915 <= inside / 400 <= 0.985


def test_an_even_cell_has_no_semu():
    assert semu(series({}), SIZE).value.value == 0.0
