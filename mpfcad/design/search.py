"""The search for a map: the model proposes, a full trace of the exported mesh answers.

What a trace answers goes into the model as a correction: of the mean and of the first harmonics,
averaged over all traces so far, so that every traced path counts for the next proposal. The model
itself is left as it is (space mapping: Bandler et al., "Space mapping technique for electromagnetic
optimization", 1994).
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import Constraint, cosine_basis, series_rows
from mpfcad.design.optimum import Correction, Goal, find_optimum, map_on_cells, predict
from mpfcad.design.response import Response

_CORRECTED = 4


@dataclass(frozen=True)
class Traced:
    """What a full trace of a map's mesh says.

    Attributes
    ----------
    contrast, contrast_low, contrast_high
        lamp-Mura contrast and its 95 % interval
    mean, mean_error
        mean luminance and its standard error [cd/m²]
    coefficient
        Fourier series [cd/m²]: mean, then cosine and sine of each harmonic
    paths
        traced for it
    """

    contrast: float
    contrast_low: float
    contrast_high: float
    mean: float
    mean_error: float
    coefficient: tuple[float, ...]
    paths: int

    @property
    def cosines(self) -> NDArray[np.float64]:
        """Cosine amplitudes of the first harmonics over the mean, (4,)."""
        return np.array(self.coefficient[1::2][:_CORRECTED]) / self.coefficient[0]

    @property
    def sines(self) -> NDArray[np.float64]:
        """Sine amplitudes likewise, (4,)."""
        return np.array(self.coefficient[2::2][:_CORRECTED]) / self.coefficient[0]

    @property
    def luminance_ratio(self) -> float:
        """Luminance halfway between the lamps over that above a lamp."""
        above, between = self.curve(np.array([0.0, 0.5]))
        return float(between / above)

    def curve(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fitted luminance [cd/m²] at positions in pitches."""
        value = np.full(len(position), self.coefficient[0])
        for h in range(1, len(self.coefficient) // 2 + 1):
            angle = 2 * np.pi * h * position
            value += self.coefficient[2 * h - 1] * np.cos(angle)
            value += self.coefficient[2 * h] * np.sin(angle)
        return value


@dataclass(frozen=True)
class Iteration:
    """One traced map.

    Attributes
    ----------
    label
        what it is
    rows
        C [1/mm] at the map's rows
    series
        its cosine series [1/mm]; empty for a map that is none
    predicted_contrast, predicted_mean
        by the model as corrected before the trace; None without a model
    traced
        what the trace said
    """

    label: str
    rows: tuple[float, ...]
    series: tuple[float, ...]
    predicted_contrast: float | None
    predicted_mean: float | None
    traced: Traced

    def document(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)

    @classmethod
    def restore(cls, document: dict[str, Any]) -> "Iteration":
        """Return what `document` describes."""
        traced = {**document["traced"]}
        traced["coefficient"] = tuple(traced["coefficient"])
        parts = {key: tuple(document[key]) for key in ("rows", "series")}
        return cls(**{**document, **parts, "traced": Traced(**traced)})


#: Traces rows of C [1/mm] under a label, as the given number of the search.
TraceRows = Callable[[NDArray[np.float64], str, int], Traced]


def search_by_response(
    response: Response,
    constraint: Constraint,
    goal: Goal,
    pitch: float,
    trace: TraceRows,
    *,
    iterations: int,
    contrast_target: float,
    finish: Callable[[NDArray[np.float64]], NDArray[np.float64]] = lambda rows: rows,
) -> list[Iteration]:
    """Return the traced maps in their order; the last is not always the best (`best_of`).

    Ends after `iterations`, or when the interval of a traced contrast ends below `contrast_target`.
    `finish` turns the rows of a series into those that are made (levels of the mask).
    """
    done: list[Iteration] = []
    middle = (constraint.curvature_min + constraint.curvature_max) / 2
    series = np.append(middle, np.zeros(constraint.harmonics))
    for number in range(iterations):
        correction = correction_of(done, response)
        series = find_optimum(series, response, correction, constraint, goal, pitch)
        shift = goal.registration / pitch
        prediction = predict(series, response, correction, shift)
        rows = finish(series_rows(series)[1])
        label = f"iteration {number + 1}"
        traced = trace(rows, label, number)
        done.append(
            Iteration(
                label,
                tuple(map(float, rows)),
                tuple(map(float, series)),
                prediction.contrast,
                prediction.mean,
                traced,
            )
        )
        if traced.contrast_high <= contrast_target:
            break
    return done


def correction_of(done: Sequence[Iteration], response: Response) -> Correction:
    """Return what the traces so far say of the model, each weighted by its paths."""
    if not done:
        return Correction.none()
    weight = np.array([float(one.traced.paths) for one in done])
    scale, relative = [], []
    basis = cosine_basis(response.grid.centre, _CORRECTED)[:, 1:]
    for one in done:
        luminance = response.luminance(map_on_cells(np.array(one.series), response))
        mean = luminance.mean()
        scale.append(one.traced.mean / mean)
        relative.append(one.traced.cosines - 2 * (luminance / mean) @ basis / len(basis))
    weight /= weight.sum()
    return Correction(float(weight @ scale), weight @ np.array(relative))


def best_of(done: Sequence[Iteration], goal: Goal) -> Iteration:
    """Return the traced map that serves the goal best, by the upper end of its contrast."""

    def merit(one: Iteration) -> float:
        contrast = max(one.traced.contrast_high, goal.contrast_floor)
        return contrast - goal.luminance_weight * float(np.log(one.traced.mean))

    return min(done, key=merit)
