"""The colour of a screen in outside names and plain values."""

from typing import Any

import numpy as np

from mpfcad.measure.colour.chromaticity import Colour
from mpfcad.measure.colour.screen import ANGLES, ColourResult, Places
from mpfcad.record.luminance import numbers
from mpfcad.record.measurement import describe_estimate


def describe_colour(result: ColourResult, wavelength: tuple[float, ...]) -> dict[str, Any]:
    """Return the colour over the screen and over direction; `wavelength` [nm] of the bands."""
    described: dict[str, Any] = {
        "mean": _describe_mean(result.mean),
        "colour_mura": describe_estimate(result.mura),
        "over_screen": {
            "x_mm": numbers(result.position[:, 0]),
            "y_mm": numbers(result.position[:, 1]),
            **_describe_places(result.over_screen),
        },
        "bands": {"wavelength_nm": list(wavelength), "power_share": numbers(result.power)},
        "paths": int(result.paths),
    }
    if result.across is None or result.along is None:
        return described
    n = len(ANGLES)
    shifts = {"across": result.shift[:n], "along": result.shift[n:]}
    described["over_angle"] = {
        name: {
            "angle_deg": [round(float(one), 9) for one in np.degrees(ANGLES)],
            **_describe_places(places),
            "shift_from_normal": [float(one.value) for one in shifts[name]],
            "shift_ci95": [[float(one.low), float(one.high)] for one in shifts[name]],
        }
        for name, places in (("across", result.across), ("along", result.along))
    }
    return described


def _describe_mean(colour: Colour) -> dict[str, Any]:
    return {
        "luminance_cd_m2": describe_estimate(colour.luminance),
        "x": describe_estimate(colour.x),
        "y": describe_estimate(colour.y),
        "u_prime": describe_estimate(colour.u),
        "v_prime": describe_estimate(colour.v),
    }


def _describe_places(places: Places) -> dict[str, Any]:
    return {
        "luminance_cd_m2": numbers(places.luminance),
        "u_prime": numbers(places.uv[:, 0]),
        "v_prime": numbers(places.uv[:, 1]),
        "standard_error_u_prime": numbers(places.error[:, 0]),
        "standard_error_v_prime": numbers(places.error[:, 1]),
        "degrees_of_freedom": int(places.freedom),
    }
