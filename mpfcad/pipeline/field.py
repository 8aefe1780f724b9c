"""Jobs whose curvature varies in both directions: they get a mask, but no solid and no trace."""

from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.film import FieldFilm, Groove, is_field_file, read_curvature_field
from mpfcad.job import Job


def has_field(job: Job, job_file: Path) -> bool:
    """Return whether a job's map varies along the grooves too."""
    file = job.map.file
    return file is not None and file.endswith(".npz") and is_field_file(job_file.parent / file)


def read_field_film(
    job: Job, job_file: Path, groove_count: int, panel_width: float, panel_length: float
) -> FieldFilm:
    """Return the film of such a job; lengths in mm.

    Raises
    ------
    InputError
        when the map is wrong, or not over the panel.
    """
    if job.map.extent != "panel":
        raise InputError(
            f"{job_file}: map.extent: {job.map.extent}: must be 'panel' for a map that varies "
            f"along the grooves too"
        )
    groove = Groove(job.film.pitch, job.film.depth)
    field = read_curvature_field(
        job_file.parent / job.map.file,
        profile=job.film.profile,
        groove=groove,
        panel_width=panel_width,
        panel_length=panel_length,
    )
    return FieldFilm(groove, panel_length, groove_count, field, job.film.profile)


def refuse_field(job: Job, job_file: Path) -> None:
    """Refuse to make a solid of, or to trace, a map in both directions.

    Raises
    ------
    InputError
        when the job has one.
    """
    if has_field(job, job_file):
        raise InputError(
            f"{job_file}: map.file: {job.map.file}: varies along the grooves too: allowed for "
            f"`mpfcad mask` only"
        )
