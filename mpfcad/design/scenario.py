"""The map that is most likely within the limit over what is not known of film and backlight.

Draws of all inputs are scenarios of one programme. What the film's own inputs do (resin, place) is
told by the two-scale model for every map anew, at states that lie a step either way, quadratic
between; what the others do is added to each draw as it was traced. The share of draws within the
limit, smoothed, is raised step by step: each draw's contrast is linear within a trust region, and a
linear programme lowers them all, each weighted by how much it tells the share (a sampled chance
constraint: Nemirovski and Shapiro, "Convex approximations of chance constrained programs", 2006).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import Constraint, cosine_basis, limits, rounded
from mpfcad.design.optimum import FLATNESS, SMALLEST, TRUST, Correction
from mpfcad.design.response import HARMONICS, Response

#: Draws and places of the linear programme; the share is that of all draws at all places.
_DRAWS, _PLACES = 64, 32
_STEPS = 12
#: Softness of the limit in parts of it, first and last.
_SOFT = (0.4, 0.15)
_DIFFERENCE = 0.01


@dataclass(frozen=True)
class FilmState:
    """The film with one of its own inputs changed.

    Attributes
    ----------
    change
        curvature that is made of a curvature [1/mm], each (n,) float64; None: the same
    shift
        against the lamps, in pitches
    """

    change: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None
    shift: float = 0.0

    def made(self, curvature: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the curvature that is made [1/mm], (n,)."""
        return curvature if self.change is None else self.change(curvature)


@dataclass(frozen=True, eq=False)
class Scenarios:
    """Draws of what is not known.

    Attributes
    ----------
    states
        the film as designed, then with its own inputs changed
    even, odd
        (n, states) float64: what each state has of each draw's cosines, and of its sines
    rest
        (n, p) float64: what the other inputs add to the luminance over its mean
    position
        (p,) float64 [pitch], where the luminance is read
    limit
        of the contrast
    """

    states: tuple[FilmState, ...]
    even: NDArray[np.float64]
    odd: NDArray[np.float64]
    rest: NDArray[np.float64]
    position: NDArray[np.float64]
    limit: float

    def share(self, contrast: NDArray[np.float64], soft: float = 0.0) -> float:
        """Return the share of contrasts within the limit, smoothed by `soft` of the limit."""
        if soft == 0:
            return float(np.mean(contrast <= self.limit))
        return float(np.mean(self.within(contrast, soft)))

    def within(self, contrast: NDArray[np.float64], soft: float) -> NDArray[np.float64]:
        """Return how far contrasts are within the limit, 0 … 1, smoothed by `soft` of the limit."""
        from scipy.special import expit

        found: NDArray[np.float64] = expit((self.limit - contrast) / (soft * self.limit))
        return found


@dataclass(frozen=True, eq=False)
class _Told:
    """What the model says of a map in all states, with the derivatives by its series.

    Cosines and sines over the mean, (states, HARMONICS); their derivatives have the series last.
    """

    cosine: NDArray[np.float64]
    sine: NDArray[np.float64]
    cosine_slope: NDArray[np.float64] | None = None
    sine_slope: NDArray[np.float64] | None = None

    def curves(self, scenarios: Scenarios) -> NDArray[np.float64]:
        """Return each draw's luminance over its mean, (n, p)."""
        cosine, sine = _basis(scenarios.position)
        found = (scenarios.even @ self.cosine) @ cosine.T + (scenarios.odd @ self.sine) @ sine.T
        return 1 + found + scenarios.rest


def drawn_contrasts(
    series: NDArray[np.float64], response: Response, correction: Correction, scenarios: Scenarios
) -> NDArray[np.float64]:
    """Return a map's contrast in each draw by the corrected model, (n,)."""
    return _contrasts(_tell(series, response, correction, scenarios).curves(scenarios))


def find_likely(
    start: NDArray[np.float64],
    response: Response,
    correction: Correction,
    constraint: Constraint,
    scenarios: Scenarios,
    pitch: float,
) -> NDArray[np.float64]:
    """Return the series most likely within the limit, from the series `start`; `pitch` in mm."""
    best = start
    for soft in _SOFT:
        best = _climb(best, response, correction, constraint, scenarios, pitch, soft)
    return best


def _climb(
    best: NDArray[np.float64],
    response: Response,
    correction: Correction,
    constraint: Constraint,
    scenarios: Scenarios,
    pitch: float,
    soft: float,
) -> NDArray[np.float64]:
    def share_of(series: NDArray[np.float64]) -> float:
        contrast = drawn_contrasts(series, response, correction, scenarios)
        return scenarios.share(contrast, soft)

    share, trust = share_of(best), TRUST / 2
    for _ in range(_STEPS):
        told = _tell(best, response, correction, scenarios, slopes=True)
        while trust >= 4 * SMALLEST:
            trial = _step(best, told, constraint, scenarios, pitch, trust, soft)
            found = share_of(trial)
            if found > share + 1e-4:
                break
            trust /= 2
        else:
            return best
        best, share = trial, found
    return best


