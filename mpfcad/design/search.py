"""The search for a map: the model proposes, a full trace of the exported mesh answers.

What a trace answers goes into the model as a correction: of the mean and of the first harmonics,
averaged over all traces so far, so that every traced path counts for the next proposal. The model
itself is left as it is (space mapping: Bandler et al., "Space mapping technique for electromagnetic
optimization", 1994).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import Constraint, series_rows
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
    shifted
        what that of the film shifted against the lamps said, if a shift is to be borne
    """

    label: str
    rows: tuple[float, ...]
    series: tuple[float, ...]
    predicted_contrast: float | None
    predicted_mean: float | None
    traced: Traced
    shifted: Traced | None = None

    @property
    def worst(self) -> Traced:
        """The trace with the larger upper end of the contrast, in place or shifted."""
        both = [self.traced] if self.shifted is None else [self.traced, self.shifted]
        return max(both, key=lambda traced: traced.contrast_high)

    @property
    def paths(self) -> int:
        """Number of paths traced for it."""
        return self.traced.paths + (self.shifted.paths if self.shifted else 0)


#: Traces rows of C [1/mm] under a label, as the given number of the search, shifted by so many mm.
TraceRows = Callable[[NDArray[np.float64], str, int, float], Traced]


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
        correction = correction_of(done, response, goal.registration / pitch)
        series = find_optimum(series, response, correction, constraint, goal, pitch)
        shift = goal.registration / pitch
        prediction = predict(series, response, correction, shift)
        rows = finish(series_rows(series)[1])
        label = f"iteration {number + 1}"
        traced = trace(rows, label, number, 0.0)
        shifted = trace(rows, label, number, goal.registration) if goal.registration else None
        done.append(
            Iteration(
                label,
                tuple(map(float, rows)),
                tuple(map(float, series)),
                prediction.contrast,
                prediction.mean,
                traced,
                shifted,
            )
        )
        if done[-1].worst.contrast_high <= contrast_target:
            break
    return done


def correction_of(
    done: Sequence[Iteration], response: Response, registration_pitch: float = 0.0
) -> Correction:
    """Return what the traces so far say of the model, each weighted by its paths.

    `registration_pitch`: the shift of the shifted ones, left out where it is 0; they alone say
    something of the sines.
    """
    if not done:
        return Correction.none()
    found = [(one, one.traced, 0.0) for one in done]
    found += [
        (one, one.shifted, registration_pitch) for one in done if one.shifted and registration_pitch
    ]
    weight = np.array([float(traced.paths) for _, traced, _ in found])
    error = np.array([_model_error(*one, response) for one in found])
    moved = np.array([shift != 0 for _, _, shift in found])
    scale, *relative = np.average(error[:, : _CORRECTED + 1], axis=0, weights=weight)
    odd = np.zeros(_CORRECTED)
    if moved.any():
        odd = np.average(error[moved, -_CORRECTED:], axis=0, weights=weight[moved])
    return Correction(float(scale), np.array(relative), odd)


def _model_error(
    one: Iteration, traced: Traced, shift: float, response: Response
) -> NDArray[np.float64]:
    """Return a trace's mean over the model's, then what its cosines and its sines exceed by."""
    luminance = response.luminance(map_on_cells(np.array(one.series), response, shift))
    mean = luminance.mean()
    angle = 2 * np.pi * np.outer(response.grid.centre, np.arange(1, _CORRECTED + 1))
    model = 2 * (luminance / mean) @ np.hstack([np.cos(angle), np.sin(angle)]) / len(angle)
    found = np.concatenate([traced.cosines, traced.sines])
    return np.append(traced.mean / mean, found - model)


def best_of(done: Sequence[Iteration], goal: Goal) -> Iteration:
    """Return the traced map that serves the goal best, by the upper end of its worst contrast."""

    def merit(one: Iteration) -> float:
        contrast = max(one.worst.contrast_high, goal.contrast_floor)
        return contrast - goal.luminance_weight * float(np.log(one.traced.mean))

    return min(done, key=merit)
