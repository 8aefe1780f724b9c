"""Measured figures in outside names and plain values, each with interval and standard error."""

from dataclasses import replace
from typing import Any

import numpy as np

from mpfcad.measure import (
    AngularCurve,
    AngularResult,
    CameraResult,
    ConoscopeResult,
    Estimate,
    FluxResult,
    LuminanceResult,
    PanelResult,
    PolarisationResult,
    UniformityResult,
    contrast_of_curve,
    harmonic_amplitude,
    relative_spread,
)
from mpfcad.measure.polarisation import ANGLES
from mpfcad.record.luminance import describe_luminance, numbers
from mpfcad.units import deg

#: Of the records below; figures kept under another one are measured anew.
MEASUREMENT_SCHEMA = 4
_HARMONICS = 3


def describe_contrast(result: LuminanceResult, seed: int) -> dict[str, Any]:
    """Return luminance over the pitch and everything read off its curve and Fourier series."""
    fit, curve = result.fit, result.curve
    contrast = {
        f"lamp_mura_contrast_{points}_points": describe_estimate(_of_central(result, seed, points))
        for points in (33, 9)
    }
    return {
        **describe_luminance(result),
        "lamp_mura_contrast": describe_estimate(result.contrast),
        **contrast,
        "mean_luminance_cd_m2": describe_estimate(result.mean_luminance),
        "luminance_above_lamp_cd_m2": describe_estimate(curve.at(0.0)),
        "luminance_between_lamps_cd_m2": describe_estimate(curve.at(0.5)),
        "sigma_over_mean": describe_estimate(relative_spread(fit)),
        "harmonic_amplitude": [
            describe_estimate(harmonic_amplitude(fit, order)) for order in range(1, _HARMONICS + 1)
        ],
    }


def _of_central(result: LuminanceResult, seed: int, points: int) -> Estimate:
    """Return the contrast of so many points of the middle's pitch."""
    central = replace(result.curve, window=result.curve.window[[result.central]])
    return contrast_of_curve(central, seed, points=points)


def describe_angular(result: AngularResult) -> dict[str, Any]:
    """Return both angular curves with their widths [deg]."""
    return {
        "across": _describe_curve(result.across),
        "along": _describe_curve(result.along),
        "paths": result.paths,
    }


def _describe_curve(curve: AngularCurve) -> dict[str, Any]:
    return {
        "angle_deg": _degrees(curve.angle),
        "luminance_cd_m2": numbers(curve.luminance),
        "standard_error_cd_m2": numbers(curve.standard_error),
        "degrees_of_freedom": float(curve.freedom),
        "fwhm_deg": describe_estimate(curve.fwhm, 1 / deg),
        "third_of_normal_width_deg": describe_estimate(curve.third, 1 / deg),
    }


def describe_conoscope(result: ConoscopeResult) -> dict[str, Any]:
    """Return the conoscopic map, a row a polar angle."""
    return {
        "polar_deg": _degrees(result.polar),
        "azimuth_deg": _degrees(result.azimuth),
        "luminance_cd_m2": [numbers(row) for row in result.luminance],
        "standard_error_cd_m2": [numbers(row) for row in result.standard_error],
        "exitance_lm_m2": describe_estimate(result.exitance),
        "paths": result.paths,
    }


def describe_flux(result: FluxResult) -> dict[str, Any]:
    """Return flux and efficiency, and how far both ways of tracing are apart."""
    return {
        "efficiency_lm_per_lm": describe_estimate(result.efficiency),
        "exitance_lm_m2": describe_estimate(result.exitance),
        "exitance_backward_lm_m2": describe_estimate(result.exitance_backward),
        "forward_minus_backward_sigma": result.disagreement,
        "flux_lm": describe_estimate(result.flux),
        "paths": result.paths,
    }


