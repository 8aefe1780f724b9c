"""Luminance over a cell of LEDs in outside names and plain values."""

from itertools import product
from typing import Any

from mpfcad.measure import METERS, SCREEN_POINTS, Estimate
from mpfcad.measure.cell.luminance import CellResult
from mpfcad.record.measurement import describe_estimate
from mpfcad.record.verification import CONTRAST_FORMULA

_HARMONICS = 3


def describe_cell(result: CellResult, seed: int) -> dict[str, Any]:
    """Return the luminance over a cell and everything read off its Fourier series."""
    series, (across, along) = result.series, result.size
    contrast = {**(describe_estimate(result.contrast) or {}), "formula": CONTRAST_FORMULA}
    pairs = [pair for pair in product(range(_HARMONICS + 1), repeat=2) if any(pair)]
    return {
        "cell": {
            "across_mm": across,
            "along_mm": along,
            "luminance_cd_m2": result.luminance.tolist(),
            "standard_error_cd_m2": result.standard_error.tolist(),
        },
        "fit": {
            "order": series.order.tolist(),
            "coefficient_cd_m2": series.coefficient.tolist(),
            "chi2_excess": series.left,
            "mirrored": result.is_mirrored,
        },
        "lamp_mura_contrast": contrast,
        "mean_luminance_cd_m2": describe_estimate(result.mean_luminance),
        "luminance_above_led_cd_m2": describe_estimate(series.luminance(0.0, 0.0)),
        "sigma_over_mean": describe_estimate(series.relative_spread()),
        "points": {str(count): _points(result, count, seed) for count in METERS},
        "harmonic_amplitude": {
            f"{a}_across_{b}_along": describe_estimate(series.amplitude(a, b)) for a, b in pairs
        },
        "energy": result.energy,
        "paths": int(result.paths),
        "accelerator": result.accelerator,
    }


def _points(result: CellResult, count: int, seed: int) -> dict[str, Any]:
    """Return the evenness of the cell's luminance on 5, 9 or 13 points, LED in the middle."""
    u, v = (SCREEN_POINTS[list(METERS[count])] - 0.5).T
    contrast = result.series.contrast(seed, u, v)
    ends = contrast.value, contrast.low, contrast.high
    least = [(1 - k) / (1 + k) for k in ends]
    return {
        "contrast": describe_estimate(contrast),
        "min_over_max": describe_estimate(Estimate.within(least[0], least[2], least[1])),
        "max_over_min": describe_estimate(Estimate.within(*(1 / share for share in least))),
    }
