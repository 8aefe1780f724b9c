"""What any map of a design reaches: by search, by a bound over all maps, and by a trace."""

from typing import Any

import numpy as np

from mpfcad.design import (
    BOUND_GRID,
    Constraint,
    Goal,
    Iteration,
    Response,
    bound_contrast,
    correction_of,
    find_optimum,
    find_reach,
    predict,
)
from mpfcad.pipeline.design.work import DesignWork

#: A map free of the design's own smoothness: harmonics, and change of C [1/mm per mm].
_HARMONICS, _CHANGE = 10, 1000.0
#: Linear programmes of a bound over all maps.
_PARTS = 9


def describe_reach(work: DesignWork, done: list[Iteration]) -> dict[str, Any]:
    """Return what maps reach; where none that was traced is good enough, what none goes below.

    Where the ranges of luminance above and between the lamps do not overlap, the map of the extreme
    is traced.
    """
    work.progress.stage("finding what any map reaches")
    low, high = work.constraint.curvature_min, work.constraint.curvature_max
    best = work.best(done)
    correction = correction_of(done, work.response)
    reach = find_reach(work.response, correction, low, high)
    found: dict[str, Any] = {
        "luminance_ratio": list(reach.ratio),
        "contrast_bound": None,
        "traced": None,
        "free_contrast": None,
    }
    if best.traced.contrast_low > work.design.goal.contrast_target:
        found["free_contrast"] = _free_contrast(work, best, done)
        found["contrast_bound"] = contrast_bound(work, done)
    if not reach.overlaps:
        rows = reach.rows[1 if reach.ratio[1] < 1 else 0]
        traced = work.trace(rows, "the map of the extreme ratio", len(done))
        found["traced"] = {
            "curvature_per_mm": [float(c) for c in rows],
            "luminance_ratio": traced.luminance_ratio,
            "paths": traced.paths,
        }
    return found


def _free_contrast(work: DesignWork, best: Iteration, done: list[Iteration]) -> float:
    """Return the least contrast found, by the model, of a map that may be as steep as it likes."""
    low, high = work.constraint.curvature_min, work.constraint.curvature_max
    free = Constraint(low, high, _CHANGE, _HARMONICS)
    start = np.zeros(_HARMONICS + 1)
    count = min(len(best.series), len(start))
    start[:count] = best.series[:count]
    correction = correction_of(done, work.response)
    series = find_optimum(start, work.response, correction, free, Goal(), work.pitch)
    return predict(series, work.response, correction).contrast


def contrast_bound(work: DesignWork, done: list[Iteration]) -> float:
    """Return the contrast that no map goes below, by a coarser model that the traces correct."""
    operators = work.estimate(BOUND_GRID)
    work.progress.stage("bounding the contrast of all maps")
    correction = correction_of(done, Response(operators))
    low, high = work.constraint.curvature_min, work.constraint.curvature_max
    return bound_contrast(operators, correction, low, high, _PARTS)
