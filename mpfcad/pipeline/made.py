"""The CAD piece as it is really made: rounded, at another angle or pitch, or as measured."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.film import (
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


def refuse_imperfect(table: FilmTable, where: str) -> None:
    """Refuse to verify a film that is not made as designed.

    Raises
    ------
    InputError
        when the job states a departure.
    """
    if not table.is_plain:
        raise InputError(
            f"{where}: film: departures from the designed film: must be left out of a run; "
            "mpfcad cad draws them and mpfcad trace traces the mesh"
        )


def write_made(
    made: MadeFilm,
    folder: Path,
    formats: tuple[str, ...],
    angle_tolerance: float,
    progress: Progress,
) -> None:
    """Write film.step (one body, `film`) and film.stl, and check them from the files.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    ExportError
        when a file does not read back as what it should hold.
    """
    from mpfcad.cad import section_check, section_mesh, section_step, stl
    from mpfcad.cad.mesh import mesh_sliver

    unknown = [name for name in formats if name not in ("step", "stl")]
    if unknown:
        raise InputError(f"--format: {unknown[0]}: an imperfect film is written as step, stl")
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
