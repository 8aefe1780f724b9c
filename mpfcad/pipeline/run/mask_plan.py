"""A job's mask and its screen, known before any file is made; of 1-D and of 2-D maps."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpfcad.film import Process
from mpfcad.job import Job
from mpfcad.mask import Mask, build_mask
from mpfcad.pipeline.plan.field import has_field, read_field_film
from mpfcad.pipeline.plan.plan import (
    Plan,
    groove_count,
    read_job_process,
    read_job_stack,
    read_plan,
)
from mpfcad.pipeline.plan.screen import mask_rules, moire_setting
from mpfcad.pipeline.run.make import plan_mask, refuse_unprintable


@dataclass(frozen=True, eq=False)
class MaskPlan:
    """A mask that can be made.

    Attributes
    ----------
    job
        the job as validated
    mask
        its apertures
    process
        the printing process
    plan
        of the whole job; None when the map varies along the grooves too
    """

    job: Job
    mask: Mask
    process: Process
    plan: Plan | None

    def describe(self) -> dict[str, Any]:
        """Return what screen maker and printer have to know, in outside names."""
        from mpfcad.mask.screen.screen import describe_screen

        return describe_screen(self.mask, self.process, moire_setting(self.job.mask))


def read_mask_plan(job: Job, job_file: Path) -> MaskPlan:
    """Return the mask of a job.

    Raises
    ------
    InputError
        when the job is wrong, or a groove or a mesh cannot be made.
    """
    job_file = Path(job_file)
    if has_field(job, job_file):
        return _read_field(job, job_file)
    refuse_unprintable(job, str(job_file))
    plan = read_plan(job, job_file)
    return MaskPlan(job, plan_mask(plan), plan.process, plan)


def _read_field(job: Job, job_file: Path) -> MaskPlan:
    refuse_unprintable(job, str(job_file))
    stack = read_job_stack(job, job_file)
    groove = job.film.groove
    count = groove_count(stack.panel_width, groove.pitch)
    map_file = job_file.parent / job.map.file
    film = read_field_film(job, map_file, str(job_file), count, stack)
    file = job.process.calibration
    calibration = None if file is None else job_file.parent / file
    process = read_job_process(job, calibration, groove, str(job_file))
    mask = build_mask(film, process, mask_rules(job.mask, job.name), job.name)
    return MaskPlan(job, mask, process, None)
