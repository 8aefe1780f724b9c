"""A row of round fluorescent tubes along y over a reflector: numbers, places, flux, element."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from mpfcad.backlight.source.protocol import Emitters, Period, Range, StackValues
from mpfcad.errors import InputError

if TYPE_CHECKING:
    from mpfcad.optics.element import Cavity

#: Of one lamp of a finite panel, `lamp_3_shift_mm`; lamps count from 1 at the left.
LAMP_RANGES: dict[str, Range] = {"luminance_factor": (0.0, 100.0), "shift_mm": (-1000.0, 1000.0)}
_LAMP = re.compile(r"lamp_([1-9][0-9]*)_(" + "|".join(LAMP_RANGES) + ")")


@dataclass(frozen=True)
class TubeSpec:
    """Tubes: everything about them is a number."""

    kind: ClassVar[str] = "tubes"
    ranges: ClassVar[Mapping[str, Range]] = {
        "lamp_count": (1, 10_000),
        "lamp_pitch_mm": (0.1, 1000.0),
        "lamp_radius_mm": (0.01, 100.0),
        "lamp_height_mm": (0.01, 1000.0),
        "lamp_reflectance": (0.0, 1.0),
        "lamp_luminance_cd_m2": (1e-6, 1e9),
    }
    panel_ranges: ClassVar[Mapping[str, Range]] = {
        "lamp_length_mm": (1.0, 10_000.0),
        "rim_mm": (0.0, 1000.0),
    }
    optional: ClassVar[Mapping[str, tuple[Range, str | float]]] = {}
    defaults: ClassVar[Mapping[str, str]] = {"lamp_length_mm": "panel_length_mm"}

    @classmethod
    def read(cls, where: str, folder: Path, entry: Mapping[str, Any]) -> "TubeSpec":
        """Return the spec of a stack file's `[source]`.

        Raises
        ------
        InputError
            when it says more than the kind.
        """
        unknown = sorted(set(entry) - {"kind"})
        if unknown:
            raise InputError(f"{where}: source.{unknown[0]}: unknown key; expected kind alone")
        return cls()

    @classmethod
    def restore(cls, document: Mapping[str, Any]) -> "TubeSpec":
        """Return the spec that was described."""
        return cls()

    def find_range(self, key: str) -> Range | None:
        """Return the range of a value of one lamp."""
        match = _LAMP.fullmatch(key)
        return LAMP_RANGES[match[2]] if match else None

    def numbered(self, keys: Mapping[str, Any]) -> list[str]:
        """Return the names of values of one lamp, by the lamp's number."""
        found = [key for key in keys if _LAMP.fullmatch(key)]
        return sorted(found, key=lambda key: (_number(key), key))

    def patterns(self) -> list[str]:
        """Return how such names are made."""
        return [f"lamp_N_{name}" for name in LAMP_RANGES]

    def inputs(self) -> list[dict[str, Any]]:
        """Return nothing: all is a number."""
        return []

    def describe(self) -> dict[str, Any]:
        """Return nothing: it is the default."""
        return {}

    def of(self, stack: StackValues) -> "TubeRow":
        """Return the row of tubes with a stack's values."""
        return TubeRow(stack)


def _number(key: str) -> int | None:
    match = _LAMP.fullmatch(key)
    return int(match[1]) if match else None


