"""The numbers of a stack: their names, ranges, and where each comes from."""

import math
import re
from dataclasses import dataclass
from typing import Literal

from mpfcad.backlight.layer import OWN_VALUES, Layer
from mpfcad.errors import InputError

Tag = Literal["given", "sourced", "assumed"]
TAGS = ("given", "sourced", "assumed")

_TINY = 1e-6
#: Every value that a stack must have and its allowed range, in the unit of its name.
RANGES = {
    "panel_width_mm": (1.0, 10_000.0),
    "panel_length_mm": (1.0, 10_000.0),
    "lamp_count": (1, 10_000),
    "lamp_pitch_mm": (0.1, 1000.0),
    "lamp_radius_mm": (0.01, 100.0),
    "lamp_height_mm": (0.01, 1000.0),
    "lamp_reflectance": (0.0, 1.0),
    "lamp_luminance_cd_m2": (_TINY, 1e9),
    "thickness_mm": (0.1, 1000.0),
    "reflector_reflectance": (0.0, 1.0),
    "reflector_specular_fraction": (0.0, 1.0),
    "plate_index": (1.0, 4.0),
    "plate_thickness_mm": (0.01, 100.0),
    "plate_scattering_per_mm": (0.0, 100.0),
    "plate_asymmetry": (-0.99, 0.99),
    "plate_absorption_per_mm": (0.0, 100.0),
    "bottom_sheet_sigma": (0.0, 10.0),
    "top_sheet_sigma": (0.0, 10.0),
    "sheet_index": (1.0, 4.0),
    "sheet_transmission": (0.0, 1.0),
    "film_index": (1.0, 4.0),
    "meter_acceptance_deg": (0.0, 45.0),
    "meter_spot_mm": (0.0, 1000.0),
}
#: Of a finite panel only.
PANEL_RANGES = {
    "lamp_length_mm": (1.0, 10_000.0),
    "wall_reflectance": (0.0, 1.0),
    "wall_specular_fraction": (0.0, 1.0),
}
#: Of one lamp of a finite panel, `lamp_3_shift_mm`; lamps count from 1 at the left.
LAMP_RANGES = {"luminance_factor": (0.0, 100.0), "shift_mm": (-1000.0, 1000.0)}
_PARTICLE = {
    "particle_radius_um": (0.001, 20.0),
    "particle_index": (1.0, 4.0),
    "particle_density_per_mm3": (0.0, 1e15),
}
#: Particles in the diffusing plate and in the resin, or the resin's coefficients themselves.
PARTICLE_RANGES = {
    **{f"plate_{name}": limits for name, limits in _PARTICLE.items()},
    **{f"resin_{name}": limits for name, limits in _PARTICLE.items()},
    "resin_scattering_per_mm": (0.0, 10_000.0),
    "resin_asymmetry": (-0.99, 0.99),
    "light_wavelength_nm": (200.0, 2000.0),
}
_LAMP = re.compile(r"lamp_([1-9][0-9]*)_(" + "|".join(LAMP_RANGES) + ")")


@dataclass(frozen=True)
class Quantity:
    """A number with where it comes from."""

    value: float
    tag: Tag
    source: str


def lamp_of(key: str) -> int | None:
    """Return the number of the lamp that a value is of, or None."""
    match = _LAMP.fullmatch(key)
    return int(match[1]) if match else None


def find_range(key: str, own: dict[str, Layer]) -> tuple[float, float] | None:
    """Return (lowest, highest) of a value by its name; None for no value of this stack."""
    for ranges in (RANGES, PANEL_RANGES, PARTICLE_RANGES):
        if key in ranges:
            return ranges[key]
    match = _LAMP.fullmatch(key)
    if match:
        return LAMP_RANGES[match[2]]
    layer, _, value = key.partition(".")
    if layer in own and value in OWN_VALUES[own[layer].kind]:
        return OWN_VALUES[own[layer].kind][value][:2]
    return None


def read_quantity(where: str, key: str, entry: object, own: dict[str, Layer]) -> Quantity:
    """Return a checked quantity from a number or a {value, tag, source} table.

    Raises
    ------
    InputError
        naming the key, the value and what is allowed.
    """
    limits = find_range(key, own)
    if limits is None:
        known = [*RANGES, *PANEL_RANGES, *PARTICLE_RANGES, *(f"lamp_N_{n}" for n in LAMP_RANGES)]
        known += [f"{name}.{v}" for name, layer in own.items() for v in OWN_VALUES[layer.kind]]
        raise InputError(f"{where}.{key}: unknown value; allowed: {', '.join(known)}")
    tag, source, value = "given", "given by the user", entry
    if isinstance(entry, dict):
        if set(entry) - {"value", "tag", "source"} or "value" not in entry:
            raise InputError(f"{where}.{key}: {entry}: allowed keys: value, tag, source")
        value = entry["value"]
        tag, source = entry.get("tag", tag), str(entry.get("source", source))
    if tag not in TAGS:
        raise InputError(f"{where}.{key}: tag {tag!r}: must be one of {', '.join(TAGS)}")
    low, high = limits
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or not low <= value <= high:
        raise InputError(f"{where}.{key}: {value}: must be a number in {low:g} … {high:g}")
    if key == "lamp_count" and value != int(value):
        raise InputError(f"{where}.{key}: {value}: must be a whole number")
    return Quantity(value, tag, source)
