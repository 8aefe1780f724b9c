"""What acts on polarisation: layers lowered to the element that is traced, and sheets' share."""

import math

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.dispersion import DEFAULT_WAVELENGTH_NM
from mpfcad.backlight.layer.stated import MUELLER_ENTRIES
from mpfcad.backlight.stack import Stack
from mpfcad.optics.stokes.mueller import MuellerLayer
from mpfcad.optics.stokes.plane import PlaneLayer
from mpfcad.units import deg


def lower_plane(stack: Stack, name: str, words: str) -> PlaneLayer | MuellerLayer:
    """Return the element of a polariser, reflective polariser, retarder or Mueller matrix."""
    kind = stack.own[name].kind

    def value(key: str) -> float:
        return stack[f"{name}.{key}"]

    def both(key: str) -> tuple[float, float]:
        return value(f"{key}_along"), value(f"{key}_across")

    axis = value("axis_deg") * deg
    if kind == "mueller":
        return MuellerLayer(axis, matrix_of(stack, name), words)
    if kind == "retarder":
        wavelength = stack.quantity.get("light_wavelength_nm")
        nm = DEFAULT_WAVELENGTH_NM if wavelength is None else wavelength.value
        waves = value("retardation_waves") + value("retardation_nm") / nm
        return PlaneLayer(axis, retardation=2 * math.pi * waves, name=words)
    back = both("reflection") if kind == "reflective_polariser" else (0.0, 0.0)
    return PlaneLayer(axis, both("transmission"), back, name=words)


def matrix_of(stack: Stack, name: str) -> NDArray[np.float64]:
    """Return the Mueller matrix of a layer, (4, 4) float64."""
    return np.array([stack[f"{name}.{entry}"] for entry in MUELLER_ENTRIES]).reshape(4, 4)


def depolarisation_of(stack: Stack, layer: str) -> float:
    """Return how much of the polarisation a sheet takes: its own value, the stack's, or all."""
    for key in (f"{layer}.depolarisation", "sheet_depolarisation"):
        if key in stack.quantity:
            return stack[key]
    return 1.0