@dataclass(frozen=True)
class TubeRow:
    """The tubes of a stack; the scene's x = 0 is the axis of the one left of the middle."""

    stack: StackValues
    word: ClassVar[str] = "lamp"

    @property
    def period(self) -> Period:
        """One lamp pitch; nothing changes along the tubes."""
        return Period(self.pitch, 0.0)

    @property
    def cell(self) -> Period:
        """One lamp pitch."""
        return self.period

    @property
    def origin(self) -> tuple[float, float]:
        """The central lamp's even place and the middle along it, on the panel [mm]."""
        return self.lamp_position(self.central_lamp), self.stack["panel_length_mm"] / 2

    @property
    def count(self) -> int:
        """Number of lamps."""
        return int(self.stack["lamp_count"])

    @property
    def pitch(self) -> float:
        """Spacing of the lamps [mm]."""
        return self.stack["lamp_pitch_mm"]

    @property
    def central_lamp(self) -> int:
        """The lamp left of the panel's middle, at x = 0 of the scene."""
        return max((self.count - 1) // 2, 0)

    @property
    def is_finite(self) -> bool:
        """Whether the panel has edges."""
        return self.stack.extent == "panel"

    def lamp_position(self, number: int) -> float:
        """Return the axis' even position [mm] on the panel of lamp `number`, from 0 at the left."""
        row = (self.count - 1) * self.pitch
        return (self.stack["panel_width_mm"] - row) / 2 + number * self.pitch

    def shifted_position(self, number: int) -> float:
        """Return the axis' position [mm] on the panel with the lamp's own shift."""
        return self.lamp_position(number) + self._of_lamp(number, "shift_mm", 0.0)

    def lamp_factor(self, number: int) -> float:
        """Return a lamp's luminance as a multiple of all lamps'."""
        return self._of_lamp(number, "luminance_factor", 1.0)

    def _of_lamp(self, number: int, value: str, default: float) -> float:
        quantity = self.stack.quantity.get(f"lamp_{number + 1}_{value}")
        return default if quantity is None else quantity.value

    @property
    def flux(self) -> float:
        """The flux that the panel's lamps emit, π L · 2π r · length, over all lamps [lm]."""
        tubes, length = float(self.count), self.stack["panel_length_mm"]
        if self.is_finite:
            tubes = sum(self.lamp_factor(number) for number in range(self.count))
            length = min(self.stack["lamp_length_mm"], length)
        surface = 2 * math.pi * self.stack["lamp_radius_mm"] * length * 1e-6
        return float(tubes * math.pi * self.stack["lamp_luminance_cd_m2"] * surface)

    @property
    def lit_size(self) -> Period:
        """What the lamps light [mm]: a pitch for each, or the finite panel."""
        width = self.stack["panel_width_mm"] if self.is_finite else self.count * self.pitch
        return Period(width, self.stack["panel_length_mm"])

    @property
    def lit_area(self) -> float:
        """The area [m²] that the lamps light."""
        width, length = self.lit_size
        return width * length * 1e-6

    def check(self, where: str) -> None:
        """Raise unless the lamps fit under the plate, beside each other and on the panel.

        Raises
        ------
        InputError
            naming the value and its limit.
        """
        stack = self.stack
        radius, height = stack["lamp_radius_mm"], stack["lamp_height_mm"]
        thickness, width = stack["thickness_mm"], stack["panel_width_mm"]
        if height < radius:
            raise InputError(
                f"{where}: lamp_height_mm: {height:g}: expected at least the radius {radius:g}"
            )
        if thickness <= height + radius:
            raise InputError(
                f"{where}: thickness_mm: {thickness:g}: expected above the lamps' tops at "
                f"{height + radius:g} mm"
            )
        if self.pitch <= 2 * radius:
            raise InputError(
                f"{where}: lamp_pitch_mm: {self.pitch:g}: expected above the lamps' diameter "
                f"{2 * radius:g}"
            )
        if self.lamp_position(0) < 0:
            raise InputError(
                f"{where}: lamp_count: {self.count}: at pitch {self.pitch:g} mm the row is "
                f"wider than the panel's {width:g} mm"
            )
        self._check_lamps(where)

    def _check_lamps(self, where: str) -> None:
        """Raise unless single lamps exist, stay on the panel and apart from each other."""
        for key, quantity in self.stack.quantity.items():
            number = _number(key)
            if number is None:
                continue
            if not self.is_finite:
                raise InputError(
                    f"{where}: {key}: {quantity.value:g}: lamps differ on a whole panel only: "
                    'expected extent = "panel"'
                )
            if number > self.count:
                raise InputError(f"{where}: {key}: lamp {number}: expected at most {self.count}")
        if not self.is_finite:
            return
        radius, width = self.stack["lamp_radius_mm"], self.stack["panel_width_mm"]
        position = sorted(self.shifted_position(i) for i in range(self.count))
        edges = (position[0] >= radius, position[-1] <= width - radius)
        gaps = [b - a for a, b in pairwise(position)]
        if not all(edges) or any(gap <= 2 * radius for gap in gaps):
            raise InputError(
                f"{where}: lamp_N_shift_mm: lamps at {', '.join(f'{p:g}' for p in position)} mm: "
                f"expected {2 * radius:g} mm apart and within the panel's {width:g} mm"
            )
        if not any(self.lamp_factor(i) for i in range(self.count)):
            raise InputError(
                f"{where}: lamp_N_luminance_factor: all 0: expected a lamp that shines"
            )

    def lower(self, tables: Mapping[str, Any]) -> "Cavity":
        """Return the cavity with its lamps."""
        from mpfcad.optics.element import Cavity

        stack, table = self.stack, tables.get("reflector")
        return Cavity(
            height=stack["thickness_mm"],
            lamp_pitch=self.pitch,
            lamp_position=0.0,
            lamp_height=stack["lamp_height_mm"],
            lamp_radius=stack["lamp_radius_mm"],
            lamp_luminance=stack["lamp_luminance_cd_m2"],
            lamp_reflectance=stack["lamp_reflectance"],
            reflectance=stack["reflector_reflectance"],
            specular_fraction=stack["reflector_specular_fraction"],
            name="reflector",
            panel=self._panel() if self.is_finite else None,
            brdf=table.table if table else None,
            blend=table.blend if table else 1.0,
        )

    def _panel(self) -> Any:
        """Return the panel with the central lamp's place at x = 0 and the middle at y = 0."""
        from mpfcad.optics.cavity.finite import Panel

        stack = self.stack
        left, half = -self.origin[0], stack["panel_length_mm"] / 2
        lamps = range(self.count)
        return Panel(
            left,
            left + stack["panel_width_mm"],
            -half,
            half,
            tuple(left + self.shifted_position(i) for i in lamps),
            tuple(self.lamp_factor(i) for i in lamps),
            stack["lamp_length_mm"],
            stack["wall_reflectance"],
            stack["wall_specular_fraction"],
        )

    def emitters(self) -> Emitters:
        """Return how the lamps are drawn."""
        stack = self.stack
        diameter, height = 2 * stack["lamp_radius_mm"], stack["lamp_height_mm"]
        note = (
            f"{self.count}, radius {stack['lamp_radius_mm']:g} mm, axis {height:g} mm up, "
            f"{stack['lamp_luminance_cd_m2']:g} cd/m²"
        )
        return Emitters("lamps", note, diameter, diameter, height, True, self.pitch)
