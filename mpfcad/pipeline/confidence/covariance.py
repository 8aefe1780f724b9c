"""A job's covariance file, read into the job itself, so that an export holds what it hangs on."""

from pathlib import Path

from mpfcad.confidence import read_covariance
from mpfcad.job import Job


def with_covariance(job: Job, job_file: Path) -> Job:
    """Return the job with the covariance that it names in it.

    Raises
    ------
    InputError
        when the file is missing or holds no covariance.
    """
    table = job.confidence
    if table is None or table.covariance is None:
        return job
    names, matrix = read_covariance(job_file.parent / table.covariance)
    values = {**table.model_dump(exclude_unset=True), "covariance": None}
    inside = type(table)(**{**values, "names": names, "matrix": matrix.tolist()})
    return job.model_copy(update={"confidence": inside})
