"""CAD pieces that are no plain row of grooves: imperfect or measured ones, and films of cells."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.film import (
    CellFilm,
    Groove,
    Imperfection,
    PrismFilm,
    Section,
    average_groove,
    build_section,
    read_stylus_trace,
)
from mpfcad.job import FilmTable
from mpfcad.pipeline.plan import Plan
from mpfcad.pipeline.progress import Progress


@dataclass(frozen=True, eq=False)
class MadeFilm:
    """A piece with its own pitch and prism angle, and how it departs from sharp prisms."""

    film: PrismFilm
    imperfection: Imperfection

    def section(self, sliver: float | None = None) -> Section:
        """Return its cross-section, parts narrower than `sliver` [mm] merged."""
        options = {} if sliver is None else {"sliver": sliver}
        return build_section(self.film, self.imperfection, **options)


def read_made(plan: Plan, job_file: Path) -> MadeFilm:
    """Return the CAD piece of a plan as its job says it is made.

    Raises
    ------
    InputError
        when the job's departures cannot be.
    """
    table, piece = plan.job.film, plan.piece
    if table.cell != "groove":
        raise InputError(f"{job_file}: film.cell: {table.cell}: must be 'groove' for a mould")
    pitch = piece.groove.pitch + table.pitch_error
    if pitch <= 0:
        raise InputError(
            f"{job_file}: film.pitch_error_um: {table.pitch_error_um:g}: must be above "
            f"{-table.pitch_um:g}"
        )
    depth = piece.groove.depth
    if table.prism_angle is not None:
        depth = pitch / 2 / math.tan(table.prism_angle / 2)
    film = replace(piece, groove=Groove(pitch, depth))
    measured = None
    if table.measured_file is not None:
        groove = piece.groove
        trace = read_stylus_trace(job_file.parent / table.measured_file, groove)
        measured = average_groove(trace, groove, piece.profile) * (pitch / groove.pitch, 1.0)
    return MadeFilm(film, Imperfection(table.tip_radius, table.valley_radius, measured))


def _read_cells(plan: Plan, job_file: Path) -> CellFilm:
    """Return the film of cells that a job's CAD piece is, as many as its size holds."""
    job, piece = plan.job, plan.piece
    if job.map.curvature_per_mm is None:
        raise InputError(f"{job_file}: map.file: {job.map.file}: cells must have one curvature")
    if not job.film.model_copy(update={"cell": "groove"}).is_plain:
        raise InputError(f"{job_file}: film.cell: {job.film.cell}: cells must be made as designed")
    along = max(round(piece.length / piece.groove.pitch), 1)
    count = (piece.groove_count, along)
    curvature = job.map.curvature_per_mm
    return CellFilm(piece.groove, piece.base, job.film.cell, piece.profile, curvature, count)


def _write_cells(
    film: CellFilm,
    folder: Path,
    formats: tuple[str, ...],
    angle_tolerance: float,
    progress: Progress,
) -> None:
    """Write film.step (one body, `film`) and film.stl of cells, and check them from the files."""
    from mpfcad.cad import cell_check, cell_mesh, cell_step, stl

    if "step" in formats:
        progress.stage("writing film.step")
        cell_step.write_cell_step(film, folder / "film.step")
        cell_check.check_cell_step(folder / "film.step", film)
    if "stl" in formats:
        progress.stage("writing film.stl")
        mesh = cell_mesh.build_cell_mesh(film, angle_tolerance)
        stl.write_mesh(mesh, folder / "film.stl", "film")
        cell_check.check_cell_stl(folder / "film.stl", film, angle_tolerance)


def write_unusual(
    plan: Plan, job_file: Path, folder: Path, formats: tuple[str, ...], progress: Progress
) -> None:
    """Write film.step and film.stl of a job that is not plain, and check them from the files.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    ExportError
        when a file does not read back as what it should hold.
    """
    unknown = [name for name in formats if name not in ("step", "stl")]
    if unknown:
        raise InputError(f"--format: {unknown[0]}: such a film is written as step, stl")
    tolerance = plan.job.cad.angle_tolerance
    if plan.job.film.cell == "groove":
        _write_made(read_made(plan, job_file), folder, formats, tolerance, progress)
    else:
        _write_cells(_read_cells(plan, job_file), folder, formats, tolerance, progress)


def refuse_unusual(table: FilmTable, where: str) -> None:
    """Refuse to verify what is no plain row of grooves, made as designed.

    Raises
    ------
    InputError
        when the job states a departure, or cells.
    """
    if not table.is_plain:
        raise InputError(
            f"{where}: film: departures from the designed film, or cells: not for a run: "
            "mpfcad cad draws them and mpfcad trace traces the mesh"
        )


def _write_made(
    made: MadeFilm,
    folder: Path,
    formats: tuple[str, ...],
    angle_tolerance: float,
    progress: Progress,
) -> None:
    """Write film.step (one body, `film`) and film.stl, and check them from the files."""
    from mpfcad.cad import section_check, section_mesh, section_step, stl
    from mpfcad.cad.mesh import mesh_sliver

    if "step" in formats:
        progress.stage("writing film.step")
        section, path = made.section(), folder / "film.step"
        colour = section_step.FILM_COLOUR
        section_step.write_section_step(section, path, name="film", body="film", colour=colour)
        section_check.check_section_step(path, section, "film")
    if "stl" in formats:
        progress.stage("writing film.stl")
        section, path = made.section(mesh_sliver(made.film)), folder / "film.stl"
        stl.write_mesh(section_mesh.build_section_mesh(section, angle_tolerance), path, "film")
        section_check.check_section_stl(path, section, angle_tolerance)
