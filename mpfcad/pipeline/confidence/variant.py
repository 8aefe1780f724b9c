"""A job's scene with some inputs changed by steps of their standard uncertainty."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.backlight.width import limits_of, width_of
from mpfcad.confidence import STEP, Factor
from mpfcad.errors import InputError
from mpfcad.film import PrismFilm
from mpfcad.job import ConfidenceTable
from mpfcad.measure import Lit, light_film
from mpfcad.pipeline.confidence.subject import Subject

if TYPE_CHECKING:
    from mpfcad.backlight.lower import Mesh
    from mpfcad.optics.score.columns import Columns

#: Inputs of the film as made and laid, by their names in `[confidence]`; in no stack.
RESIN, SHIFT, DEPTH, BASE = "resin_percent", "registration_mm", "depth_um", "base_um"
#: How resin in large apertures goes against that in small ones, where the process knows it.
TONE = "resin_tone_percent"
_REASON = {
    RESIN: "resin in all grooves, assumed: the process does not state its width",
    TONE: "",
    SHIFT: "place of the film against the lamps",
    DEPTH: "depth of the prisms, at equal fill",
    BASE: "thickness below the prisms",
}
#: Inputs of film and print that are in no stack.
FILM_INPUTS = tuple(_REASON)
#: A step for a derivative, in units of sigma.
_SMALL = 1e-3
#: Changed films that are kept: those of a factorial with resin, depth and base, twice.
_FILMS = 16
#: Fill up to where a groove is as good as full.
FULL = 0.999


@dataclass(frozen=True, eq=False)
class Variants:
    """The scenes of a film in its backlight with the inputs changed.

    Attributes
    ----------
    plan, stack
        the film, that of a job or any; its backlight with the meshes that it needs in place
    folder
        where changed films are written
    table
        the widths of film and print
    mesh
        the film as shipped, a file of the folder or anywhere; None: the stack has no film
    """

    plan: Subject
    stack: Stack
    folder: Path
    table: ConfidenceTable
    mesh: Path | None = Path("film.stl")

    @property
    def has_grooves(self) -> bool:
        """Whether resin, depth and base can be changed: grooves as designed, filled, clear."""
        piece = self.plan.piece
        if piece is None or self.plan.drawn is not piece:
            return False
        return piece.profile == "filled" and not self.stack.needs_prism

    def factors(self) -> list[Factor]:
        """Return the inputs that are not known exactly and change the scene."""
        found = [*self._of_stack(), *self._of_film()]
        stated = self.table.sigmas()
        known = {factor.name for factor in found} | self._unused()
        unknown = sorted(set(stated) - known)
        if unknown:
            raise InputError(
                f"confidence.covariance: {unknown[0]}: expected inputs of this job that are not "
                f"exact: {', '.join(factor.name for factor in found)}"
            )
        return [
            replace(f, sigma=stated[f.name], source="covariance") if f.name in stated else f
            for f in found
        ]

    def _unused(self) -> set[str]:
        """Return the numbers with a width that this stack has: a fit's covariance names them all.

        Those that do not change the scene are in no other sense inputs.
        """
        return {name for name in self.stack.quantity if width_of(self.stack, name).sigma > 0}

    def left_out(self) -> list[str]:
        """Return the inputs that are not carried, with the reason."""
        if self.has_grooves or self.mesh is None:
            return []
        why = "of this kind of film no changed one is made"
        if self.plan.piece is None:
            why = "a mesh does not say how it is made"
        return [f"{name}: {why}" for name in (RESIN, DEPTH, BASE)]

    def _of_stack(self) -> list[Factor]:
        found = []
        scene = self._lowered(self.stack)
        for name, quantity in self.stack.quantity.items():
            width = width_of(self.stack, name)
            if width.sigma == 0:
                continue
            factor = Factor(
                name, quantity.value, width.sigma, *limits_of(self.stack, name), width.source
            )
            # A number that this stack does not use leaves the scene as it is.
            if self._lowered(self._stack({name: -STEP * width.sigma})) != scene:
                found.append(factor)
        return found

    @property
    def _shipped(self) -> Path | None:
        return None if self.mesh is None else self.folder / self.mesh

    @cached_property
    def _mesh(self) -> "Mesh | None":
        from mpfcad.backlight.lower import read_film

        return None if self._shipped is None else read_film(self._shipped)

    def direction(self, factor: Factor, columns: "Columns") -> NDArray[np.float64] | None:
        """Return how one sigma of an input moves a scene's scored values, (k,) float64.

        None of what is no number of the stack, or changes more than these: geometry, an index.
        """
        from mpfcad.backlight.lower import lower_stack
        from mpfcad.optics.score.columns import direction

        if factor.name not in self.stack.quantity:
            return None
        # One-sided at the ends of what it can be.
        low, high = (float(factor.within(np.array(z))) for z in (-_SMALL, _SMALL))
        less, more = (
            lower_stack(self._stack({factor.name: z * factor.sigma}), self._mesh, self.plan.offset)
            for z in (low, high)
        )
        return direction(columns, less, more, high - low)

    def _lowered(self, stack: Stack) -> list[object]:
        """Return what the tracer would read of a stack's elements, to be compared."""
        from mpfcad.backlight.lower import lower_stack

        found: list[object] = []
        for element in lower_stack(stack, self._mesh, self.plan.offset):
            for name, value in vars(element).items():
                plain = isinstance(value, int | float | str | tuple)
                found.append((name, value if plain else _content(value)))
        return found

    def _stack(self, change: Mapping[str, float]) -> Stack:
        """Return the stack with numbers changed by so much."""
        quantity = self.stack.quantity
        values = {
            name: replace(quantity[name], value=quantity[name].value + by)
            for name, by in change.items()
        }
        return self.stack.with_values(values) if values else self.stack

    def _of_film(self) -> list[Factor]:
        piece = self.plan.piece
        if self.mesh is None:
            return []
        sizes = {SHIFT: self.table.registration_mm}
        low = {RESIN: -100.0 if self._modes is None else -np.inf}
        if piece is not None and self.has_grooves:
            sizes |= {DEPTH: self.table.depth_um, BASE: self.table.base_um}
            sizes |= self._of_print()
            low |= {BASE: -piece.base * 1000 * 0.9, DEPTH: -piece.groove.depth * 1000 * 0.9}
        if piece is not None and np.ptp(piece.curvature) == 0:
            # Alike grooves are nowhere wrong.
            del sizes[SHIFT]
        return [
            Factor(
                name, 0.0, size, low.get(name, -np.inf), source=self._reason(name),
                is_curved=name in (RESIN, TONE),
            )
            for name, size in sizes.items()
            if size > 0
        ]  # fmt: skip

    @cached_property
    def _modes(self) -> NDArray[np.float64] | None:
        """What the process does not know of ln(fill) of the piece's grooves, (k, n)."""
        process, piece = self.plan.process, self.plan.piece
        if process is None or piece is None:
            return None
        modes = process.fill_modes(process.aperture_ratio_of_curvature(piece.curvature))
        return None if modes is None else modes[:2]

    def print_factors(self) -> list[Factor]:
        """Return what the process itself does not know of the print; empty where it states none."""
        if not self.has_grooves or self._modes is None:
            return []
        return [factor for factor in self._of_film() if factor.name in (RESIN, TONE)]

    def _of_print(self) -> dict[str, float]:
        """Return the widths of the resin [%]: the process's, else `[confidence]`'s."""
        piece = self.plan.piece
        if piece is None or float(np.max(piece.fill_fraction)) <= 0:
            return {}
        if self._modes is None:
            return {RESIN: self.table.resin_or_assumed}
        size = 100 * np.sqrt(np.mean(self._modes**2, axis=1))
        return dict(zip((RESIN, TONE), size.tolist(), strict=False))

    def _reason(self, name: str) -> str:
        if name not in (RESIN, TONE) or self._modes is None or self.plan.process is None:
            return _REASON[name]
        of = "all grooves" if name == RESIN else "large apertures against small ones"
        return f"resin in {of}, by the process: {self.plan.process.source}"

    def light(self, steps: Mapping[Factor, float]) -> Lit:
        """Return the scene with inputs changed by steps of their sigma."""
        change = {f.name: float(f.within(np.array(z))) * f.sigma for f, z in steps.items()}
        film = {name: change.pop(name) for name in _REASON if name in change}
        shift = film.pop(SHIFT, 0.0)
        path, mesh = self._made(film)
        return light_film(self._stack(change), path, self.plan.offset + shift, mesh)

    def _made(self, change: Mapping[str, float]) -> tuple[Path | None, "Mesh | None"]:
        """Return the file of a film with its making changed, and what was read of it.

        Runs of a factorial share few films: the latest are kept.
        """
        from mpfcad.backlight.lower import read_film

        films, key = self._films, tuple(sorted(change.items()))
        if key not in films:
            if len(films) == _FILMS:
                path, _ = films.pop(next(iter(films)))
                if path is not None and path != self._shipped:
                    path.unlink()
            path = self._film(change)
            films[key] = path, (None if path is None else read_film(path))
        return films[key]

    @cached_property
    def _films(self) -> dict[tuple[tuple[str, float], ...], tuple[Path | None, "Mesh | None"]]:
        return {}

    def changed_file(self) -> Path:
        """Return where the next changed film is written."""
        number = next(self._numbers)
        return self.folder / f"changed-{number}.stl"

    @cached_property
    def _numbers(self) -> Iterator[int]:
        return count()

    def _film(self, change: Mapping[str, float]) -> Path | None:
        """Return the mesh of the film as shipped, or of one written with its making changed."""
        if not {RESIN, TONE, DEPTH, BASE} & set(change):
            return self._shipped
        from mpfcad.cad import write_stl

        path = self.changed_file()
        write_stl(self._changed(change), path, self.plan.angle_tolerance)
        return path

    def _changed(self, change: Mapping[str, float]) -> PrismFilm:
        piece = self.plan.piece
        assert piece is not None  # making is only changed where it is known
        groove = replace(piece.groove, depth=piece.groove.depth + change.get(DEPTH, 0.0) / 1000)
        fill = piece.fill_fraction * self.resin_factor(change)
        curvature = groove.curvature_of_fill(np.clip(fill, 0, FULL))
        base = piece.base + change.get(BASE, 0.0) / 1000
        return replace(piece, groove=groove, base=base, curvature=curvature)

    def resin_factor(self, change: Mapping[str, float]) -> NDArray[np.float64]:
        """Return the factor of each groove's resin, (n,), or that of all of them, (1,)."""
        modes = self._modes
        if modes is None:
            return np.array([1 + change.get(RESIN, 0.0) / 100])
        found = np.zeros(modes.shape[1])
        for name, mode in zip((RESIN, TONE), modes, strict=False):
            found += mode * change.get(name, 0.0) / (100 * np.sqrt(np.mean(mode**2)))
        return np.exp(found)


def _content(value: object) -> object:
    """Return an array's bytes; what else is no plain value is itself or another."""
    return value.tobytes() if isinstance(value, np.ndarray) else id(value)
