"""The numbers of a stack: their names, ranges, and where each comes from."""

import math
from dataclasses import dataclass
from typing import Literal, TypeGuard

from mpfcad.backlight.layer.stated import OWN_VALUES, Layer
from mpfcad.backlight.source.protocol import Range, SourceSpec
from mpfcad.errors import InputError

Tag = Literal["given", "sourced", "assumed"]
TAGS: tuple[Tag, ...] = ("given", "sourced", "assumed")
_ENTRY = {"value", "tag", "source", "sigma", "range"}

_PANEL: dict[str, Range] = {
    "panel_width_mm": (1.0, 10_000.0),
    "panel_length_mm": (1.0, 10_000.0),
}
_LAYERS: dict[str, Range] = {
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
    "wall_reflectance": (0.0, 1.0),
    "wall_specular_fraction": (0.0, 1.0),
}
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
#: How light is polarised; may be left out.
LIGHT_RANGES = {
    "sheet_depolarisation": (0.0, 1.0),
    "film_base_retardation_nm": (0.0, 1e6),
    "film_base_axis_deg": (-360.0, 360.0),
}
#: Layers of a film under its prisms, from below, and what each states, as does the resin in its
#: grooves; all may be left out.
FILM_LAYERS = ("film_base", "film_primer")
FILM_RANGES = {
    "film_absorption_per_mm": (0.0, 100.0),
    "film_roughness": (0.0, 1.0),
    "resin_index": (1.0, 4.0),
    "resin_absorption_per_mm": (0.0, 100.0),
    **{f"{layer}_index": (1.0, 4.0) for layer in FILM_LAYERS},
    **{f"{layer}_thickness_um": (0.01, 10_000.0) for layer in FILM_LAYERS},
    **{f"{layer}_absorption_per_mm": (0.0, 100.0) for layer in FILM_LAYERS},
}


@dataclass(frozen=True)
class Quantity:
    """A number with where it comes from and its standard uncertainty; None: that of its kind."""

    value: float
    tag: Tag
    source: str
    sigma: float | None = None


def ranges_with(spec: SourceSpec) -> dict[str, Range]:
    """Return every value that a stack with such a source must have, and its range."""
    return {**_PANEL, **spec.ranges, **_LAYERS}


def find_range(key: str, own: dict[str, Layer], spec: SourceSpec) -> Range | None:
    """Return (lowest, highest) of a value by its name; None for no value of this stack."""
    optional = (PANEL_RANGES, PARTICLE_RANGES, FILM_RANGES, LIGHT_RANGES)
    for ranges in (ranges_with(spec), spec.panel_ranges, *optional):
        if key in ranges:
            return ranges[key]
    of_one = spec.find_range(key)
    if of_one is not None:
        return of_one
    layer, _, value = key.partition(".")
    if layer in own and value in OWN_VALUES[own[layer].kind]:
        return OWN_VALUES[own[layer].kind][value][:2]
    return None


def read_quantity(
    where: str, key: str, entry: object, own: dict[str, Layer], spec: SourceSpec
) -> Quantity:
    """Return a checked quantity from a number or a {value, tag, source, sigma or range} table.

    Raises
    ------
    InputError
        naming the key, the value and what is expected.
    """
    limits = find_range(key, own, spec)
    if limits is None:
        known = [*ranges_with(spec), *spec.panel_ranges, *PANEL_RANGES, *PARTICLE_RANGES]
        known += [*FILM_RANGES, *LIGHT_RANGES]
        known += spec.patterns()
        known += [f"{name}.{v}" for name, layer in own.items() for v in OWN_VALUES[layer.kind]]
        raise InputError(f"{where}.{key}: unknown value; expected: {', '.join(known)}")
    tag, source, value = "given", "given by the user", entry
    if isinstance(entry, dict):
        if set(entry) - _ENTRY or "value" not in entry:
            raise InputError(f"{where}.{key}: {entry}: expected keys: {', '.join(sorted(_ENTRY))}")
        value = entry["value"]
        tag, source = entry.get("tag", tag), str(entry.get("source", source))
    tagged: Tag | None = next((one for one in TAGS if one == tag), None)
    if tagged is None:
        raise InputError(f"{where}.{key}: tag {tag!r}: expected one of {', '.join(TAGS)}")
    low, high = limits
    if (
        not isinstance(value, int | float)
        or isinstance(value, bool)
        or not math.isfinite(value)
        or not low <= value <= high
    ):
        raise InputError(f"{where}.{key}: {value!r}: expected a number in {low:g} … {high:g}")
    if key.endswith("_count") and value != int(value):
        raise InputError(f"{where}.{key}: {value}: expected a whole number")
    sigma = None
    if isinstance(entry, dict):
        sigma = _read_sigma(f"{where}.{key}", value, entry, limits)
    return Quantity(value, tagged, source, sigma)


def _read_sigma(where: str, value: float, entry: dict[str, object], limits: Range) -> float | None:
    """Return the standard uncertainty that an entry states; a range is taken as uniform.

    Neither reaches beyond what the value can be.
    """
    least, most = limits
    if "sigma" in entry and "range" in entry:
        raise InputError(f"{where}: sigma and range: expected one of them")
    if "sigma" in entry:
        sigma = entry["sigma"]
        if not _is_number(sigma) or not sigma >= 0:
            raise InputError(f"{where}.sigma: {sigma!r}: expected a number of 0 or more")
        if sigma > most - least:
            raise InputError(
                f"{where}.sigma: {sigma:g}: expected at most {most - least:g}, as much as the "
                "value can be off"
            )
        return float(sigma)
    if "range" not in entry:
        return None
    ends = entry["range"]
    if not isinstance(ends, list) or len(ends) != 2 or not all(map(_is_number, ends)):
        raise InputError(f"{where}.range: {ends!r}: expected [lowest, highest], two finite numbers")
    low, high = map(float, ends)
    if not low <= value <= high:
        raise InputError(f"{where}.range: {ends}: expected to hold the value {value:g}")
    if low < least or high > most:
        raise InputError(f"{where}.range: {ends}: expected to lie within {least:g} … {most:g}")
    return (high - low) / math.sqrt(12)


def _is_number(value: object) -> TypeGuard[float]:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    return math.isfinite(value)
