"""What a design found, in outside names: design.json."""

from typing import Any

import numpy as np

from mpfcad.design import Iteration
from mpfcad.measure import Estimate
from mpfcad.pipeline.design.work import DesignWork
from mpfcad.store import versions


def describe_design(
    work: DesignWork,
    done: list[Iteration],
    chosen: Iteration,
    reach: dict[str, Any] | None,
    thickness: dict[str, Any] | None,
    likely: dict[str, Any] | None,
) -> dict[str, Any]:
    """Return everything that was found, in outside names.

    `thickness` is over a range of it, `likely` of a search for confidence.
    """
    constraint = work.constraint
    return {
        "schema": 1,
        "name": work.design.name,
        "design": work.design.document(),
        "stack": {"title": work.stack.title, "inputs": work.stack.inputs()},
        "constraint": {
            "curvature_min_per_mm": constraint.curvature_min,
            "curvature_max_per_mm": constraint.curvature_max,
            "change_max_per_mm2": constraint.change_max,
        },
        "screen": None if work.process is None else work.screen,
        "lamp_pitch_mm": work.pitch,
        "model": work.model,
        "reach": reach,
        "thickness_mm": work.stack.thickness,
        "thickness": thickness,
        "iterations": [describe_iteration(one) for one in done],
        "chosen": done.index(chosen),
        "confidence": likely,
        "paths": sum(one.paths for one in done) + (likely["paths"] if likely else 0),
        "versions": versions(),
    }


def describe_iteration(one: Iteration) -> dict[str, Any]:
    """Return a traced map in outside names."""
    traced = one.traced
    predicted = None
    if one.predicted_contrast is not None:
        predicted = {
            "lamp_mura_contrast": one.predicted_contrast,
            "mean_luminance_cd_m2": one.predicted_mean,
        }
    shifted = one.shifted and {
        "value": one.shifted.contrast,
        "ci95": [one.shifted.contrast_low, one.shifted.contrast_high],
    }
    # Of 33 points and dozens of blocks: the error is as good as known.
    mean = Estimate.student(traced.mean, traced.mean_error, np.inf)
    return {
        "label": one.label,
        "series_per_mm": list(one.series),
        "curvature_per_mm": list(one.rows),
        "predicted": predicted,
        "lamp_mura_contrast": {
            "value": traced.contrast,
            "ci95": [traced.contrast_low, traced.contrast_high],
        },
        "mean_luminance_cd_m2": {
            "value": traced.mean,
            "ci95": [mean.low, mean.high],
        },
        "fit_coefficient_cd_m2": list(traced.coefficient),
        "shifted_lamp_mura_contrast": shifted,
        "paths": one.paths,
    }
