"""The loop after the print: a hidden backlight, seen only through its measured curve."""

from types import SimpleNamespace

import numpy as np

from mpfcad.design import Goal
from mpfcad.design.cosine import Constraint, series_rows
from mpfcad.design.optimum import contrast_of
from mpfcad.design.reprint import Seen, find_reprint

CELLS = (np.arange(64) + 0.5) / 64
PITCH = 30.0
LIMITS = Constraint(25.0, 78.0, 10.0, 4)


class Toy:
    """Luminance = lamps · a gain by C, blurred over neighbours: smooth and not linear."""

    def __init__(self, lamps, slope, blur):
        self.grid = SimpleNamespace(centre=CELLS)
        self.lamps = 1 + lamps[0] * np.cos(2 * np.pi * CELLS) + lamps[1] * np.cos(4 * np.pi * CELLS)
        away = np.abs(CELLS[:, None] - CELLS)
        kernel = np.exp(-((np.minimum(away, 1 - away) / blur) ** 2))
        self.blur = kernel / kernel.sum(axis=1, keepdims=True)
        self.slope = slope

    def luminance(self, curvature):
        return 6000 * self.blur @ (self.lamps * (1 + self.slope * np.tanh((curvature - 50) / 40)))

    def jacobian(self, curvature, symmetric):
        gain = self.lamps * self.slope / 40 / np.cosh((curvature - 50) / 40) ** 2
        return self.luminance(curvature), 6000 * self.blur * gain


def measured(hidden, curvature, noise=1e-4):
    value = hidden.luminance(curvature)
    basis = np.cos(2 * np.pi * np.outer(CELLS, np.arange(1, 5)))
    cosine = 2 * (value / value.mean()) @ basis / len(CELLS)
    return Seen(float(value.mean()), cosine, noise**2 * np.eye(4))


def test_a_hidden_backlight_is_met_after_at_most_two_corrections():
    """Assumed and true backlight differ by tens of percent; 8 draws, every one below 0.004."""
    rng = np.random.default_rng(3)
    model = Toy((0.05, -0.01), 0.30, 0.05)
    for _ in range(8):
        hidden = Toy(
            (0.05 * rng.uniform(0.6, 1.4), -0.01 * rng.uniform(0.5, 1.5)),
            0.30 * rng.uniform(0.8, 1.25),
            0.05 * rng.uniform(0.8, 1.2),
        )
        place, printed = CELLS, np.full(64, 50.0)
        first = contrast_of(hidden.luminance(printed))
        for _ in range(2):
            found = find_reprint(
                place, printed, measured(hidden, printed), model, LIMITS, Goal(), PITCH, 0.012
            )
            printed = np.interp(CELLS, found.position, found.curvature)
        assert contrast_of(hidden.luminance(printed)) < 0.004 < first
        assert found.contrast[1] <= found.contrast[0] * 1.5 + 1e-3
        assert found.confidence == 1.0


def test_a_believed_model_is_left_as_it_is():
    model = Toy((0.05, -0.01), 0.30, 0.05)
    printed = np.full(64, 50.0)
    found = find_reprint(
        CELLS, printed, measured(model, printed), model, LIMITS, Goal(), PITCH, 0.012
    )
    assert np.abs(found.correction.relative).max() < 1e-3
    assert abs(found.correction.scale - 1) < 1e-3
    assert found.before > 0.03
    _, rows = series_rows(np.array([50.0, 0.0]))
    assert len(found.curvature) == len(rows)


def test_the_measurement_s_error_is_in_the_prediction():
    model = Toy((0.05, -0.01), 0.30, 0.05)
    printed = np.full(64, 50.0)
    noisy = measured(model, printed, noise=0.01)
    found = find_reprint(CELLS, printed, noisy, model, LIMITS, Goal(), PITCH, 0.012)
    assert found.contrast[2] - found.contrast[1] > 0.01
    assert found.confidence < 0.5
