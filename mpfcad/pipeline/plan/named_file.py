"""The files that a job names, checked before anything is read: each by its field."""

from pathlib import Path

from mpfcad.boundary import named_file
from mpfcad.job import Job


def check_job_files(job: Job, job_file: Path) -> None:
    """Refuse a job one of whose files is not there, or is no file.

    Raises
    ------
    InputError
        naming the job, the field and the file.
    """
    named = {
        "map.file": (job.map.file, "a curvature map (.csv or .npz)"),
        "crossed.file": (
            None if job.crossed is None else job.crossed.file,
            "a curvature map (.csv or .npz)",
        ),
        "process.calibration": (job.process.calibration, "a process calibration (TOML)"),
        "film.measured_file": (job.film.measured_file, "a stylus trace"),
    }
    for field, (name, expected) in named.items():
        if name is not None:
            named_file(f"{job_file}: {field}", Path(job_file).parent, name, expected)
