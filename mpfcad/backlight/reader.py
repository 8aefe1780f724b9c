"""Reads a stack from a preset or a TOML file and checks every number."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from mpfcad.backlight.check import check_layers, check_made
from mpfcad.backlight.derive import derive
from mpfcad.backlight.dispersion import DEFAULT_WAVELENGTH_NM, LAWS, dispersed
from mpfcad.backlight.layer.bsdf import BsdfLayer, read_bsdf_layer
from mpfcad.backlight.layer.stated import CONVERTER, read_layer
from mpfcad.backlight.light import Light, build_bands, read_light
from mpfcad.backlight.quantity import ranges_with, read_quantity
from mpfcad.backlight.source import SourceSpec, TubeSpec, read_spec
from mpfcad.backlight.stack import EXTENTS, Stack
from mpfcad.boundary import guarded, read_toml
from mpfcad.errors import InputError
from mpfcad.spectrum import Spectrum, read_spectrum

_PRESETS = Path(__file__).parent / "preset"
#: Longest chain of files that extend one another.
_MOST_EXTENDED = 20
_KEYS = {
    "schema", "extends", "title", "layers", "value", "extent", "reflector", "source", "light",
}  # fmt: skip


@dataclass
class _Text:
    """What a file and those it extends state: layers beside `folder`, values by name."""

    title: str
    layers: object = field(default_factory=list)
    folder: Path = Path()
    extent: object = "pitch"
    value: dict[str, tuple[str, object]] = field(default_factory=dict)
    table: dict[str, BsdfLayer] = field(default_factory=dict)
    spec: SourceSpec = field(default_factory=TubeSpec)
    light: Light = field(default_factory=Light)
    emission: dict[str, Spectrum] = field(default_factory=dict)


def list_stacks() -> list[Stack]:
    """Return the presets that can be traced, by name."""
    return [read_stack(name) for name in sorted(p.stem for p in _PRESETS.glob("*-*-*.toml"))]


def is_stack_file(path: Path) -> bool:
    """Return whether a TOML file is a stack, as no other file of mpfcad has layers or extends one.

    Raises
    ------
    InputError
        when it cannot be read, or is no TOML.
    """
    return bool({"extends", "layers"} & set(read_toml(path)))


def read_stack(
    name: str | Path, thickness: float | None = None, overrides: dict[str, Any] | None = None
) -> Stack:
    """Return a stack by preset name or from a TOML file, with values of the job's own on top.

    A file has `title`, `layers` (from the lamps up), `extent`, `extends` (a preset or another file
    beside it) and a table `[value]` of `name = number` (tagged `given`) or `name = {value, tag,
    source}`, and a table `[light]` (`light`). `thickness` [mm] and `overrides` (names with
    unit suffix, `extent`, or `light`) are `given`.

    Raises
    ------
    InputError
        when the file, a key, a layer or a value is wrong; the text names it and the expected range.
    """
    where = str(name)
    with guarded(where, "a stack"):
        return _read_stack(where, name, thickness, overrides)


def _read_stack(
    where: str, name: str | Path, thickness: float | None, overrides: dict[str, Any] | None
) -> Stack:
    text = _read(name, set())
    given = dict(overrides or {})
    if "extent" in given:
        text.extent = given.pop("extent")
    if "light" in given:
        at = f"{where}: stack.override.light"
        text.light = read_light(at, None, given.pop("light"), text.light)
    if thickness is not None:
        given["thickness_mm"] = thickness
    text.value.update(_flat(f"{where}: stack.override", given))
    extent = next((one for one in EXTENTS if one == text.extent), None)
    if extent is None:
        raise InputError(f"{where}: extent: {text.extent!r}: expected one of {', '.join(EXTENTS)}")
    layers, own = _read_layers(where, text)
    _, wavelength = text.value.get("light_wavelength_nm", ("", DEFAULT_WAVELENGTH_NM))
    quantity = _quantities(text, own, wavelength, "light_wavelength_nm")
    missing = [key for key in ranges_with(text.spec) if key not in quantity]
    if missing:
        raise InputError(
            f"{where}: value.{missing[0]}: missing: expected all values, or extends = a preset"
        )
    stack = Stack(
        Path(where).stem, text.title, layers, quantity, extent, own, tables=text.table,
        spec=text.spec, polarised=text.light.polarised,
    )  # fmt: skip
    check_layers(where, stack)
    stack = derive(where, stack)
    check_made(where, stack)
    stack.source.check(where)
    value = _at_bands(where, text, stack)
    return replace(stack, bands=build_bands(where, text.light, text.emission, value))


def _quantities(text: _Text, own: dict[str, Any], wavelength: object, of: str) -> Any:
    """Return every value that is stated, laws of dispersion at a wavelength [nm]."""
    return {
        key: read_quantity(at, key, dispersed(at, key, entry, wavelength, of), own, text.spec)
        for key, (at, entry) in text.value.items()
    }


def _at_bands(where: str, text: _Text, stack: Stack) -> dict[str, tuple[float, ...]]:
    """Return the values that differ from one band to another, by name, what follows among them."""
    at_band = []
    for wavelength in text.light.bands or ():
        quantity = _quantities(text, stack.own, wavelength, "light.bands")
        if "light_wavelength_nm" in stack.quantity:
            stated = stack.quantity["light_wavelength_nm"]
            quantity["light_wavelength_nm"] = replace(stated, value=wavelength)
        at_band.append(derive(where, replace(stack, quantity=quantity)))
    differing = {}
    for key in stack.quantity if at_band else ():
        values = tuple(one[key] for one in at_band)
        # A retardation in nm is a phase of its own at each wavelength.
        delays = key.endswith("retardation_nm") and stack[key] > 0
        if (len({stack[key], *values}) > 1 or delays) and key != "light_wavelength_nm":
            differing[key] = values
    return differing


def _read_layers(where: str, text: _Text) -> tuple[tuple[str, ...], dict[str, Any]]:
    """Return the layers' names and those with values of their own, whose values join `text`'s."""
    if not isinstance(text.layers, list) or not text.layers:
        raise InputError(f"{where}: layers: {text.layers}: expected layers from the lamps up")
    names, own, values = [], {}, {}
    for place, entry in enumerate(text.layers, 1):
        with guarded(f"{where}: layers: entry {place}", "the name of a layer or its table"):
            name, layer, given = read_layer(where, entry, place, text.folder)
        if layer is not None:
            if name in names:
                raise InputError(f"{where}: layers: {name}: name: expected once")
            own[name] = layer
            if layer.kind == CONVERTER:
                at = f"{where}: layers: {name}.emission"
                text.emission[name] = read_spectrum(at, text.folder, entry.get("emission"))
            if layer.kind == "bsdf":
                text.table[name] = read_bsdf_layer(f"{where}: layers: {name}", text.folder, entry)
        names.append(name)
        values.update(_flat(f"{where}: layers", {name: given}) if given else {})
    text.value = {**values, **text.value}
    return tuple(names), own


def _flat(where: str, values: Mapping[str, Any]) -> dict[str, tuple[str, object]]:
    """Return values with those of tables of a layer's own as `layer.value`."""
    flat = {}
    for key, entry in values.items():
        if (
            isinstance(entry, Mapping)
            and entry
            and "value" not in entry
            and not {"tag", "source", *LAWS} & {*entry}
        ):
            flat.update({f"{key}.{inner}": (where, value) for inner, value in entry.items()})
        else:
            flat[key] = (where, entry)
    return flat


