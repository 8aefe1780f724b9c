"""The screen of a design: a weaver's mesh by its numbers, or one that the program chooses."""

from pathlib import Path

import numpy as np

from mpfcad.job import Job, build_job
from mpfcad.job.design import Design
from mpfcad.pipeline.plan.printed.nearest import Asked
from mpfcad.pipeline.plan.printed.propose import with_screen
from mpfcad.pipeline.plan.printed.screen import with_own_catalogue


def with_design_screen(design: Design, file: Path) -> tuple[Design, Job]:
    """Return a design with its screen in place, and the job of any of its maps.

    `mask.mesh = "auto"` takes the screen that prints the whole range of `[constraint]` best.

    Raises
    ------
    InputError
        when a mesh is not known, or none prints that range; it names one that is printed.
    """
    job = with_own_catalogue(build_job(design.job_document("map.csv"), str(file)), file)
    table, groove = design.constraint, design.film.groove
    high = min(table.curvature_max_per_mm or groove.curvature_empty, groove.curvature_empty)
    ends = np.linspace(table.curvature_min_per_mm, high, 33)
    job, _ = with_screen(job, file, Asked(ends, "constraint", False), groove)
    if job.mask is design.mask or "mask" not in job.model_fields_set:
        return design, job
    changed = design.model_copy(update={"mask": job.mask, "process": job.process})
    changed.model_fields_set.update({"mask", "process"} & job.model_fields_set)
    return changed, job
