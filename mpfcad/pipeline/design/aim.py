"""What a design's map may be and is to be: its constraints, among them what can be printed."""

from pathlib import Path

import numpy as np

from mpfcad.design import Constraint, Goal
from mpfcad.errors import InputError
from mpfcad.film import Process
from mpfcad.job.design import Design
from mpfcad.pipeline.plan.screen import mask_rules

#: What the luminance is worth against contrast when it is to be the most within a contrast.
_LUMINANCE_FIRST = 0.2
#: Curvatures that a mould of an `ideal` film may have unless the design says otherwise [1/mm].
IDEAL_CURVATURE_MAX = 100.0
#: Share of the printable range of aperture ratio left to the rounding of the mask.
_RATIO_MARGIN = 0.01


def design_constraint(design: Design, process: Process | None, file: Path) -> Constraint:
    """Return the constraints, the printable range of C among them.

    Raises
    ------
    InputError
        when no range of C is left.
    """
    table = design.constraint
    low, high = table.curvature_min_per_mm, table.curvature_max_per_mm
    if process is not None:
        printable = _printable_range(process, design)
        low, high = max(low, printable[0]), min(high or np.inf, printable[1])
    high = high or IDEAL_CURVATURE_MAX
    if high - low < 1e-3:
        raise InputError(
            f"{file}: constraint.curvature_max_per_mm: {high:.4g}: must be above the "
            f"smallest curvature {low:.4g}, of the constraint and of what can be printed"
        )
    return Constraint(low, high, table.change_max_per_mm2, table.harmonics)


def design_goal(design: Design) -> Goal:
    """Return what the search is to reach."""
    table, shift = design.goal, design.constraint.registration_mm
    if table.aim == "contrast":
        return Goal(registration=shift)
    if table.luminance_weight is not None:  # aim = "trade"
        return Goal(luminance_weight=table.luminance_weight, registration=shift)
    # Half the target is left to the interval of the trace.
    return Goal(table.contrast_target / 2, _LUMINANCE_FIRST, shift)


def _printable_range(process: Process, design: Design) -> tuple[float, float]:
    """Return the smallest and largest C [1/mm] that process and mask rules print."""
    from mpfcad.mask.rule import ratio_range

    rules = mask_rules(design.mask, design.name)
    low, high = ratio_range(rules, process.groove.pitch, design.mask.period)
    low, high = low * (1 + _RATIO_MARGIN), high * (1 - _RATIO_MARGIN)
    high = min(high, process.aperture_ratio_max)
    return float(process.curvature(high)), float(process.curvature(low))
