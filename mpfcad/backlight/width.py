"""How well the numbers of a stack are known: standard uncertainties by kind, where none is stated.

The table holds what data sheets and a ruler give without a measurement of one's own. A number with
`sigma` or `range` in the stack's file or the job has its own; `sigma = 0` says that it is exact.
"""

import math
from typing import NamedTuple

from mpfcad.backlight.quantity import find_range
from mpfcad.backlight.stack import Stack


class Width(NamedTuple):
    """A standard uncertainty and where it comes from."""

    sigma: float
    source: str


class _Kind(NamedTuple):
    """A size in the value's unit, a share of the value, or the smaller one of both."""

    reason: str
    size: float = math.inf
    share: float = math.inf

    def of(self, value: float) -> Width:
        """Return the width of a value; what is not there (0) is exact by its share."""
        return Width(min(self.size, self.share * abs(value)), self.reason)


_INDEX = _Kind("an index from a data sheet, not at the source's spectrum", 0.01)
_PLATE = _Kind("a plate's tolerance, at most a tenth of a thin one", 0.1, 0.1)
_SHEET = _Kind("haze of a data sheet", share=0.08)
_PASS = _Kind("transmission of a data sheet", 0.01)
_WHITE = _Kind("reflectance of a data sheet", 0.01)
_PACKAGE = _Kind("an LED's package as drawn, at most a tenth of a chip", 0.1, 0.1)
_CUP = _Kind("a punched or formed sheet, at most a tenth of a small cup", 0.1, 0.1)
_BEAM = _Kind("an angle of a data sheet, bin and mounting", 3.0)
#: By the end of the name; the first that fits. Numbers in none of them are exact: counts, pitches,
#: the panel and the meter; luminances and the LEDs' mean flux, which change no contrast; spreads of
#: flux and place, which are widths themselves.
WIDTHS: tuple[tuple[str, _Kind], ...] = (
    ("lamp_height_mm", _Kind("a cavity as built, frame and bow", 0.3)),
    ("lamp_radius_mm", _Kind("a tube's tolerance", 0.05)),
    ("lamp_reflectance", _Kind("a phosphor's diffuse reflectance, rarely stated", 0.05)),
    ("led_half_angle_deg", _BEAM),
    ("led_peak_angle_deg", _BEAM),
    ("led_width_mm", _PACKAGE),
    ("led_length_mm", _PACKAGE),
    ("led_height_mm", _Kind("a package and its solder, at most a fifth of a chip", 0.1, 0.2)),
    ("led_reflectance", _Kind("package, phosphor and pads together, rarely stated", 0.05)),
    ("led_hole_radius_mm", _Kind("a punched hole and its place, at most a tenth", 0.1, 0.1)),
    ("led_hole_reflectance", _Kind("a solder mask, white to yellow", 0.03)),
    ("led_cup_height_mm", _CUP),
    ("led_cup_radius_mm", _CUP),
    ("led_cup_rim_radius_mm", _CUP),
    ("led_cup_reflectance", _WHITE),
    ("plate_thickness_mm", _PLATE),
    (".thickness_mm", _PLATE),
    # Frame and bow grow with the cavity: a module of 1.4 mm holds its distance by spacers.
    ("thickness_mm", _Kind("a cavity as built, at most 5 % of a thin one", 0.3, 0.05)),
    ("reflector_reflectance", _WHITE),
    ("wall_reflectance", _WHITE),
    ("specular_fraction", _Kind("share of the mirrored light, rarely stated", 0.1)),
    ("scattering_per_mm", _Kind("fitted to a haze", share=0.1)),
    ("asymmetry", _Kind("fitted to a haze", 0.02)),
    ("absorptance", _Kind("spectrum of a data sheet", share=0.1)),
    (".yield", _Kind("quantum yield of a data sheet", 0.05)),
    ("absorption_per_mm", _Kind("too small for a data sheet", share=0.3)),
    ("roughness", _Kind("a facet's slope, rarely measured", share=0.3)),
    ("sheet_sigma", _SHEET),
    (".sigma", _SHEET),
    (".sigma_across", _SHEET),
    (".wide_sigma", _SHEET),
    (".wide_share", _Kind("share of a lobe, rarely stated", share=0.3)),
    ("sheet_transmission", _PASS),
    (".transmission", _PASS),
    ("index", _INDEX),
)


def width_of(stack: Stack, name: str) -> Width:
    """Return the standard uncertainty of one of a stack's numbers; 0 of an exact one."""
    quantity = stack.quantity[name]
    if quantity.sigma is not None:
        return Width(quantity.sigma, "stated")
    for end, kind in WIDTHS:
        if name.endswith(end):
            return kind.of(quantity.value)
    return Width(0.0, "exact")


def limits_of(stack: Stack, name: str) -> tuple[float, float]:
    """Return the lowest and highest that one of a stack's numbers can be."""
    found = find_range(name, stack.own, stack.spec)
    return found if found is not None else (-float("inf"), float("inf"))
