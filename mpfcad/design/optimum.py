"""The best map by the model: a linear programme within a trust region, step after step.

Around a series c the model gives the luminance and its derivatives; the programme finds the step
with the least (Lmax - Lmin)/(2 Lmean), less `luminance_weight` times the gain of ln Lmean, over all
shifts of the film that have to be borne. Steps that make it worse by the model are halved
(sequential linear programming: Griffith and Stewart, "A nonlinear programming technique for the
optimization of continuous processing systems", 1961).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import Constraint, cosine_basis, limits, rounded
from mpfcad.design.response import Response

#: First trust region and the one at which the search ends [1/mm].
TRUST, SMALLEST = 10.0, 0.05
_STEPS = 40
#: Price of 1 /mm of a harmonic: where the contrast does not care, the map stays flat.
FLATNESS = 1e-6


@dataclass(frozen=True)
class Goal:
    """What is wanted of a map.

    Attributes
    ----------
    contrast_floor
        contrast below which nothing is gained: the luminance alone counts then
    luminance_weight
        worth of the relative mean luminance, in contrast
    registration
        shift of the film against the lamps that must be borne, either way [mm]
    """

    contrast_floor: float = 0.0
    luminance_weight: float = 0.0
    registration: float = 0.0


@dataclass(frozen=True, eq=False)
class Correction:
    """What full traces say of the model: L = scale · (model + mean · Σ relative_k cos 2πku).

    For a shifted film, Σ odd_k sin 2πku besides.

    Attributes
    ----------
    scale
        of the mean luminance
    relative
        (h,) float64, of harmonics 1 … h, in parts of the mean
    odd
        (h,) float64, likewise of the sines that a shift brings
    """

    scale: float
    relative: NDArray[np.float64]
    odd: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def none(cls) -> "Correction":
        """Return the correction of a model that is believed."""
        return cls(1.0, np.zeros(4))

    def apply(
        self,
        position: NDArray[np.float64],
        luminance: NDArray[np.float64],
        *,
        shifted: bool = False,
    ) -> NDArray[np.float64]:
        """Return the corrected luminance at positions in pitches, of a film in place or shifted."""
        error = cosine_basis(position, len(self.relative))[:, 1:] @ self.relative
        if shifted:
            angle = 2 * np.pi * np.outer(position, np.arange(1, len(self.odd) + 1))
            error += np.sin(angle) @ self.odd
        return self.scale * (luminance + luminance.mean() * error)


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the corrected model says of a series.

    Attributes
    ----------
    contrast
        worst lamp-Mura contrast over the shifts
    mean
        mean luminance [cd/m²]
    luminance
        (cells,) float64 [cd/m²] without a shift
    """

    contrast: float
    mean: float
    luminance: NDArray[np.float64]


def map_on_cells(
    series: NDArray[np.float64], response: Response, shift: float = 0.0
) -> NDArray[np.float64]:
    """Return C [1/mm] at the model's cells, of a film shifted by `shift` pitches."""
    return cosine_basis(response.grid.centre - shift, len(series) - 1) @ series


def predict(
    series: NDArray[np.float64],
    response: Response,
    correction: Correction,
    registration_pitch: float = 0.0,
) -> Prediction:
    """Return what the corrected model says of a series and of the film shifted."""
    curves = []
    for shift in _shifts(registration_pitch):
        luminance = response.luminance(map_on_cells(series, response, shift))
        centre = response.grid.centre
        curves.append(correction.apply(centre, luminance, shifted=shift != 0))
    worst = max(contrast_of(curve) for curve in curves)
    return Prediction(worst, float(curves[0].mean()), curves[0])


def contrast_of(luminance: NDArray[np.float64]) -> float:
    """Return (Lmax - Lmin)/(Lmax + Lmin) (Hsieh, MPF thesis, eq. 10)."""
    high, low = float(luminance.max()), float(luminance.min())
    return (high - low) / (high + low)


