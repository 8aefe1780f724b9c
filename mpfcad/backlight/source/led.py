"""A board of LEDs over a reflector: what a stack file says of it."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.board import LedBoard
from mpfcad.backlight.source.emission import FORMULAS, read_emission
from mpfcad.backlight.source.lattice import LATTICES, folder_text, read_positions
from mpfcad.backlight.source.protocol import Range, StackValues
from mpfcad.backlight.source.zone import ZoneSpec, read_zones
from mpfcad.errors import InputError

_KEYS = (
    "kind", "lattice", "positions", "emission", "cup", "repeat", "dead", "seed", "zones", "tag",
    "source",
)  # fmt: skip
#: Which formula a value is of.
_OF_FORMULA = {"led_half_angle_deg": "cosine", "led_peak_angle_deg": "batwing"}
#: Shapes of a cup; the first is none.
_CUPS = ("", "round", "square")
_CUP = "led_cup_"
_MOST_REPEAT = 20


@dataclass(frozen=True)
class LedSpec:
    """LEDs: their lattice or list, how they emit, and how binning spreads them.

    Attributes
    ----------
    lattice, emission
        a key of `LATTICES`; one of `FORMULAS`, or the name of a measured file
    listed
        x, y [mm] and flux factor of each LED of a list
    intensity
        rows of a measured file's table
    repeat
        cells that are traced together along x and y
    dead
        numbers, from 1, of LEDs that do not shine
    seed
        of the draws of flux and place
    tag, source
        where a measured emission comes from
    files
        SHA-256 of each file read, by its name
    zones
        how many are dimmed by themselves across and along the panel, or their rectangles; or none
    cup
        one of `_CUPS`
    """

    lattice: str = "square"
    emission: str = "cosine"
    listed: tuple[tuple[float, ...], ...] = ()
    intensity: tuple[tuple[float, ...], ...] = ()
    repeat: tuple[int, int] = (1, 1)
    dead: tuple[int, ...] = ()
    seed: int = 1
    tag: str = "given"
    source: str = "given by the user"
    files: Mapping[str, str] = field(default_factory=dict)
    zones: ZoneSpec | None = None
    cup: str = ""

    kind: ClassVar[str] = "leds"
    ranges: ClassVar[Mapping[str, Range]] = {
        "led_pitch_across_mm": (0.05, 1000.0),
        "led_pitch_along_mm": (0.05, 1000.0),
        "led_width_mm": (0.01, 100.0),
        "led_length_mm": (0.01, 100.0),
        "led_height_mm": (0.0, 100.0),
        "led_flux_lm": (1e-6, 1e6),
        "led_reflectance": (0.0, 1.0),
    }
    panel_ranges: ClassVar[Mapping[str, Range]] = {}
    defaults: ClassVar[Mapping[str, str]] = {}
    optional: ClassVar[Mapping[str, tuple[Range, str | float]]] = {
        "led_half_angle_deg": ((1.0, 89.0), 60.0),
        "led_peak_angle_deg": ((20.0, 85.0), 65.0),
        "led_hole_radius_mm": ((0.0, 100.0), 0.0),
        "led_hole_reflectance": ((0.0, 1.0), "reflector_reflectance"),
        "led_cup_height_mm": ((0.0, 100.0), 0.0),
        "led_cup_radius_mm": ((0.0, 500.0), 0.0),
        "led_cup_rim_radius_mm": ((0.0, 500.0), "led_cup_radius_mm"),
        "led_cup_reflectance": ((0.0, 1.0), "reflector_reflectance"),
        "led_cup_specular_fraction": ((0.0, 1.0), "reflector_specular_fraction"),
        "led_flux_spread": ((0.0, 1.0), 0.0),
        "led_position_error_mm": ((0.0, 10.0), 0.0),
    }

    @classmethod
    def read(cls, where: str, folder: Path, entry: Mapping[str, Any]) -> "LedSpec":
        """Return the spec of a stack file's `[source]`, its files beside `folder`.

        Raises
        ------
        InputError
            naming the key and what is expected.
        """
        where = f"{where}: source"
        unknown = sorted(set(entry) - set(_KEYS))
        if unknown:
            raise InputError(f"{where}.{unknown[0]}: unknown key; expected {', '.join(_KEYS)}")
        lattice, emission = entry.get("lattice", "square"), str(entry.get("emission", "cosine"))
        if lattice not in LATTICES:
            raise InputError(f"{where}.lattice: {lattice}: expected {', '.join(LATTICES)}")
        if ("positions" in entry) != (lattice == "list"):
            raise InputError(f"{where}.positions: expected with lattice list, and only there")
        names: list[str] = []
        listed: tuple[tuple[float, ...], ...] = ()
        intensity: tuple[tuple[float, ...], ...] = ()
        if lattice == "list":
            names.append(str(entry["positions"]))
            text = folder_text(f"{where}.positions", folder, names[-1])
            listed = _rows(read_positions(f"{where}.positions: {names[-1]}", text))
        if emission not in FORMULAS:
            names.append(emission)
            intensity = _rows(read_emission(f"{where}.emission", folder, emission))
        zones = None
        if "zones" in entry:
            zones = read_zones(f"{where}.zones", folder, entry["zones"])
            names += [str(entry["zones"])] if isinstance(entry["zones"], str) else []
        files = {n: hashlib.sha256((folder / n).read_bytes()).hexdigest() for n in names}
        return cls(
            lattice, emission, listed, intensity, _repeat(where, entry.get("repeat", [1, 1])),
            _numbers(where, entry.get("dead", [])), _seed(where, entry.get("seed", 1)),
            str(entry.get("tag", "given")), str(entry.get("source", "given by the user")), files,
            zones, _cup(where, entry.get("cup", "")),
        )  # fmt: skip

    @classmethod
    def restore(cls, document: Mapping[str, Any]) -> "LedSpec":
        """Return the spec that was described."""
        values = {key: value for key, value in document.items() if key != "kind"}
        for key in ("listed", "intensity"):
            values[key] = tuple(map(tuple, values[key]))
        for key in ("repeat", "dead"):
            values[key] = tuple(values[key])
        values["zones"] = ZoneSpec.restore(values.get("zones"))
        return cls(**values)

    def describe(self) -> dict[str, Any]:
        """Return the spec as plain values."""
        return {
            "kind": self.kind,
            "lattice": self.lattice,
            "emission": self.emission,
            "listed": [list(row) for row in self.listed],
            "intensity": [list(row) for row in self.intensity],
            "repeat": list(self.repeat),
            "dead": list(self.dead),
            "seed": self.seed,
            "tag": self.tag,
            "source": self.source,
            "files": dict(self.files),
            **({} if self.zones is None else {"zones": self.zones.describe()}),
            **({"cup": self.cup} if self.cup else {}),
        }

    def find_range(self, key: str) -> Range | None:
        """Return the range of a value that may be left out."""
        return self.optional[key][0] if key in self.optional else None

    def numbered(self, keys: Mapping[str, Any]) -> list[str]:
        """Return the values that may be left out, where they are there."""
        used = [k for k in self.optional if _OF_FORMULA.get(k, self.emission) == self.emission]
        return [k for k in used if k in keys and (self.cup or not k.startswith(_CUP))]

    def patterns(self) -> list[str]:
        """Return the values that may be left out."""
        return list(self.optional)

    def inputs(self) -> list[dict[str, Any]]:
        """Return lattice and emission as {name, value, tag, source}."""
        tag = {"tag": self.tag, "source": self.source}
        files = "; ".join(f"{name}, SHA-256 {sha}" for name, sha in self.files.items())
        seen = {**tag, "source": f"{self.source}; {files}"} if files else tag
        return [
            {"name": "led_lattice", "value": self.lattice, **seen},
            {"name": "led_emission", "value": self.emission, **seen},
            *([{"name": "led_zones", "value": self.zones.words, **tag}] if self.zones else []),
            *([{"name": "led_cup", "value": self.cup, **tag}] if self.cup else []),
        ]

    def of(self, stack: StackValues) -> LedBoard:
        """Return the board with a stack's values."""
        return LedBoard(self, stack)


def _rows(table: NDArray[np.float64]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in table)


def _repeat(where: str, value: Any) -> tuple[int, int]:
    good = isinstance(value, list) and len(value) == 2
    if not good or not all(type(n) is int and 1 <= n <= _MOST_REPEAT for n in value):
        raise InputError(f"{where}.repeat: {value!r}: expected [across, along], 1 … {_MOST_REPEAT}")
    return value[0], value[1]


def _numbers(where: str, value: Any) -> tuple[int, ...]:
    if not isinstance(value, list) or not all(type(n) is int and n >= 1 for n in value):
        raise InputError(f"{where}.dead: {value!r}: expected a list of LEDs' numbers from 1")
    return tuple(value)


def _cup(where: str, value: Any) -> str:
    if value not in _CUPS:
        raise InputError(f"{where}.cup: {value}: expected {' or '.join(_CUPS[1:])}")
    return str(value)


def _seed(where: str, value: Any) -> int:
    if type(value) is not int or value < 0:
        raise InputError(f"{where}.seed: {value!r}: expected a whole number, 0 or more")
    return value
