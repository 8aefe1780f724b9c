"""The CAD piece as a job says it is made: as designed, imperfect or measured, or of cells."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import (
    CellFilm,
    CellLibrary,
    CellShape,
    FieldPiece,
    Groove,
    Imperfection,
    MadeFilm,
    PieceLibrary,
    PrismFilm,
    ReadingOption,
    average_groove,
    read_stylus_trace,
)
from mpfcad.job import Job
from mpfcad.units import deg

#: What film.step and film.stl hold.
Drawn = PrismFilm | MadeFilm | CellFilm | FieldPiece | PieceLibrary | CellLibrary


def read_measured(job: Job, job_file: Path) -> NDArray[np.float64] | None:
    """Return the mean groove of the job's stylus trace, as `average_groove`; None without one.

    Raises
    ------
    InputError
        when the trace cannot be read, or does not show such grooves.
    """
    table = job.film
    if table.measured_file is None:
        return None
    groove = table.groove
    trace = read_stylus_trace(
        job_file.parent / table.measured_file, groove, option=ReadingOption(own_shape=True),
        profile=table.profile,
    )  # fmt: skip
    return average_groove(trace, groove, table.profile)


def draw_piece(
    job: Job, piece: PrismFilm, measured: NDArray[np.float64] | None, where: str
) -> Drawn:
    """Return the piece as the job says it is made; `where` names the job in errors.

    Raises
    ------
    InputError
        when the job's departures, or its cells, cannot be.
    """
    if job.film.is_plain:
        return piece
    if job.film.cell != "groove":
        return _draw_cells(job, job.film.cell, piece, where)
    made = _draw_made(job, piece, measured, where)
    made.section()  # whatever does not fit is refused here, before anything is written
    return made


def _draw_made(
    job: Job, piece: PrismFilm, measured: NDArray[np.float64] | None, where: str
) -> MadeFilm:
    """Return the piece as made, with the resin that the mask gives it."""
    table = job.film
    try:
        groove = table.groove_as_made
    except ValueError as error:
        raise InputError(f"{where}: film.{error}") from None
    if measured is not None:
        if table.prism_angle_error_deg:
            raise InputError(
                f"{where}: film.prism_angle_error_deg: {table.prism_angle_error_deg:g}: expected 0 "
                f"with measured_file: a measured surface has its own walls"
            )
        # The tool keeps its angle: grooves of another pitch are similar ones.
        larger = groove.pitch / piece.groove.pitch
        measured = measured * np.array([larger, larger, 1 / larger])
    angle = _contact_angle(job, groove, where)
    imperfection = Imperfection(table.tip_radius, table.valley_radius, measured, angle)
    curvature = piece.curvature
    if piece.profile == "filled":
        curvature = np.minimum(curvature, groove.curvature_empty)
    factor = _resin_factor(job, piece.groove_count, where)
    made = MadeFilm(replace(piece, groove=groove, curvature=curvature), imperfection, factor)
    try:
        return made.with_resin(piece.resin_height)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _contact_angle(job: Job, groove: Groove, where: str) -> float | None:
    """Return the angle [rad] at which the resin meets the walls; None: the parabola.

    Raises
    ------
    InputError
        where the film has no resin of its own shape, or the angle is not stated.
    """
    table = job.film
    if table.surface == "parabola":
        return None
    if table.profile != "filled":
        raise InputError(f"{where}: film.surface: {table.surface}: expected profile 'filled'")
    for name in ("tip_radius_um", "valley_radius_um", "measured_file"):
        if getattr(table, name):
            raise InputError(
                f"{where}: film.surface: {table.surface}: expected 'parabola' with {name}"
            )
    wall = math.atan(groove.wall_slope)
    if table.surface == "level":
        return wall
    angle = job.process.contact_angle_deg
    if angle is None:
        raise InputError(f"{where}: film.surface: arc: expected process.contact_angle_deg too")
    return angle * deg


def _resin_factor(job: Job, count: int, where: str) -> NDArray[np.float64] | None:
    """Return the resin of each groove over what the mask gives, log-normal with mean 1."""
    spread = job.film.resin_spread_percent / 100
    if not spread:
        return None
    if job.film.profile != "filled" or job.film.measured_file is not None:
        raise InputError(
            f"{where}: film.resin_spread_percent: {job.film.resin_spread_percent:g}: expected 0 "
            f"for a film without resin of its own, or with a measured one"
        )
    drawn = np.random.Generator(np.random.Philox(job.seed)).standard_normal(count)
    return np.exp(spread * drawn - spread**2 / 2)


def _draw_cells(job: Job, shape: CellShape, piece: PrismFilm, where: str) -> CellFilm:
    """Return the film of cells, as many as the piece's size holds."""
    if job.map.curvature_per_mm is None:
        raise InputError(f"{where}: map.file: {job.map.file}: cells: expected one curvature")
    if not job.film.model_copy(update={"cell": "groove"}).is_plain:
        raise InputError(f"{where}: film.cell: {job.film.cell}: cells: expected a film as designed")
    along = max(round(piece.length / piece.groove.pitch), 1)
    count = (piece.groove_count, along)
    curvature = job.map.curvature_per_mm
    return CellFilm(piece.groove, piece.base, shape, piece.profile, curvature, count)