def _tell(
    series: NDArray[np.float64],
    response: Response,
    correction: Correction,
    scenarios: Scenarios,
    *,
    slopes: bool = False,
) -> _Told:
    """Return what the corrected model says of a map in all states."""
    centre = response.grid.centre
    cosine, sine = _basis(centre)
    weight = np.vstack([np.full(len(centre), 0.5), cosine.T, sine.T]) * 2 / len(centre)
    found, change = [], []
    for state in scenarios.states:
        basis = cosine_basis(centre - state.shift, len(series) - 1)
        meant = basis @ series
        made = state.made(meant)
        # A film that is not shifted is its own mirror image: it has no sines.
        rows = weight if state.shift else weight[: HARMONICS + 1]
        if not slopes:
            value = rows @ response.raw_luminance(made)
        else:
            luminance, by_cell = response.derivative(made, rows)
            value = rows @ luminance
            gain = (state.made(meant + _DIFFERENCE) - state.made(meant - _DIFFERENCE)) / (
                2 * _DIFFERENCE
            )
            slope = (by_cell * gain) @ basis
            slope = (slope[1:] - np.outer(value[1:] / value[0], slope[0])) / value[0]
            change.append(np.vstack([slope, np.zeros((2 * HARMONICS - len(slope), len(series)))]))
        relative = value[1:] / value[0]
        found.append(np.append(relative, np.zeros(2 * HARMONICS - len(relative))))
    both = np.array(found)
    known = correction.relative
    both[:, : len(known)] += known
    told = both[:, :HARMONICS], both[:, HARMONICS:]
    if not slopes:
        return _Told(*told)
    slope = np.array(change)
    return _Told(*told, slope[:, :HARMONICS], slope[:, HARMONICS:])


def _step(
    series: NDArray[np.float64],
    told: _Told,
    constraint: Constraint,
    scenarios: Scenarios,
    pitch: float,
    trust: float,
    soft: float,
) -> NDArray[np.float64]:
    """Return the series after the best step within the trust region, by a linear programme.

    Unknowns: the step (h+1), |c_k| (h), highest and lowest luminance of each draw.
    """
    from scipy.optimize import linprog
    from scipy.sparse import csr_array, vstack

    assert told.cosine_slope is not None and told.sine_slope is not None  # asked for above
    curve = told.curves(scenarios)
    near = scenarios.within(_contrasts(curve), soft)
    # Draws far within and far beyond the limit tell nothing of the share.
    tells = (near * (1 - near))[:_DRAWS] + 1e-6
    chosen = np.arange(len(tells))
    place = np.linspace(0, curve.shape[1], _PLACES, endpoint=False).astype(int)
    cosine, sine = _basis(scenarios.position[place])
    count, draws = len(series), len(chosen)
    size = 2 * count - 1 + 2 * draws
    high, low = 2 * count - 1 + np.arange(draws), 2 * count - 1 + draws + np.arange(draws)
    rows, bound = [], []
    for i in chosen:
        slope = cosine @ np.tensordot(scenarios.even[i], told.cosine_slope, 1)
        slope += sine @ np.tensordot(scenarios.odd[i], told.sine_slope, 1)
        for sign, at in ((1.0, high[i]), (-1.0, low[i])):
            block = np.zeros((len(place), size))
            block[:, :count], block[:, at] = sign * slope, -sign
            rows.append(csr_array(block))
            bound.append(-sign * curve[i, place])
    matrix, limit = limits(constraint, pitch)
    inside = np.zeros((len(matrix), size))
    inside[:, :count] = matrix
    flat = np.zeros((2 * (count - 1), size))
    for half, sign in enumerate((1.0, -1.0)):
        part = flat[half * (count - 1) : (half + 1) * (count - 1)]
        part[:, 1:count], part[:, count : 2 * count - 1] = (
            sign * np.eye(count - 1),
            -np.eye(count - 1),
        )
    rows += [csr_array(inside), csr_array(flat)]
    bound += [limit - matrix @ series, -series[1:], series[1:]]
    cost = np.zeros(size)
    cost[count : 2 * count - 1] = FLATNESS * np.arange(1, count)
    cost[high], cost[low] = tells / tells.sum() / 2, -tells / tells.sum() / 2
    bounds: list[tuple[float | None, float | None]] = [(-trust, trust)] * count
    bounds += [(0, None)] * (count - 1) + [(None, None)] * (2 * draws)
    result = linprog(cost, vstack(rows), np.concatenate(bound), bounds=bounds)
    return series if result.x is None else rounded(series + result.x[:count])


def _basis(position: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the harmonics' cosines and sines at positions [pitch], each (n, HARMONICS)."""
    angle = 2 * np.pi * np.outer(position, np.arange(1, HARMONICS + 1))
    return np.cos(angle), np.sin(angle)


def _contrasts(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    high, low = curve.max(axis=1), curve.min(axis=1)
    return (high - low) / (high + low)
