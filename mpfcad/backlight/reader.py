"""Reads a stack from a preset or a TOML file and checks every number."""

import math
import tomllib
from pathlib import Path

from mpfcad.backlight.bsdf_layer import BsdfLayer, read_bsdf_layer
from mpfcad.backlight.stack import LAYERS, RANGES, Quantity, Stack
from mpfcad.errors import InputError

_PRESETS = Path(__file__).parent / "preset"
_KEYS = {"schema", "extends", "title", "layers", "reflector", "value"}
_TAGS = ("given", "sourced", "assumed")


def list_stacks() -> list[Stack]:
    """Return the presets that can be traced, by name."""
    return [read_stack(name) for name in sorted(p.stem for p in _PRESETS.glob("*-*-*.toml"))]


def read_stack(
    name: str | Path, thickness: float | None = None, overrides: dict[str, float] | None = None
) -> Stack:
    """Return a stack by preset name or from a TOML file, with values of the job's own on top.

    A file has `title`, `layers` (from the lamps up), `extends` (a preset or another file beside it)
    and a table `[value]` of `name = number` (tagged `given`) or `name = {value, tag, source}`.
    `thickness` [mm] and `overrides` (names with unit suffix) are tagged `given`.

    Raises
    ------
    InputError
        when the file, a key, a layer or a value is wrong; the text names it and the allowed range.
    """
    where = str(name)
    title, layers, quantity, reflector = _read(name, set())
    given = dict(overrides or {})
    if thickness is not None:
        given["thickness_mm"] = thickness
    for key, value in given.items():
        quantity[key] = _quantity(f"{where}: stack.override", key, value)
    missing = [key for key in RANGES if key not in quantity]
    if missing:
        raise InputError(f"{where}: value.{missing[0]}: missing: extend a preset or give them all")
    names = _check_layers(where, layers)
    tables = tuple(layer for layer in layers if isinstance(layer, BsdfLayer))
    stack = Stack(Path(where).stem, title, tuple(names), quantity, tables, reflector)
    _check_fits(where, stack)
    return stack


def _read(
    name: str | Path, seen: set[str]
) -> tuple[str, list[str | BsdfLayer], dict[str, Quantity], BsdfLayer | None]:
    """Return (title, layers, quantities, reflector) of a preset or file with what it extends."""
    path = _find(name)
    where = str(name)
    if str(path) in seen:
        raise InputError(f"{where}: extends: {name}: extends itself")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise InputError(f"{where}: {error}") from error
    unknown = sorted(set(table) - _KEYS)
    if unknown:
        raise InputError(f"{where}: {unknown[0]}: unknown key; allowed: {', '.join(sorted(_KEYS))}")
    title, layers, quantity, reflector = where, [], {}, None
    if "extends" in table:
        base = str(table["extends"])
        beside = path.parent / base
        title, layers, quantity, reflector = _read(
            beside if beside.suffix == ".toml" and beside.is_file() else base, seen | {str(path)}
        )
    values = table.get("value", {})
    if not isinstance(values, dict):
        raise InputError(f"{where}: value: {values!r}: must be a table")
    for key, value in values.items():
        quantity[key] = _quantity(f"{where}: value", key, value)
    if "layers" in table:
        layers = _with_tables(where, path.parent, table["layers"])
    if "reflector" in table:
        entry = table["reflector"]
        if not isinstance(entry, dict):
            raise InputError(f"{where}: reflector: {entry!r}: must be a table with file")
        reflector = read_bsdf_layer(f"{where}: reflector", path.parent, entry)
    return str(table.get("title", title)), layers, quantity, reflector


def _with_tables(where: str, folder: Path, layers: object) -> list[str | BsdfLayer]:
    """Return the layers, BSDF tables read."""
    if not isinstance(layers, list):
        raise InputError(f"{where}: layers: {layers}: must list layers from the lamps up")
    return [
        read_bsdf_layer(f"{where}: layers[{i}]", folder, entry)
        if isinstance(entry, dict)
        else entry
        for i, entry in enumerate(layers)
    ]


