"""A plan under LEDs with some inputs changed by steps of their standard uncertainty."""

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mpfcad.backlight import Stack
from mpfcad.backlight.source import LedSpec
from mpfcad.confidence import STEP, Factor
from mpfcad.errors import InputError
from mpfcad.measure import Lit, light_film
from mpfcad.pipeline.confidence.cell_resin import CellResin
from mpfcad.pipeline.confidence.variant import BASE, DEPTH, RESIN, TONE, Variants
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import SILENT

if TYPE_CHECKING:
    from mpfcad.backlight.lower import Mesh
    from mpfcad.film import CellLibrary, PieceLibrary


class Move(NamedTuple):
    """How a print moves against the LEDs along an axis of the panel.

    Attributes
    ----------
    film
        0: in the job's place, 1: the film across
    axis
        of the panel, 0: x
    along
        axis of the film's own places
    sign
        by which these count against the panel's axis
    """

    film: int
    axis: int
    along: int
    sign: int


#: The film across is turned by 90°: its x is the panel's y, its y goes against the panel's x.
MOVES = {
    "registration_x_mm": Move(0, 0, 0, 1),
    "registration_y_mm": Move(0, 1, 1, 1),
    "crossed_registration_x_mm": Move(1, 0, 1, -1),
    "crossed_registration_y_mm": Move(1, 1, 0, 1),
}
#: Inputs of films under LEDs that are in no stack.
CELL_INPUTS = (RESIN, TONE, *MOVES)
_HOLE, _HOLE_RADIUS = "led_hole_reflectance", "led_hole_radius_mm"
_PLACE = "place of the film against the LEDs"
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class CellVariants(Variants):
    """The scenes of a plan's films over LEDs with the inputs changed; files are read once.

    A print is moved by whole pieces of its film: the same file, its places counted from another.
    """

    @property
    def _job(self) -> Plan:
        assert isinstance(self.plan, Plan)  # `cell_variants_of` makes it of one
        return self.plan

    @cached_property
    def resin(self) -> CellResin | None:
        """What is not known of the resin; None of films that are no pieces."""
        found = [kind_of(film.drawn, film.job.cad).pieces for film in self._job.films]
        films = [film for film in found if film is not None]
        return CellResin(self._job, films) if len(films) == len(found) else None

    def print_factors(self) -> list[Factor]:
        """Return what the process itself does not know of the print; empty where it states none."""
        return [] if self.resin is None else self.resin.printed()

    def left_out(self) -> list[str]:
        """Return the inputs that are not carried, with the reason."""
        said = dict.fromkeys((DEPTH, BASE), "of films under LEDs none with other prisms is made")
        said |= dict.fromkeys(self._tight, "changed so far, it would meet what is next to it")
        spec = self.stack.spec
        if isinstance(spec, LedSpec) and spec.intensity:
            said["led_emission"] = f"{spec.emission}: taken as exact"
        for name in ("led_flux_spread", "led_position_error_mm"):
            if self.stack[name] > 0:
                said[name] = "traced as source.seed draws it, and no other draw"
        return [f"{name}: {why}" for name, why in said.items()]

    def _of_stack(self) -> list[Factor]:
        return [factor for factor in self._that_act if factor.name not in self._tight]

    @cached_property
    def _that_act(self) -> list[Factor]:
        """The stack's numbers that change the scene; of a hole that is not there, none."""
        lacks = {_HOLE} if self.stack[_HOLE_RADIUS] == 0 else set()
        return [factor for factor in super()._of_stack() if factor.name not in lacks]

    @cached_property
    def _tight(self) -> list[str]:
        """Lengths that the runs cannot change with the others: the LEDs or cups would not fit."""
        tight: list[str] = []
        free: list[Factor] = []
        for factor in self._that_act:
            if factor.name.endswith("_mm"):
                if self._fits([*free, factor]):
                    free.append(factor)
                else:
                    tight.append(factor.name)
        return tight

    def _fits(self, factors: list[Factor]) -> bool:
        """Return whether LEDs and cups fit with lengths at all of both ends of their runs."""
        try:
            for signs in product((-STEP, STEP), repeat=len(factors)):
                ends = zip(factors, signs, strict=True)
                change = {f.name: float(f.within(np.array(z))) * f.sigma for f, z in ends}
                self._stack(change).source.check("")
        except InputError:
            return False
        return True

    def _of_film(self) -> list[Factor]:
        resin = [] if self.resin is None else self.resin.factors(self.table.resin_or_assumed)
        return [*resin, *self._of_place()]

    def _of_place(self) -> list[Factor]:
        """Return how far each print may lie beside the LEDs, where it would be seen."""
        size, films = self.table.registration_mm, self._job.films
        return [
            Factor(name, 0.0, size, source=_PLACE, is_curved=True)
            for name, move in MOVES.items()
            if size > 0 and move.film < len(films) and self._varies(move)
        ]

    def _varies(self, move: Move) -> bool:
        pieces = self._pieces(move.film)
        return float(np.ptp(pieces.wanted, axis=move.along).max()) > _FLAT

    def _pieces(self, film: int) -> "PieceLibrary | CellLibrary":
        assert self.resin is not None  # the confidence takes films of pieces
        return self.resin.films[film]

    def _piece(self, move: Move) -> float:
        """Return the size [mm] of a piece along a move."""
        pieces = self._pieces(move.film)
        return pieces.size[move.along] / pieces.chosen.shape[move.along]

    def reach(self, factor: Factor) -> float:
        """Return how far a curved input is changed, in units of its sigma: by whole pieces."""
        if factor.name not in MOVES:
            return STEP
        piece = self._piece(MOVES[factor.name])
        return max(1, round(STEP * factor.sigma / piece)) * piece / factor.sigma

    def _lowered(self, stack: Stack) -> list[object]:
        from mpfcad.backlight.lower import lower_stack
        from mpfcad.optics.scene import build_scene
        from mpfcad.store import array_hash

        elements = lower_stack(stack, self._mesh, self.plan.offset, self._read)
        return [array_hash(build_scene(elements, polarised=stack.polarised))]

    def _read(self, path: Path) -> "Mesh":
        """Return what is in a film's file, read once."""
        from mpfcad.backlight.lower import read_film

        if path not in self._meshes:
            self._meshes[path] = read_film(path)
        return self._meshes[path]

    @cached_property
    def _meshes(self) -> "dict[Path, Mesh]":
        return {}

    @cached_property
    def _mesh(self) -> "Mesh | None":
        return None if self._shipped is None else self._read(self._shipped)

    def light(self, steps: Mapping[Factor, float]) -> Lit:
        """Return the scene with inputs changed by steps of their sigma; prints by whole pieces."""
        change = {f.name: float(f.within(np.array(z))) * f.sigma for f, z in steps.items()}
        film = {name: change.pop(name) for name in CELL_INPUTS if name in change}
        resin = {name: film[name] for name in (RESIN, TONE) if film.get(name)}
        files = self._printed(tuple(sorted(resin.items())))
        moved = {path: self._moved(path, i, film) for i, path in enumerate(files)}
        return light_film(
            self._with_files(self._stack(change), files), files[0], self.plan.offset,
            moved[files[0]], lambda path: moved.get(path) or self._read(path),
        )  # fmt: skip

    def _with_files(self, stack: Stack, files: tuple[Path, ...]) -> Stack:
        """Return a stack with the film across of these files, in the place of the shipped one."""
        shipped = dict(zip(map(str, self._written[()]), map(str, files), strict=True))
        own = {
            name: replace(layer, file=shipped.get(layer.file, layer.file)) if layer.file else layer
            for name, layer in stack.own.items()
        }
        return replace(stack, own=own)

    def _moved(self, path: Path, number: int, change: Mapping[str, float]) -> "Mesh":
        """Return a film whose print is moved against the LEDs."""
        from mpfcad.optics.library.piece import Library
        from mpfcad.optics.library.top import CellTops

        mesh = self._read(path)
        by = [0, 0]
        for name, move in MOVES.items():
            if move.film == number and change.get(name):
                by[move.along] += move.sign * round(change[name] / self._piece(move))
        if by == [0, 0]:
            return mesh
        assert isinstance(mesh, Library | CellTops)  # a film of pieces reads back as one
        return replace(mesh, chosen=np.roll(mesh.chosen, by, (0, 1)))

    def _printed(self, resin: tuple[tuple[str, float], ...]) -> tuple[Path, ...]:
        """Return the files of the films as shipped, or written with other resin."""
        from mpfcad.pipeline.run.make import write_cad

        files = self._written
        if resin not in files:
            assert self.resin is not None  # of other films no resin is changed
            changed = [self.resin.changed(film, dict(resin)) for film in self.resin.films]
            films = [replace(one, drawn=film)
                     for one, film in zip(self._job.films, changed, strict=True)]  # fmt: skip
            folder = self.folder / f"changed-{len(files)}"
            folder.mkdir()
            plan = replace(films[0], crossed=films[1] if len(films) > 1 else None)
            write_cad(plan, folder, ("3mf",), SILENT)
            files[resin] = tuple(folder / one.file("film", "3mf") for one in films)
        return files[resin]

    @cached_property
    def _written(self) -> dict[tuple[tuple[str, float], ...], tuple[Path, ...]]:
        assert self._shipped is not None  # a plan has a film
        folder = self._shipped.parent
        return {(): tuple(folder / one.file("film", "3mf") for one in self._job.films)}


@contextmanager
def cell_variants_of(plan: Plan, folder: Path) -> Iterator[CellVariants]:
    """Give the scenes of a plan under LEDs with its inputs changed; `folder` holds its files."""
    folder = folder.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        yield CellVariants(
            plan, plan.lit_stack(folder), Path(temporary), plan.job.confidence_table,
            folder / plan.file("film", "3mf"),
        )  # fmt: skip
