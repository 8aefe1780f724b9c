"""Luminance over a lamp pitch in outside names and plain values."""

from typing import Any

from mpfcad.measure import Estimate, LuminanceResult

CONTRAST_FORMULA = "(Lmax - Lmin) / (Lmax + Lmin)"
#: The figures of a trace; each is null where there was nothing to trace.
TRACE_KEYS = (
    "luminance",
    "degrees_of_freedom",
    "fit",
    "lamp_mura_contrast",
    "mean_luminance_cd_m2",
    "energy",
    "paths",
    "convergence",
    "accelerator",
)


def describe_luminance(result: LuminanceResult | None) -> dict[str, Any]:
    """Return the figures of a trace in outside names."""
    if result is None:
        return dict.fromkeys(TRACE_KEYS)
    return {
        "luminance": {
            "position_pitch": numbers(result.position_pitch),
            "luminance_cd_m2": numbers(result.luminance),
            "standard_error_cd_m2": numbers(result.standard_error),
        },
        "degrees_of_freedom": float(result.freedom),
        "fit": {
            "coefficient_cd_m2": numbers(result.fit.coefficient),
            "chi2_excess": float(result.fit.chi2_excess),
        },
        "curve": {
            "luminance_cd_m2": numbers(result.central_curve),
            "values": result.curve.values,
            "misfit": result.curve.misfit,
            "smoothed": not result.curve.is_sharp,
        },
        "meter": result.spot.describe(),
        "pitches": _pitches(result),
        **({} if result.judged is None else {"judged": _judged(result)}),
        "lamp_mura_contrast": {**_estimate(result.contrast), "formula": CONTRAST_FORMULA},
        "mean_luminance_cd_m2": _estimate(result.mean_luminance),
        "energy": _plain(result.energy),
        "paths": int(result.paths),
        "convergence": {
            "paths": [int(row[0]) for row in result.convergence],
            "contrast": numbers(result.convergence[:, 1]),
            "ci95": [numbers(row[2:]) for row in result.convergence],
        },
        "accelerator": result.accelerator,
    }


def _pitches(result: LuminanceResult) -> list[dict[str, Any]]:
    """Return each pitch of a panel with its place [mm from the left] and whether it is judged."""
    judged = result.judged
    if judged is None:
        return []
    return [
        {**_estimate(one), "from_to_mm": numbers(judged.place(i)), "judged": judged.is_judged(i)}
        for i, one in enumerate(result.pitches)
    ]


def _judged(result: LuminanceResult) -> dict[str, Any]:
    """Return what of a panel is judged and where its worst pitch is."""
    judged, worst = result.judged, result.worst
    assert judged is not None and worst is not None
    return {
        "rim_mm": float(judged.rim),
        "first_pitch": judged.first + 1,
        "last_pitch": judged.stop,
        "worst_pitch": worst + 1,
        "worst_from_to_mm": numbers(judged.place(worst)),
        "words": result.where,
    }


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {"value": float(estimate.value), "ci95": [float(estimate.low), float(estimate.high)]}


def numbers(values: Any) -> list[float]:
    """Return an array's values as plain numbers."""
    return [float(value) for value in values]


def _plain(value: Any) -> Any:
    """Return nested tables of numpy scalars as plain numbers."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return value if isinstance(value, int | str) else float(value)
