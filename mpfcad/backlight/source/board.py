"""The LEDs of a stack: places, checks, flux and the element that is traced."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.cup import check_cups, lower_cup
from mpfcad.backlight.source.emission import batwing, cosine
from mpfcad.backlight.source.lattice import LATTICES, binned, is_mirrored, overlap, repeated
from mpfcad.backlight.source.protocol import Emitters, Period, StackValues
from mpfcad.backlight.source.zone import Zones, ZoneSpec, lay_zones
from mpfcad.errors import InputError

if TYPE_CHECKING:
    from mpfcad.optics.cavity.board import Board

#: How far a panel may be from a whole number of cells and still be called closed.
_CLOSED = 0.05


class LedChoice(Protocol):
    """What a board needs of `LedSpec`, where each is said what it is."""

    @property
    def lattice(self) -> str:
        """Key of `LATTICES`."""

    @property
    def emission(self) -> str:
        """Formula or file."""

    @property
    def listed(self) -> tuple[tuple[float, ...], ...]:
        """LEDs of a list."""

    @property
    def intensity(self) -> tuple[tuple[float, ...], ...]:
        """Table of a file."""

    @property
    def repeat(self) -> tuple[int, int]:
        """Cells traced together."""

    @property
    def dead(self) -> tuple[int, ...]:
        """LEDs that do not shine."""

    @property
    def seed(self) -> int:
        """Of the draws."""

    @property
    def zones(self) -> ZoneSpec | None:
        """Zones, if any."""

    @property
    def cup(self) -> str:
        """Shape of the cups, if any."""


@dataclass(frozen=True)
class LedBoard:
    """LEDs that repeat without end along x and y; the scene's x = y = 0 is one of a lattice."""

    spec: LedChoice
    stack: StackValues
    word: ClassVar[str] = "LED"

    @property
    def cell(self) -> Period:
        """Size [mm] of the lattice's own cell."""
        across, along = LATTICES[self.spec.lattice][1]
        pitch = self.stack["led_pitch_across_mm"], self.stack["led_pitch_along_mm"]
        if self.spec.lattice == "hexagonal":
            return Period(across * pitch[0], along * pitch[0])
        return Period(across * pitch[0], along * pitch[1])

    @property
    def period(self) -> Period:
        """What is traced and repeats."""
        (width, length), (n, m) = self.cell, self.spec.repeat
        return Period(n * width, m * length)

    @property
    def size(self) -> tuple[float, float]:
        """Emitting top [mm] along x and y."""
        return self.stack["led_width_mm"], self.stack["led_length_mm"]

    @property
    def cells(self) -> tuple[int, int]:
        """Whole cells of the lattice that the panel holds across and along; one at least."""
        width, length = self.cell
        across, along = self.stack["panel_width_mm"] / width, self.stack["panel_length_mm"] / length
        return max(1, int(across + _CLOSED)), max(1, int(along + _CLOSED))

    @property
    def origin(self) -> tuple[float, float]:
        """The place on the panel [mm] of the cell's x = y = 0, left of and below the middle."""
        panel = self.stack["panel_width_mm"], self.stack["panel_length_mm"]
        own = [
            ((n - 1) // 2 - (n - 1) / 2) * size
            for n, size in zip(self.cells, self.cell, strict=True)
        ]
        return panel[0] / 2 + own[0], panel[1] / 2 + own[1]

    @property
    def placed(self) -> NDArray[np.float64]:
        """The traced LEDs, (l, 3) float64: x, y [mm], flux as a multiple, as the board has them."""
        return binned(
            self._even, self.stack["led_flux_spread"], self.stack["led_position_error_mm"],
            self.spec.dead, self.spec.seed,
        )  # fmt: skip

    @property
    def _even(self) -> NDArray[np.float64]:
        """The traced LEDs where they should be."""
        if self.spec.lattice == "list":
            led = np.array(self.spec.listed)
        else:
            pitch = self.stack["led_pitch_across_mm"], self.stack["led_pitch_along_mm"]
            if self.spec.lattice == "hexagonal":
                pitch = pitch[0], pitch[0]
            places = LATTICES[self.spec.lattice][0]
            led = np.array([(x * pitch[0], y * pitch[1], 1.0) for x, y in places])
        return repeated(led, self.cell, self.spec.repeat)

    @property
    def is_mirrored(self) -> bool:
        """Whether the LEDs are the same when mirrored at x = 0 and at y = 0."""
        return is_mirrored(self.placed, self.period)

    @property
    def count(self) -> int:
        """LEDs on the panel."""
        across, along = self.cells
        return across * along * (len(self._even) // (self.spec.repeat[0] * self.spec.repeat[1]))

    @property
    def flux(self) -> float:
        """Flux [lm] of the LEDs on the panel."""
        return float(self.count * self.stack["led_flux_lm"] * self.placed[:, 2].mean())

    @property
    def lit_size(self) -> Period:
        """Size [mm] of the panel's whole cells."""
        (width, length), (across, along) = self.cell, self.cells
        return Period(across * width, along * length)

    @property
    def lit_area(self) -> float:
        """Area [m²] of the panel's whole cells."""
        (width, length), (across, along) = self.cell, self.cells
        return across * width * along * length * 1e-6

    def check(self, where: str) -> None:
        """Raise unless the LEDs fit under the stack and beside each other.

        Raises
        ------
        InputError
            naming the value and what is expected.
        """
        stack = self.stack
        if stack.extent != "pitch":
            raise InputError(
                f"{where}: extent: {stack.extent}: LEDs are a cell that repeats: expected pitch"
            )
        height, thickness = stack["led_height_mm"], stack["thickness_mm"]
        if height >= thickness:
            raise InputError(
                f"{where}: thickness_mm: {thickness:g}: expected above the LEDs' tops at {height:g}"
            )
        wrong = [number for number in self.spec.dead if number > len(self._even)]
        if wrong:
            raise InputError(
                f"{where}: source.dead: LED {wrong[0]}: expected at most {len(self._even)}"
            )
        if not self.placed[:, 2].any():
            raise InputError(f"{where}: source.dead: all LEDs: expected one that shines")
        self._lay_zones(where)
        check_cups(where, stack, self.spec.cup, self.placed, self.period, self.size)
        both = overlap(self.placed, self.period, self.size)
        if both:
            raise InputError(f"{where}: {self._overlap_words(*both)}")

    @property
    def zones(self) -> Zones | None:
        """The zones that are dimmed by themselves; None of a board without."""
        return self._lay_zones("source.zones")

    def _lay_zones(self, where: str) -> Zones | None:
        spec = self.spec.zones
        if spec is None:
            return None
        if self.spec.repeat != (1, 1):
            raise InputError(
                f"{where}: source.zones: with repeat = {list(self.spec.repeat)}: expected [1, 1]"
            )
        (width, length), (across, along) = self.cell, self.cells
        first = [-((n - 1) // 2) for n in (across, along)]
        x = self.origin[0] + (first[0] + np.arange(across)) * width
        y = self.origin[1] + (first[1] + np.arange(along)) * length
        place = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        led = self._even[:, None, None, :2] + place
        panel = self.stack["panel_width_mm"], self.stack["panel_length_mm"]
        return lay_zones(f"{where}: source.zones", spec, led, panel, self.lit_size)

    def _overlap_words(self, first: int, second: int) -> str:
        """Return which LEDs overlap, by what, and what was expected."""
        size = f"{self.size[0]:g} × {self.size[1]:g} mm"
        if first == second:
            return (
                f"LEDs of {size} overlap their own repetition in a cell of "
                f"{self.period.across:g} × {self.period.along:g} mm: expected a larger cell"
            )
        period = (self.period.across, self.period.along)
        away = self.placed[second - 1, :2] - self.placed[first - 1, :2]
        x, y = np.abs(away - np.round(away / period) * period)
        return (
            f"LEDs {first} and {second} overlap, {x:.4g} mm apart across and {y:.4g} mm along: "
            f"expected {size} or more"
        )

    def lower(self, tables: Mapping[str, Any]) -> "Board":
        """Return the board."""
        from mpfcad.optics.cavity.board import Board
        from mpfcad.optics.cavity.emission import Emission

        stack, table, led = self.stack, tables.get("reflector"), self.placed
        return Board(
            height=stack["thickness_mm"],
            period=(self.period.across, self.period.along),
            position=led[:, :2],
            factor=led[:, 2],
            led_size=self.size,
            led_height=stack["led_height_mm"],
            led_flux=stack["led_flux_lm"],
            led_reflectance=stack["led_reflectance"],
            emission=Emission(self._intensity()),
            reflectance=stack["reflector_reflectance"],
            specular_fraction=stack["reflector_specular_fraction"],
            hole_radius=stack["led_hole_radius_mm"],
            hole_reflectance=stack["led_hole_reflectance"],
            cup=lower_cup(stack, self.spec.cup),
            brdf=table.table if table else None,
            blend=table.blend if table else 1.0,
        )

    def _intensity(self) -> NDArray[np.float64]:
        if self.spec.emission == "cosine":
            return cosine(self.stack["led_half_angle_deg"])
        if self.spec.emission == "batwing":
            return batwing(self.stack["led_peak_angle_deg"])
        return np.array(self.spec.intensity)

    @property
    def edge(self) -> str:
        """Words for what is left where the lattice does not close on the panel; else empty."""
        panel = self.stack["panel_width_mm"], self.stack["panel_length_mm"]
        left = [p - n * c for p, n, c in zip(panel, self.cells, self.cell, strict=True)]
        if all(abs(rest) <= _CLOSED * c for rest, c in zip(left, self.cell, strict=True)):
            return ""
        return (
            f"the panel holds {self.cells[0]} × {self.cells[1]} whole cells; "
            f"{left[0]:.3g} and {left[1]:.3g} mm are left and count as edge"
        )

    def emitters(self) -> Emitters:
        """Return how the LEDs are drawn."""
        stack, (width, _) = self.stack, self.size
        height = stack["led_height_mm"]
        note = (
            f"{self.count} {self.spec.lattice}, pitch {stack['led_pitch_across_mm']:g} × "
            f"{stack['led_pitch_along_mm']:g} mm, {self.spec.emission}, "
            f"{stack['led_flux_lm']:g} lm each"
        )
        if self.spec.cup:
            note += f"; in {self.spec.cup} cups {stack['led_cup_height_mm']:g} mm high"
        note += f"; {self.edge}" if self.edge else ""
        return Emitters(
            "LEDs", note, width, height, height / 2, False, stack["led_pitch_across_mm"]
        )
