"""Luminance over a cell of LEDs in outside names and plain values."""

from itertools import product
from typing import Any

from mpfcad.measure import METERS, SCREEN_POINTS, Estimate
from mpfcad.measure.cell.luminance import CellResult
from mpfcad.measure.cell.visible import semu, worst_harmonic
from mpfcad.record.luminance import CONTRAST_FORMULA
from mpfcad.record.measurement import describe_estimate

_HARMONICS = 3
#: Of the eye [mm], where a job does not say.
VIEWING_DISTANCE = 500.0


def describe_cell(
    result: CellResult, seed: int, distance: float = VIEWING_DISTANCE
) -> dict[str, Any]:
    """Return the luminance over a cell and everything read off its Fourier series.

    `distance` [mm] is that of the eye.
    """
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
        "visibility": _visibility(result, distance),
        "semu": _semu(result),
        "energy": result.energy,
        "paths": int(result.paths),
        "estimator": describe_estimator(result),
        "accelerator": result.accelerator,
    }


def describe_estimator(result: CellResult) -> dict[str, Any]:
    """Return which way a cell was traced, why, and what the goal takes that was not reached."""
    choice = result.choice
    return {
        "name": choice.estimator.value,
        "reason": choice.reason,
        "work": {way.value: work for way, work in choice.work} or None,
        "paths_to_goal": result.paths_to_goal,
    }


def _visibility(result: CellResult, distance: float) -> dict[str, Any] | None:
    """Return the worst harmonic for an eye at a distance [mm]; None without a harmonic."""
    found = worst_harmonic(result.series, result.size, distance)
    if found is None:
        return None
    across, along = found.harmonic
    return {
        "harmonic": f"{across}_across_{along}_along",
        "wavelength_mm": found.wavelength,
        "viewing_distance_mm": distance,
        "threshold_contrast": found.threshold,
        "over_threshold": describe_estimate(found.over_threshold),
    }


def _semu(result: CellResult) -> dict[str, Any]:
    found = semu(result.series, result.size)
    return {
        "part": found.part,
        "area_mm2": found.area,
        "value": describe_estimate(found.value),
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