def find_optimum(
    start: NDArray[np.float64],
    response: Response,
    correction: Correction,
    constraint: Constraint,
    goal: Goal,
    pitch: float,
) -> NDArray[np.float64]:
    """Return the best series by the corrected model, from the series `start`; `pitch` in mm."""
    shift = goal.registration / pitch
    best, trust = start, TRUST
    merit = _merit(predict(best, response, correction, shift), goal)
    for _ in range(_STEPS):
        parts = [_linear(best, response, correction, s) for s in _shifts(shift)]
        while trust >= SMALLEST:
            trial = _step(best, parts, constraint, goal, pitch, trust)
            found = _merit(predict(trial, response, correction, shift), goal)
            if found < merit - 1e-6:
                break
            trust /= 2
        else:
            return best
        best, merit = trial, found
    return best


def _shifts(registration_pitch: float) -> tuple[float, ...]:
    """Return the shifts to be borne; the opposite one is the mirror image."""
    return (0.0, registration_pitch) if registration_pitch else (0.0,)


def _merit(prediction: Prediction, goal: Goal) -> float:
    contrast = max(prediction.contrast, goal.contrast_floor)
    return contrast - goal.luminance_weight * float(np.log(prediction.mean))


def _linear(
    series: NDArray[np.float64], response: Response, correction: Correction, shift: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return luminance over its mean (cells,), its derivative by the series, and ln mean's."""
    curvature = map_on_cells(series, response, shift)
    luminance, jacobian = response.jacobian(curvature, symmetric=shift == 0)
    slope = jacobian @ cosine_basis(response.grid.centre - shift, len(series) - 1)
    mean = luminance.mean()
    corrected = correction.apply(response.grid.centre, luminance, shifted=shift != 0)
    relative = corrected / (correction.scale * mean)
    gain = slope.mean(axis=0) / mean
    model = luminance / mean
    return relative, slope / mean - np.outer(model, gain), gain


def _step(
    series: NDArray[np.float64],
    parts: list,
    constraint: Constraint,
    goal: Goal,
    pitch: float,
    trust: float,
) -> NDArray[np.float64]:
    """Return the series after the best step within the trust region, by a linear programme.

    Unknowns: the step (h+1), |c_k| (h), then highest and lowest relative luminance of each shift,
    and the contrast.
    """
    from scipy.optimize import linprog

    count = len(series)
    size = 2 * count - 1 + 2 * len(parts) + 1
    rows, bound = [], []

    def add(blocks: list[tuple[int, NDArray[np.float64]]], limit: NDArray[np.float64]) -> None:
        row = np.zeros((len(limit), size))
        for first, block in blocks:
            row[:, first : first + block.shape[1]] = block
        rows.append(row)
        bound.append(limit)

    one = np.ones((1, 1))
    for i, (relative, slope, _) in enumerate(parts):
        top = 2 * count - 1 + 2 * i
        column = np.ones((len(relative), 1))
        add([(0, slope), (top, -column)], -relative)
        add([(0, -slope), (top + 1, column)], relative)
        add([(top, one / 2), (top + 1, -one / 2), (size - 1, -one)], np.zeros(1))
    matrix, limit = limits(constraint, pitch)
    add([(0, matrix)], limit - matrix @ series)
    harmonic = np.eye(count)[1:]
    absolute = np.eye(count - 1)
    add([(0, harmonic), (count, -absolute)], -series[1:])
    add([(0, -harmonic), (count, -absolute)], series[1:])
    cost = np.zeros(size)
    cost[:count] = -goal.luminance_weight * parts[0][2]
    cost[count : 2 * count - 1] = FLATNESS * np.arange(1, count)
    cost[-1] = 1.0
    bounds: list[tuple[float | None, float | None]] = [(-trust, trust)] * count + [(0, None)] * (
        count - 1
    )
    bounds += [(None, None)] * (2 * len(parts)) + [(goal.contrast_floor, None)]
    result = linprog(cost, np.concatenate(rows), np.concatenate(bound), bounds=bounds)
    return series if result.x is None else rounded(series + result.x[:count])
