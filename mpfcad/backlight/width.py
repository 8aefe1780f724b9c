"""How well the numbers of a stack are known: standard uncertainties by kind, where none is stated.

The table holds what data sheets and a ruler give without a measurement of one's own. A number with
`sigma` or `range` in the stack's file or the job has its own; `sigma = 0` says that it is exact.
"""

from typing import NamedTuple

from mpfcad.backlight.quantity import find_range
from mpfcad.backlight.stack import Stack


class Width(NamedTuple):
    """A standard uncertainty and where it comes from."""

    sigma: float
    source: str


class _Kind(NamedTuple):
    size: float
    is_relative: bool
    reason: str


_INDEX = _Kind(0.01, False, "an index from a data sheet, not at the lamps' spectrum")
_GAUGE = _Kind(0.3, False, "a cavity as built, frame and bow")
_SHEET = _Kind(0.08, True, "haze of a data sheet")
_PASS = _Kind(0.01, False, "transmission of a data sheet")
#: By the end of the name; the first that fits. Numbers in none of them are exact: counts, pitches,
#: the panel and the meter; luminances, which change no contrast.
WIDTHS: tuple[tuple[str, _Kind], ...] = (
    ("lamp_height_mm", _GAUGE),
    ("lamp_radius_mm", _Kind(0.05, False, "a tube's tolerance")),
    ("lamp_reflectance", _Kind(0.05, False, "a phosphor's diffuse reflectance, rarely stated")),
    ("plate_thickness_mm", _Kind(0.1, False, "a plate's tolerance")),
    ("thickness_mm", _GAUGE),
    ("reflector_reflectance", _Kind(0.01, False, "reflectance of a data sheet")),
    ("wall_reflectance", _Kind(0.01, False, "reflectance of a data sheet")),
    ("specular_fraction", _Kind(0.1, False, "share of the mirrored light, rarely stated")),
    ("scattering_per_mm", _Kind(0.1, True, "fitted to a haze")),
    ("asymmetry", _Kind(0.02, False, "fitted to a haze")),
    ("absorptance", _Kind(0.1, True, "spectrum of a data sheet")),
    (".yield", _Kind(0.05, False, "quantum yield of a data sheet")),
    ("absorption_per_mm", _Kind(0.3, True, "too small for a data sheet")),
    ("roughness", _Kind(0.3, True, "a facet's slope, rarely measured")),
    ("sheet_sigma", _SHEET),
    (".sigma", _SHEET),
    (".sigma_across", _SHEET),
    (".wide_sigma", _SHEET),
    (".wide_share", _Kind(0.3, True, "share of a lobe, rarely stated")),
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
            size = kind.size * abs(quantity.value) if kind.is_relative else kind.size
            return Width(size, kind.reason)
    return Width(0.0, "exact")


def limits_of(stack: Stack, name: str) -> tuple[float, float]:
    """Return the lowest and highest that one of a stack's numbers can be."""
    found = find_range(name, stack.own, stack.spec)
    return found if found is not None else (-float("inf"), float("inf"))