def describe_uniformity(result: UniformityResult) -> dict[str, Any]:
    """Return the luminance on the screen's points and the uniformities."""
    return {
        "point_share": [numbers(point) for point in result.point],
        "luminance_cd_m2": numbers(result.luminance),
        "standard_error_cd_m2": numbers(result.standard_error),
        "uniformity_min_over_max": {
            str(count): describe_estimate(value) for count, value in result.uniformity.items()
        },
        "paths": result.paths,
    }


def describe_camera(result: CameraResult) -> dict[str, Any]:
    """Return the picture's lines across the lamps, each in equal parts along them.

    Over LEDs it is one cell's pixels, and how often the cell stands in the picture.
    """
    of_cell = {"pixel_along_mm": result.pixel_along, "cells": result.cells and list(result.cells)}
    return {
        "pixel_mm": result.pixel,
        **(of_cell if result.cells else {}),
        "luminance_cd_m2": [numbers(line) for line in result.luminance],
        "standard_error_cd_m2": [numbers(line) for line in result.standard_error],
        "paths": result.paths,
    }


def describe_panel(result: PanelResult) -> dict[str, Any]:
    """Return the panel's map, a row for each place across the lamps, and its corners."""
    names = ("left_near", "left_far", "right_near", "right_far")
    return {
        "across_mm": numbers(result.across),
        "along_mm": numbers(result.along),
        "luminance_cd_m2": [numbers(row) for row in result.luminance],
        "standard_error_cd_m2": [numbers(row) for row in result.standard_error],
        "corner_over_middle": {
            name: describe_estimate(corner)
            for name, corner in zip(names, result.corner, strict=True)
        },
        "paths": result.paths,
    }


def describe_polarisation(result: PolarisationResult) -> dict[str, Any]:
    """Return the Stokes parameters of the normal light, and the luminance behind a polariser."""
    return {
        "luminance_cd_m2": describe_estimate(result.luminance),
        "along_minus_across": describe_estimate(result.along),
        "diagonal": describe_estimate(result.diagonal),
        "circular": describe_estimate(result.circular),
        "degree_of_polarisation": describe_estimate(result.degree),
        "polariser_angle_deg": _degrees(ANGLES),
        "behind_polariser_cd_m2": [describe_estimate(one) for one in result.behind],
        **_by_band(result),
        "paths": result.paths,
    }


def _by_band(result: PolarisationResult) -> dict[str, Any]:
    """Return Q/I of each band, null of one without light; nothing without bands."""
    if not result.by_band:
        return {}
    wavelength, share = zip(*result.by_band, strict=True)
    return {
        "by_band": {
            "wavelength_nm": list(wavelength),
            "along_minus_across": [describe_estimate(one) for one in share],
        }
    }


def describe_estimate(estimate: Estimate | None, factor: float = 1.0) -> dict[str, Any] | None:
    """Return an estimate times a factor in plain values; None stays None."""
    if estimate is None:
        return None
    return {
        "value": float(estimate.value * factor),
        "ci95": [float(estimate.low * factor), float(estimate.high * factor)],
        "standard_error": float(estimate.standard_error * factor),
    }


def ratio(over: dict[str, Any], under: dict[str, Any]) -> dict[str, Any]:
    """Return the quotient of two described estimates whose errors are independent.

    Standard errors add in quadrature, and so do the distances to the intervals' ends, which keeps
    what each knows of its degrees of freedom (Zou and Donner, "Construction of confidence limits
    about effect measures", 2008).
    """
    value = over["value"] / under["value"]

    def apart(of_over: float, of_under: float) -> float:
        return float(value * np.hypot(of_over / over["value"], of_under / under["value"]))

    def end(of: dict[str, Any], i: int) -> float:
        return of["ci95"][i] - of["value"]

    described = describe_estimate(
        Estimate(
            float(value),
            value - apart(end(over, 0), end(under, 1)),
            value + apart(end(over, 1), end(under, 0)),
            apart(over["standard_error"], under["standard_error"]),
        )
    )
    assert described is not None  # an estimate was given
    return described


def _degrees(values: Any) -> list[float]:
    return [round(float(value), 9) for value in np.degrees(values)]
