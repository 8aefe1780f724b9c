"""What a fit found, as plain values: values, data, what is held and free, predictions."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.fit import Datum, Figured, Found, Unknowns
from mpfcad.measure import reach

FIT_SCHEMA = 1
#: A χ² less probable than this: the measurements contradict each other.
CONTRADICTS = 0.01
#: A combination of values is held when its width falls below this share of the prior's.
_HELD = 0.7
_PARTS = 4


@dataclass(frozen=True, eq=False)
class Fitted:
    """Data, values sought, what was found, what is predicted, what to measure next."""

    data: list[Datum]
    unknowns: Unknowns
    found: Found
    predictions: list[Figured]
    advice: list[dict[str, Any]]


def describe_fit(name: str, fitted: Fitted) -> dict[str, Any]:
    """Return the record of a fit, in outside names."""
    from scipy.special import chdtrc

    posterior, unknowns = fitted.found.posterior, fitted.unknowns
    unit = unknowns.unit(posterior.steps)
    data = [row for number in range(len(fitted.data)) for row in _datum(fitted, number)]
    freedom = posterior.freedom - int(np.count_nonzero(unknowns.is_free))
    probability = float(chdtrc(freedom, posterior.chi2)) if freedom > 0 else None
    return {
        "schema": FIT_SCHEMA,
        "name": name,
        "values": _values(fitted, unit),
        "covariance": {
            "names": unknowns.names,
            "matrix": (posterior.covariance * np.outer(unit, unit)).tolist(),
        },
        "data": data,
        "mostly_traces": sum(row["share_of_trace_noise"] > 0.5 for row in data),
        "chi2": posterior.chi2,
        "degrees_of_freedom": freedom,
        "probability": probability,
        "contradicts": probability is not None and probability < CONTRADICTS,
        "combinations": _combinations(fitted),
        **_predictions(fitted),
        "measure_next": fitted.advice,
        "rounds": list(fitted.found.moves),
        "settled": fitted.found.is_settled,
    }


def _values(fitted: Fitted, unit: NDArray[np.float64]) -> list[dict[str, Any]]:
    posterior, unknowns = fitted.found.posterior, fitted.unknowns
    found = unknowns.values(posterior.steps)
    low, high = unknowns.limits()
    left = np.sqrt(np.diag(posterior.covariance))
    prior = np.sqrt(np.diag(unknowns.prior))
    rows = []
    for i, factor in enumerate(unknowns.factors):
        value, sigma = found[factor.name], float(left[i] * unit[i])
        ends = [value - reach() * sigma, value + reach() * sigma]
        rows.append(
            {
                "name": factor.name,
                "prior": factor.value,
                "prior_sigma": None if unknowns.is_free[i] else factor.sigma,
                "prior_source": factor.source,
                "value": value,
                "sigma": sigma,
                "ci95": [max(ends[0], factor.low), min(ends[1], factor.high)],
                "left": None if unknowns.is_free[i] else float(left[i] / prior[i]),
                "at_limit": bool(min(posterior.steps[i] - low[i], high[i] - posterior.steps[i])
                                 < 1e-3),
            }
        )  # fmt: skip
    return rows


def _datum(fitted: Fitted, number: int) -> list[dict[str, Any]]:
    datum, posterior = fitted.data[number], fitted.found.posterior
    weight = posterior.weights[number]
    predicted, spread, _ = posterior.predicted(datum.figured, fitted.found.lines)
    before = datum.figured.predict(fitted.found.lines, np.zeros(len(posterior.steps)))
    off = datum.off(predicted)
    rows = []
    for i, label in enumerate(datum.label):
        measured, total = float(datum.covariance[i, i]), float(weight[i, i])
        rows.append(
            {
                "name": f"{datum.name} {label}".strip(),
                "measured": float(datum.value[i]),
                "kind": {0: "equal", 1: "at_least", -1: "at_most"}[datum.side],
                "sigma": measured**0.5,
                "by_prior": float(before[i]),
                "predicted": float(predicted[i]),
                "predicted_sigma": float(spread[i, i]) ** 0.5,
                "residual": float(off[i]) / total**0.5,
                "share_of_trace_noise": 1 - measured / total,
            }
        )
    return rows


def _combinations(fitted: Fitted) -> list[dict[str, Any]]:
    """Return the combinations of steps that the data hold, the best held first.

    Principal directions of the posterior in the prior's units: each width is a share of the
    prior's.
    """
    unknowns, posterior = fitted.unknowns, fitted.found.posterior
    root = np.linalg.cholesky(unknowns.prior)
    inverse = np.linalg.inv(root)
    value, vector = np.linalg.eigh(inverse @ posterior.covariance @ inverse.T)
    found = []
    for width, column in zip(np.sqrt(np.maximum(value, 0)), vector.T, strict=True):
        if width > _HELD:
            continue
        order = np.argsort(-np.abs(column), kind="stable")[:_PARTS]
        sign = np.sign(column[order[0]])
        parts = {unknowns.names[i]: float(sign * column[i]) for i in order}
        found.append({"width": float(width), "parts": parts})
    return found


def _predictions(fitted: Fitted) -> dict[str, Any]:
    posterior, lines = fitted.found.posterior, fitted.found.lines
    if not fitted.predictions:
        return {"predictions": [], "predictions_covariance": []}
    rows, slopes, traces = [], [], []
    for figured in fitted.predictions:
        value, spread, noise = posterior.predicted(figured, lines)
        slopes.append(figured.jacobian(lines, posterior.steps)[0])
        traces.append(float(noise[0, 0]))
        ends = posterior.interval(figured, lines)
        rows.append(
            {
                "name": figured.name,
                "value": float(value[0]),
                "sigma": float(spread[0, 0]) ** 0.5,
                "ci95": [float(end[0]) for end in ends],
                "trace_sigma": float(noise[0, 0]) ** 0.5,
            }
        )
    slope = np.array(slopes)
    together = slope @ posterior.covariance @ slope.T + np.diag(traces)
    return {"predictions": rows, "predictions_covariance": together.tolist()}