def _read(name: str | Path, seen: set[str]) -> _Text:
    """Return what a preset or file states, with what it extends."""
    path = _find(name)
    where = str(name)
    if str(path) in seen:
        raise InputError(f"{where}: extends: {name}: extends itself")
    if len(seen) >= _MOST_EXTENDED:
        raise InputError(f"{where}: extends: more than {_MOST_EXTENDED} files: expected fewer")
    table = read_toml(path)
    unknown = sorted(set(table) - _KEYS)
    if unknown:
        raise InputError(
            f"{where}: {unknown[0]}: unknown key; expected: {', '.join(sorted(_KEYS))}"
        )
    text = _Text(where)
    if "extends" in table:
        base = table["extends"]
        if not isinstance(base, str):
            raise InputError(f"{where}: extends: {base!r}: expected a preset's or a file's name")
        beside = path.parent / base
        found = beside if beside.suffix == ".toml" and beside.exists() else base
        text = _extended(f"{where}: extends", found, seen | {str(path)})
    values = table.get("value", {})
    if not isinstance(values, dict):
        raise InputError(f"{where}: value: {values!r}: expected a table")
    text.value.update(_flat(f"{where}: value", values))
    if "layers" in table:
        text.layers, text.folder = table["layers"], path.parent
    if "reflector" in table:
        entry = table["reflector"]
        if not isinstance(entry, dict):
            raise InputError(f"{where}: reflector: {entry!r}: expected a table with file")
        text.table["reflector"] = read_bsdf_layer(
            f"{where}: reflector", path.parent, entry, reflector=True
        )
    if "source" in table:
        text.spec = read_spec(where, path.parent, table["source"])
    if "light" in table:
        text.light = read_light(f"{where}: light", path.parent, table["light"], text.light)
    text.title = str(table.get("title", text.title))
    text.extent = table.get("extent", text.extent)
    return text


def _extended(where: str, name: str | Path, seen: set[str]) -> _Text:
    try:
        return _read(name, seen)
    except InputError as error:
        text = str(error)
        raise InputError(text if ": extends: " in text else f"{where}: {text}") from None


def _find(name: str | Path) -> Path:
    path = Path(name)
    if path.suffix == ".toml":
        if not path.is_file():
            raise InputError(f"{name}: no such file: expected a stack")
        return path
    preset = _PRESETS / f"{name}.toml"
    if "/" in str(name) or not preset.is_file():
        known = ", ".join(sorted(p.stem for p in _PRESETS.glob("*-*-*.toml")))
        raise InputError(
            f"stack: {name}: no such preset: expected one of {known}, or a file that ends in .toml"
        )
    return preset