def _find(name: str | Path) -> Path:
    path = Path(name)
    if path.suffix == ".toml":
        if not path.is_file():
            raise InputError(f"{name}: stack file not found")
        return path
    preset = _PRESETS / f"{name}.toml"
    if "/" in str(name) or not preset.is_file():
        known = ", ".join(sorted(p.stem for p in _PRESETS.glob("*-*-*.toml")))
        raise InputError(f"stack: {name}: no such preset; known: {known}; a file ends in .toml")
    return preset


def _quantity(where: str, key: str, entry: object) -> Quantity:
    """Return a checked quantity from a number or a {value, tag, source} table."""
    if key not in RANGES:
        raise InputError(f"{where}.{key}: unknown value; allowed: {', '.join(RANGES)}")
    tag, source, value = "given", "given by the user", entry
    if isinstance(entry, dict):
        if set(entry) - {"value", "tag", "source"} or "value" not in entry:
            raise InputError(f"{where}.{key}: {entry}: allowed keys: value, tag, source")
        value = entry["value"]
        tag, source = entry.get("tag", tag), str(entry.get("source", source))
    if tag not in _TAGS:
        raise InputError(f"{where}.{key}: tag {tag!r}: must be one of {', '.join(_TAGS)}")
    low, high = RANGES[key]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or not low <= value <= high:
        raise InputError(f"{where}.{key}: {value}: must be a number in {low:g} … {high:g}")
    if key == "lamp_count" and value != int(value):
        raise InputError(f"{where}.{key}: {value}: must be a whole number")
    return Quantity(value, tag, source)


def _check_layers(where: str, entries: list[str | BsdfLayer]) -> list[str]:
    """Return the layers' names after checking them."""
    layers = ["bsdf" if isinstance(entry, BsdfLayer) else entry for entry in entries]
    if not layers:
        raise InputError(f"{where}: layers: {layers}: must list layers from the lamps up")
    for layer, entry in zip(layers, entries, strict=True):
        if layer not in LAYERS or entry == "bsdf":
            raise InputError(
                f"{where}: layers: {layer}: must be one of {', '.join(LAYERS)}; a bsdf is a table "
                '{ kind = "bsdf", file = … }'
            )
    films = [layer for layer in layers if layer.endswith("film")]
    if len(films) > 1 or not (films or "bsdf" in layers):
        raise InputError(f"{where}: layers: {len(films)} films: must be exactly one")
    at = layers.index(films[0]) if films else 0
    if films == ["bonded_film"] and (at == 0 or not layers[at - 1].endswith("_plate")):
        raise InputError(f"{where}: layers: bonded_film: must lie directly on a plate")
    if sum(layer.endswith("_plate") for layer in layers) > 1:
        raise InputError(f"{where}: layers: more than one plate: at most one")
    return layers


def _check_fits(where: str, stack: Stack) -> None:
    """Raise unless the lamps fit under the plate, beside each other and on the panel."""
    radius, height = stack["lamp_radius_mm"], stack["lamp_height_mm"]
    if height < radius:
        raise InputError(
            f"{where}: lamp_height_mm: {height:g}: must be at least the radius {radius:g}"
        )
    if stack.thickness <= height + radius:
        raise InputError(
            f"{where}: thickness_mm: {stack.thickness:g}: must be above the lamps' tops at "
            f"{height + radius:g} mm"
        )
    if stack.lamp_pitch <= 2 * radius:
        raise InputError(
            f"{where}: lamp_pitch_mm: {stack.lamp_pitch:g}: must be above the lamps' diameter "
            f"{2 * radius:g}"
        )
    if stack.lamp_position(0) < 0:
        raise InputError(
            f"{where}: lamp_count: {stack.lamp_count}: at pitch {stack.lamp_pitch:g} mm the row is "
            f"wider than the panel's {stack.panel_width:g} mm"
        )
