"""What a design's map may be and is to be: its constraints, among them what can be printed."""

from pathlib import Path

import numpy as np

from mpfcad.design import Constraint, Goal
from mpfcad.errors import InputError
from mpfcad.film import Process
from mpfcad.job import Job
from mpfcad.job.design import Design
from mpfcad.mask.rule import ratio_range
from mpfcad.pipeline.plan.printed.printable import printable_range
from mpfcad.pipeline.plan.printed.screen import job_levelling, mask_rules
from mpfcad.units import um

#: What the luminance is worth against contrast when it is to be the most within a contrast.
_LUMINANCE_FIRST = 0.2
#: Curvatures that a mould of an `ideal` film may have unless the design says otherwise [1/mm].
IDEAL_CURVATURE_MAX = 100.0


def design_constraint(design: Design, job: Job, process: Process | None, file: Path) -> Constraint:
    """Return the constraints, among them what is printed: the range of C, and how steep it may be.

    `job` is that of any map of the design.
    Through a mesh a print that is shifted by `mask.registration_um` may change no groove by more
    than `gates.registration_curvature_per_mm`.

    Raises
    ------
    InputError
        when no range of C is left.
    """
    table = design.constraint
    low, high = table.curvature_min_per_mm, table.curvature_max_per_mm
    if process is not None:
        rules = mask_rules(job.mask, str(file), _levelling(job, process, file))
        printable = printable_range(process, rules, job.gates, str(file))
        low, high = max(low, printable[0]), min(high or np.inf, printable[1])
    high = high or IDEAL_CURVATURE_MAX
    if high - low < 1e-3:
        raise InputError(
            f"{file}: constraint.curvature_max_per_mm: {high:.4g}: expected above the "
            f"smallest curvature {low:.4g}, of the constraint and of what can be printed"
        )
    return Constraint(low, high, _change_max(design, job, process), table.harmonics)


def _change_max(design: Design, job: Job, process: Process | None) -> float:
    """Return how much C may change [1/mm per mm] across."""
    stated, shift = design.constraint.change_max_per_mm2, job.mask.registration_um * um
    if process is None or job.mask.mesh is None or shift == 0:
        return stated
    return min(stated, job.gates.registration_curvature_per_mm / shift)


def _levelling(job: Job, process: Process, file: Path) -> float | None:
    """Return the levelling length [mm] of the least filled groove that is ever printed."""
    if job.process.flow is None:
        return None
    rules = mask_rules(job.mask, str(file))
    low, _ = ratio_range(rules, process.groove.pitch, rules.period)
    if rules.mesh is not None:
        low = max(low, job.gates.ratio_min)
    return job_levelling(job, process, process.groove, low, str(file))


def design_goal(design: Design) -> Goal:
    """Return what the search is to reach; before one for confidence, the nominal one."""
    table, shift = design.goal, design.constraint.registration_mm
    if table.aim in ("contrast", "confidence"):
        return Goal(registration=shift)
    if table.luminance_weight is not None:  # aim = "trade"
        return Goal(luminance_weight=table.luminance_weight, registration=shift)
    # Half the target is left to the interval of the trace.
    return Goal(table.contrast_target / 2, _LUMINANCE_FIRST, shift)
