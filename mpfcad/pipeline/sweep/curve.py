"""What the points of a sweep say together: curves over its main axis, optimum, range, limit."""

import json
from typing import Any

import numpy as np

from mpfcad.job.sweep import Sweep
from mpfcad.pipeline.point.thickness_limit import describe_limit

THICKNESS_AXIS = "stack.thickness_mm"


def main_axis(sweep: Sweep) -> str | None:
    """Return the first axis of numbers with more than one value; the others part the curves."""
    for axis, values in sweep.axis.items():
        if len(values) > 1 and isinstance(values[0], float):
            return axis
    return None


def find_optima(sweep: Sweep, results: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return, for each curve over the main axis, its optimum and the range below the limit.

    The range is where the contrast, linear between points, is below the limit; `certain` where the
    upper end of its interval is.
    """
    axis = main_axis(sweep)
    if axis is None:
        return []
    return [_optimum(axis, rest, curve, sweep) for rest, curve in curves_of(sweep, results)]


def curves_of(
    sweep: Sweep, results: list[dict[str, Any]]
) -> list[tuple[dict[str, Any], list[dict[str, Any]]]]:
    """Return the curves over the main axis: the other axes' values, and the points ascending."""
    axis = main_axis(sweep)
    if axis is None:
        return []
    curves: dict[str, list[dict[str, Any]]] = {}
    for result in sorted(results, key=lambda result: result["coordinate"][axis]):
        rest = {k: v for k, v in result["coordinate"].items() if k != axis}
        curves.setdefault(json.dumps(rest), []).append(result)
    return [(json.loads(rest), curve) for rest, curve in curves.items()]


def find_limits(
    sweep: Sweep, results: list[dict[str, Any]], conventional: dict[str, Any]
) -> list[dict[str, Any]]:
    """Return what each curve over the thickness says of its limit."""
    mean = conventional["mean_luminance_cd_m2"]["value"]
    return [_limit(sweep, curve, mean) for curve in curves_of(sweep, results)]


def _limit(
    sweep: Sweep, curve: tuple[dict[str, Any], list[dict[str, Any]]], conventional: float
) -> dict[str, Any]:
    """Return what a curve over the thickness says of its limit."""
    rest, points = curve
    limit = describe_limit(
        [one["coordinate"][THICKNESS_AXIS] for one in points],
        [one["lamp_mura_contrast"] for one in points],
        [one["mean_luminance_cd_m2"]["value"] for one in points],
        conventional,
        sweep.contrast_limit,
    )
    profile = rest.get("film.profile", sweep.film.get("profile", "filled"))
    return {"curve": rest, "profile": profile, **limit}


def _optimum(axis: str, rest: dict, curve: list[dict[str, Any]], sweep: Sweep) -> dict[str, Any]:
    x = np.array([result["coordinate"][axis] for result in curve])
    contrast = [result["lamp_mura_contrast"] for result in curve]
    value = np.array([c["value"] for c in contrast])
    high = np.array([c["ci95"][1] for c in contrast])
    best, brightest = int(np.argmin(value)), None
    below = np.flatnonzero(high <= sweep.contrast_limit)
    if below.size:
        mean = np.array([result["mean_luminance_cd_m2"]["value"] for result in curve])
        brightest = float(x[below[np.argmax(mean[below])]])
    return {
        "axis": axis,
        "curve": rest,
        "optimum": float(x[best]),
        "contrast": contrast[best],
        "mean_luminance_cd_m2": curve[best]["mean_luminance_cd_m2"],
        "below_limit": ranges_below(x, value, sweep.contrast_limit),
        "certain_below_limit": ranges_below(x, high, sweep.contrast_limit),
        "brightest_below_limit": brightest,
        **_likeliest(axis, curve),
    }


def _likeliest(axis: str, curve: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the point most likely within the limit in the real backlight, where that was asked."""
    if "confidence" not in curve[0]:
        return {}
    found = [result["confidence"]["probability"]["marginal"] for result in curve]
    best = max(range(len(curve)), key=lambda i: found[i]["value"])
    return {"likeliest": {axis: curve[best]["coordinate"][axis], **found[best]}}


def ranges_below(x: np.ndarray, value: np.ndarray, limit: float) -> list[list[float]]:
    """Return the ranges [from, to] of x in which a piecewise linear value is at most `limit`."""
    ranges: list[list[float]] = []
    inside = False
    for i in range(len(x)):
        if value[i] <= limit and not inside:
            start = x[i]
            if i > 0:
                share = (value[i - 1] - limit) / (value[i - 1] - value[i])
                start = x[i - 1] + share * (x[i] - x[i - 1])
            ranges.append([float(start), float(x[i])])
        elif value[i] <= limit:
            ranges[-1][1] = float(x[i])
        elif inside:
            share = (limit - value[i - 1]) / (value[i] - value[i - 1])
            ranges[-1][1] = float(x[i - 1] + share * (x[i] - x[i - 1]))
        inside = bool(value[i] <= limit)
    return ranges
