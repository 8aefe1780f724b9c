"""A map over a cell of LEDs laid onto the panel: the film as printed, and as a library."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.boundary.npz import read_arrays
from mpfcad.errors import ExportError, InputError
from mpfcad.film import (
    ALONG_ARRAY,
    CellLibrary,
    FieldFilm,
    Halftone,
    HalftoneField,
    PieceLibrary,
    RepeatedField,
    build_cell_library,
    build_library,
    has_along,
)
from mpfcad.job import Job
from mpfcad.pipeline.plan.cell import (
    LEVELS,
    CellFrame,
    piece_length,
    read_along_map,
    read_cell_maps,
)
from mpfcad.pipeline.plan.departure import AS_DESIGNED, AS_MAPPED, Departure, PrintError
from mpfcad.pipeline.plan.field import field_section
from mpfcad.pipeline.plan.halftone import clipped_tone, halftone_of, levelled_library
from mpfcad.pipeline.plan.panel_map import Laid
from mpfcad.pipeline.plan.size import groove_count

#: Names in the export of the maps of the first film and of that across.
CELL_FILES = ("curvature.npz", "curvature-crossed.npz")


@dataclass(frozen=True, eq=False)
class CellFilmMap:
    """C over one cell, repeated over the panel.

    Attributes
    ----------
    wanted
        (n, m) float64 [1/mm], C of each groove of the cell at the middle of each piece
    frame
        where the cells lie on the panel, by the film's axes
    crossed
        the map of the film that lies across
    along
        (n, m) float64 [1/mm], C along y of cells that have two
    halftone
        the pieces that `wanted` is printed with, where it is a halftone
    error
        how the print of those departs from the job
    turned
        whether the film lies across
    """

    is_grooves: ClassVar[bool] = False
    wanted: NDArray[np.float64]
    frame: CellFrame
    crossed: "CellFilmMap | None" = None
    along: NDArray[np.float64] | None = None
    halftone: Halftone | None = None
    error: PrintError = AS_MAPPED
    turned: bool = False

    @property
    def curvature(self) -> NDArray[np.float64]:
        """Every curvature [1/mm] that a screen has to print, of both films."""
        own = np.ravel(self.wanted if self.halftone is None else self.halftone.two_level)
        return own if self.crossed is None else np.concatenate([own, self.crossed.curvature])

    def lay(self, job: Job, stack: Stack, measured: NDArray[np.float64] | None, where: str) -> Laid:
        """Return the printed film over the panel, and its library over what is traced at an LED.

        Raises
        ------
        InputError
            that begins with `where`, for a panel that holds no whole cell.
        """
        groove, (width, length) = job.film.groove, self.frame.panel
        count = groove_count(width, groove.pitch)
        n = len(self.wanted)
        first = round(self.frame.origin[0] / groove.pitch)
        while first + n > count:
            first -= n
        if first < 0:
            raise InputError(
                f"{where}: stack: {stack.name}: a cell of {self.frame.size[0]:g} mm on a panel of "
                f"{width:g} mm: expected a panel that holds two cells"
            )
        library = self.library(job, where)
        field = self._field(job, first, count)
        film = FieldFilm(groove, length, count, field, job.film.profile)
        panel = field_section(film, self.frame.origin[1], job.film.base)
        piece = panel.cut(first, n, self.frame.size[1])
        return Laid(panel, piece, library, first, film, None, self.along)

    @property
    def piece(self) -> float:
        """Length of the pieces of `wanted` [mm]."""
        return self.frame.size[1] / self.wanted.shape[1]

    def _field(self, job: Job, first: int, count: int) -> RepeatedField:
        """Return the map over the panel as it is printed; `first` is the groove at an LED."""
        start = self.frame.origin[1]
        place = (job.film.groove.pitch, self.piece, first, start, count, self.frame.panel[1])
        if self.halftone is None:
            return RepeatedField(self.wanted, *place)
        return HalftoneField(self.halftone.two_level, *place, self.halftone)

    def library(self, job: Job, where: str) -> PieceLibrary | CellLibrary:
        """Return the film over the cells that are traced, its C rounded to levels.

        Raises
        ------
        InputError
            that begins with `where`, when a film cannot have a curvature.
        """
        if self.halftone is not None:
            film = levelled_library(
                job, self.halftone, self.frame, where, self.error, turned=self.turned
            )
            return film.repeated(self.frame.repeat)
        levels = LEVELS if job.cad.levels is None else job.cad.levels
        if job.has_cells:
            assert job.film.cell != "groove"  # has_cells says so
            along = self.wanted if self.along is None else self.along
            both = np.stack([self.wanted, along], axis=-1)
            cells = build_cell_library(
                job.film.groove, job.film.base, job.film.cell, job.film.profile, both, levels
            )
            return cells.repeated(self.frame.repeat)
        length = self.frame.size[1] / self.wanted.shape[1]
        cell = build_library(job.film.groove, job.film.base, length, self.wanted, levels)
        return cell.repeated(self.frame.repeat)


def read_cell_film_map(
    job: Job, job_file: Path, stack: Stack, departure: Departure = AS_DESIGNED
) -> CellFilmMap:
    """Return the maps of a job under LEDs, of films as they are printed.

    Raises
    ------
    InputError
        when a map is wrong.
    """
    along = read_along_map(job, job_file, stack, departure)
    wanted = read_cell_maps(job, job_file, stack, departure)
    return _build(job, wanted, stack, along, str(job_file), departure)


def restore_cell_film_map(job: Job, folder: Path, stack: Stack) -> CellFilmMap:
    """Return the maps of an export under LEDs from its own files.

    Raises
    ------
    ExportError
        when a file is not the map of such a cell.
    """
    frames = [CellFrame.of(stack), CellFrame.of(stack).turned]
    found = []
    for name, frame in zip(CELL_FILES[: 1 if job.crossed is None else 2], frames, strict=False):
        shape = frame.places(job.film.groove.pitch, piece_length(job), str(folder))
        found.append(_stored(folder / name, "curvature_per_mm", shape))
    first = folder / CELL_FILES[0]
    along = _stored(first, ALONG_ARRAY, found[0].shape) if has_along(first) else None
    return _build(job, found, stack, along, str(folder))


def _stored(path: Path, name: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return an array of curvatures of an export, (n, m) [1/mm]."""
    (curvature,) = read_arrays(path, (name,))
    if curvature.T.shape != shape:
        raise ExportError(
            f"{path}: {curvature.T.shape} places: expected {shape}, of the LEDs' cell"
        )
    return np.ascontiguousarray(curvature.T, np.float64)


def _build(
    job: Job,
    wanted: list[NDArray[np.float64]],
    stack: Stack,
    along: NDArray[np.float64] | None,
    where: str,
    departure: Departure = AS_DESIGNED,
) -> CellFilmMap:
    frames = (CellFrame.of(stack), CellFrame.of(stack).turned)

    def one(number: int, crossed: CellFilmMap | None) -> CellFilmMap:
        tone, halftone, error = wanted[number], None, departure.film(number)
        if job.halftone is not None:
            tone = clipped_tone(job, tone) if error.pattern else tone
            halftone = halftone_of(job, tone, where)
        own = along if number == 0 else None
        return CellFilmMap(
            tone, frames[number], crossed, own, halftone, error, turned=number == 1
        )  # fmt: skip

    return one(0, one(1, None) if len(wanted) > 1 else None)
