"""A measured luminance in outside names and plain values, and how it departs from a prediction."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.gate import Gate
from mpfcad.measure import Estimate, harmonic_amplitude, relative_spread
from mpfcad.measure.observed import ObservedCell, ObservedPitch
from mpfcad.record.measurement import describe_estimate

_HARMONICS = 4
#: To how many periods a cell's place is found.
_SHIFT = 1e-3
CONTRAST_GATE = "lamp_mura_contrast"


def describe_pitch(found: ObservedPitch) -> dict[str, Any]:
    """Return the figures of a curve over lamp pitches."""
    fit, curve = found.fit, found.curve
    return {
        "kind": "stripes",
        "lamp_pitch_mm": found.pitch,
        "lamp_at_mm": found.lamp,
        "pitches": len(found.each),
        "lamp_mura_contrast": describe_estimate(found.contrast),
        "lamp_mura_contrast_of_pitches": [describe_estimate(each) for each in found.each],
        "harmonic_amplitude": [
            describe_estimate(harmonic_amplitude(fit, order)) for order in range(1, _HARMONICS + 1)
        ],
        "sigma_over_mean": describe_estimate(relative_spread(fit)),
        "uniformity_9_points": describe_estimate(found.uniformity),
        "mean_luminance_cd_m2": describe_estimate(fit.mean),
        "luminance": {
            "position_pitch": curve.position.tolist(),
            "luminance_cd_m2": curve.luminance.tolist(),
            "standard_error_cd_m2": curve.error.tolist(),
        },
        "misfit": curve.misfit,
    }


def describe_observed_cell(found: ObservedCell) -> dict[str, Any]:
    """Return the figures of a cell of spots."""
    series = found.series
    pairs = [(a, b) for a in range(3) for b in range(3) if a or b]
    return {
        "kind": "spots",
        "cells": found.cells,
        "cell": {
            "across_mm": found.size[0],
            "along_mm": found.size[1],
            "luminance_cd_m2": found.luminance.T.tolist(),
        },
        "lamp_mura_contrast": describe_estimate(found.contrast),
        "harmonic_amplitude": {
            f"{a}_across_{b}_along": describe_estimate(series.amplitude(a, b)) for a, b in pairs
        },
        "sigma_over_mean": describe_estimate(series.relative_spread()),
        "mean_luminance_cd_m2": describe_estimate(series.mean),
    }


def judgement_gate(contrast: Estimate, limit: float, marginal: float) -> Gate:
    """Return the gate of a measured contrast: that of a trace."""
    return Gate(CONTRAST_GATE, contrast.value, limit, (contrast.low, contrast.high), marginal)


def describe_difference(found: ObservedPitch, predicted: dict[str, Any]) -> dict[str, Any]:
    """Return the measured curve less a predicted one, each over its own mean, on 33 points.

    The measured curve is the mean over its pitches, turned to the phase and mirrored as the
    prediction where that leaves less: a file does not tell which lamp is which. `predicted` is
    `luminance` of verification.json.
    """
    place = np.array(predicted["position_pitch"])
    value = np.array(predicted["luminance_cd_m2"])
    error = np.array(predicted["standard_error_cd_m2"])
    mean = float(np.mean(value[:-1]))
    shift = _shift(found, place, value / mean)
    seen, spread = _curve(found, place + shift)
    ours = found.fit.mean.value
    residual = seen / ours - value / mean
    sigma = np.hypot(spread / ours, error / mean)
    return {
        "shift_pitch": shift,
        "luminance_ratio": ours / mean,
        "position_pitch": place.tolist(),
        "measured_over_mean": (seen / ours).tolist(),
        "predicted_over_mean": (value / mean).tolist(),
        "residual": residual.tolist(),
        "residual_standard_error": sigma.tolist(),
        "residual_rms": float(np.sqrt(np.mean(residual[:-1] ** 2))),
        "expected_rms": float(np.sqrt(np.mean(sigma[:-1] ** 2))),
    }


def _curve(
    found: ObservedPitch, place: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the folded curve [cd/m²] at places in pitches, and its standard errors."""
    estimates = [found.fit.at(float(each)) for each in place]
    return np.array([e.value for e in estimates]), np.array([e.standard_error for e in estimates])


def _shift(found: ObservedPitch, place: NDArray[np.float64], wanted: NDArray[np.float64]) -> float:
    """Return by how many pitches the folded curve must be read later to be most like one."""
    tried = np.arange(128) / 128 - 0.5
    curves = np.array([found.fit.curve(place[:-1] + each) for each in tried])
    curves /= found.fit.mean.value
    return float(tried[np.argmin(np.sum((curves - wanted[:-1]) ** 2, axis=1))])


def describe_cell_difference(found: ObservedCell, predicted: dict[str, Any]) -> dict[str, Any]:
    """Return a measured cell less a predicted one, each over its own mean, in the latter's bins.

    The measured series is averaged over each bin (sinc of each harmonic), and shifted to where it
    is most like the prediction: an image shows the brightest place, not the LED. `predicted` is
    `cell` of verification.json.
    """
    value = np.array(predicted["luminance_cd_m2"])
    error = np.array(predicted["standard_error_cd_m2"]) / value.mean()
    ours, wanted = found.series.mean.value, value / value.mean()
    shift = _cell_shift(found, wanted)
    at = _binned_terms(found, len(value), shift)
    seen = (at @ found.series.coefficient).reshape(value.shape) / ours
    spread = np.einsum("kn,nm,km->k", at, found.series.covariance, at)
    sigma = np.hypot(np.sqrt(spread).reshape(value.shape) / ours, error)
    residual = seen - wanted
    return {
        "shift_cell": list(shift),
        "luminance_ratio": ours / float(value.mean()),
        "measured_over_mean": seen.tolist(),
        "predicted_over_mean": wanted.tolist(),
        "residual": residual.tolist(),
        "residual_standard_error": sigma.tolist(),
        "residual_rms": float(np.sqrt(np.mean(residual**2))),
        "expected_rms": float(np.sqrt(np.mean(sigma**2))),
    }


def _binned_terms(found: ObservedCell, bins: int, shift: tuple[float, float]) -> NDArray:
    """Return the terms' means over a raster of bins moved by a shift [periods], (bins², n)."""
    middle = (np.arange(bins) + 0.5) / bins - 0.5
    u, v = (part.ravel() for part in np.meshgrid(middle, middle, indexing="ij"))
    harmonic = (found.series.order + 1) // 2
    kept: NDArray[np.float64] = np.prod(np.sinc(harmonic / bins), axis=1)
    return found.series.at(u + shift[0], v + shift[1]) * kept


def _cell_shift(found: ObservedCell, wanted: NDArray[np.float64]) -> tuple[float, float]:
    """Return by how many periods a measured cell must be read later to be most like one."""
    best, step = (0.0, 0.0), 1 / 24
    tried = np.arange(24) - 12
    while step > _SHIFT:
        places = [(best[0] + a * step, best[1] + b * step) for a in tried for b in tried]
        left = [
            float(np.sum((_binned_terms(found, len(wanted), place) @ found.series.coefficient
                          / found.series.mean.value - wanted.ravel()) ** 2))
            for place in places
        ]  # fmt: skip
        best, step, tried = places[int(np.argmin(left))], step / 4, np.arange(9) - 4
    return best
