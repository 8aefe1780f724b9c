"""Jobs whose curvature varies in both directions: their map, and the window that is drawn."""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.film import (
    FieldFilm,
    FieldPiece,
    PrismFilm,
    cut_piece,
    is_field_file,
    read_curvature_field,
)
from mpfcad.job import CadTable, Job

#: What a traced piece may differ from its neighbour on the panel [1/mm]: the gate of mask and mesh.
REPEAT_TOLERANCE = 0.1
FIELD_FILE = "curvature.npz"


def has_field(job: Job, job_file: Path) -> bool:
    """Return whether a job's map varies along the grooves too."""
    file = job.map.file
    return file is not None and file.endswith(".npz") and is_field_file(job_file.parent / file)


def read_field_film(job: Job, file: Path, where: str, groove_count: int, stack: Stack) -> FieldFilm:
    """Return the film of such a job, its map read from `file`; `where` names the job in errors.

    Raises
    ------
    InputError
        when the map is wrong, or not over the panel.
    """
    if job.map.extent != "panel":
        raise InputError(
            f"{where}: map.extent: {job.map.extent}: expected 'panel' for a map that varies "
            f"along the grooves too"
        )
    groove = job.film.groove
    field = read_curvature_field(
        file,
        profile=job.film.profile,
        groove=groove,
        panel_width=stack.panel_width,
        panel_length=stack.panel_length,
    )
    return FieldFilm(groove, stack.panel_length, groove_count, field, job.film.profile)


def cut_window(job: Job, film: FieldFilm, stack: Stack, where: str) -> tuple[int, FieldPiece]:
    """Return the first groove and the piece that the job's `[cad]` asks for.

    Raises
    ------
    InputError
        when it is not on the panel, or the film is not grooves as designed.
    """
    if not job.film.is_plain:
        raise InputError(
            f"{where}: map.file: {job.map.file}: varies along the grooves too: expected "
            "grooves as designed, without cells or imperfections"
        )
    table, pitch = job.cad, film.groove.pitch
    if table.extent == "panel":
        return 0, cut_piece(film, 0, film.groove_count, 0.0, film.length, job.film.base)
    width = table.inside("width_mm") or stack.period.across
    count = min(math.ceil(width / pitch - 1e-9), film.groove_count)
    start = table.inside("start_across_mm")
    place = stack.origin[0] if start is None else start
    first = round(place / pitch)
    if start is None:
        first = min(max(first, 0), film.groove_count - count)
    elif first + count > film.groove_count:
        most = (film.groove_count - count) * pitch
        raise InputError(
            f"{where}: cad.start_across_mm: {start:g}: expected at most {most:g}, for a piece "
            f"{count * pitch:g} mm wide"
        )
    along = _start_along(table, film.length, where)
    return first, cut_piece(film, first, count, along, table.length, job.film.base)


def _start_along(table: CadTable, length: float, where: str) -> float:
    """Return y [mm] on the panel of the piece's lower end; in the panel's middle unless given."""
    most = length - table.length
    if most < 0:
        raise InputError(f"{where}: cad.length_mm: {table.length:g}: expected at most {length:g}")
    start = table.inside("start_along_mm")
    if start is None:
        return most / 2
    if start > most:
        raise InputError(
            f"{where}: cad.start_along_mm: {start:g}: expected at most {most:g}, for a piece "
            f"{table.length:g} mm long"
        )
    return start


def field_section(film: FieldFilm, y: float, base: float) -> PrismFilm:
    """Return the panel as it is everywhere when it is cut at y [mm]."""
    curvature = film.curvature_at(film.groove_position, np.full(film.groove_count, y))
    return PrismFilm(film.groove, base, film.length, film.profile, curvature)


def refuse_window(job: Job, where: str) -> None:
    """Refuse the fields that only a map in both directions has a use for.

    Raises
    ------
    InputError
        when the job has one.
    """
    for name in CadTable.WINDOW:
        if getattr(job.cad, name) is not None:
            raise InputError(
                f"{where}: cad.{name}: {getattr(job.cad, name):g}: is for maps that vary along the "
                "grooves too: expected no such field"
            )


def refuse_single(film: FieldFilm, piece: FieldPiece, stack: Stack, where: str) -> None:
    """Refuse to trace a piece that is not what lies beside it on the panel: a trace repeats it.

    Across, a piece as wide as the lamp pitch is taken as it is, as with maps across the grooves.

    Raises
    ------
    InputError
        naming the side that does not repeat and by how much.
    """
    width, length = piece.size
    hint = "to be traced it must span whole periods of the map (`mpfcad mask` and `cad` need none)"
    ends = float(np.abs(piece.curvature[:, -1] - piece.curvature[:, 0]).max())
    beside = _difference(film, piece, (0.0, length))
    if not piece.has_equal_ends or beside > REPEAT_TOLERANCE:
        raise InputError(
            f"{where}: cad.length_mm: {length:g}: the curvature of the piece and of what follows "
            f"along differ by up to {max(ends, beside):.3g} /mm: {hint}"
        )
    if width < stack.period.across - piece.groove.pitch:
        beside = _difference(film, piece, (width, 0.0))
        if beside > REPEAT_TOLERANCE:
            raise InputError(
                f"{where}: cad.width_mm: {width:g}: the curvature of the piece and of what follows "
                f"across differ by up to {beside:.3g} /mm: {hint}, or the lamp pitch"
            )


def _difference(film: FieldFilm, piece: FieldPiece, step: tuple[float, float]) -> float:
    """Return the largest difference [1/mm] to the piece's neighbour; 0 where none is on the panel.

    The neighbour is the next one, or where that is not on the panel the one before.
    """
    low = np.array(piece.origin)
    size = np.array(piece.size)
    room = np.array([film.width, film.length]) + 1e-9
    for sign in (1, -1):
        moved = low + sign * np.array(step)
        if np.all(moved >= -1e-9) and np.all(moved + size <= room):
            x = piece.groove_position + moved[0]
            y = np.clip(piece.along + moved[1], 0, film.length)
            found = _sample(film, x, y)
            return float(np.abs(found - piece.curvature).max())
    return 0.0


def _sample(film: FieldFilm, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return C [1/mm] at all of x by all of y [mm], (n, k)."""
    return film.curvature_at(*np.meshgrid(x, y, indexing="ij"))
