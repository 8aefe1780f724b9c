"""What measurements say of the values: least squares with the prior, and the covariance left."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.fit.datum import Datum, Figured
from mpfcad.fit.linear import Line
from mpfcad.fit.unknown import Unknowns
from mpfcad.measure.estimate import reach

Lines = dict[tuple[str, str], Line]
#: The traces' noise depends on the widths that are left: found in so many rounds.
_ROUNDS = 4
#: Steps [sigma] away from the lines' middle within which values are sought, and over which the
#: traces' noise is taken where nothing holds a value: the lines were traced no wider.
_REACH, _WIDEST = 3.0, 1.5
#: Backlights drawn for a figure's interval: each end is read off fifty of them.
_DRAWS = 2000


@dataclass(frozen=True, eq=False)
class Posterior:
    """Values and what is left uncertain of them.

    Attributes
    ----------
    steps
        (k,) float64, from the prior's values in units of their sigma
    covariance
        (k, k) float64, of the steps
    weights
        of each datum, its covariance (d, d): of measurement and traces
    chi2, freedom
        of data and prior at the steps; numbers measured, without the limits that are kept
    """

    steps: NDArray[np.float64]
    covariance: NDArray[np.float64]
    weights: list[NDArray[np.float64]]
    chi2: float
    freedom: int

    def predicted(
        self, figured: Figured, lines: Lines
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return a figure (d,), its covariance by values and traces, and by the traces alone."""
        value = figured.predict(lines, self.steps)
        slope = figured.jacobian(lines, self.steps)
        noise = noise_of(figured, lines, self.steps, self.covariance)
        return value, slope @ self.covariance @ slope.T + noise, noise

    def interval(self, figured: Figured, lines: Lines) -> tuple[NDArray[np.float64], ...]:
        """Return the two ends of a figure's 95 % interval, (d,) each, of backlights drawn.

        Noise raises a contrast, so the lower end of what is never negative is no higher than that
        of the straight line, and not below 0.
        """
        value, spread, _ = self.predicted(figured, lines)
        within = _within(self.covariance)
        drawn = figured.drawn(lines, self.steps, self.covariance, within, _DRAWS)
        low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
        straight = value - reach() * np.sqrt(np.diag(spread))
        return np.where(straight < low, np.maximum(straight, 0.0), low), high


def fit_values(lines: Lines, data: list[Datum], unknowns: Unknowns) -> Posterior:
    """Return the values that data and prior hold, by Levenberg and Marquardt on straight readings.

    The traces' noise, of the slopes too over what is left of the values, stands in each datum's
    covariance.
    """
    covariance = unknowns.prior
    middle = next((line.at for line in lines.values()), np.zeros(len(unknowns.factors)))
    steps = middle
    for _ in range(_ROUNDS):
        weights = [d.covariance + noise_of(d.figured, lines, steps, covariance) for d in data]
        steps = _solve(lines, data, weights, unknowns, middle)
        known = unknowns.information + _information(lines, data, weights, steps)
        covariance = np.asarray(np.linalg.inv(known), np.float64)
    whiten = [np.linalg.inv(np.linalg.cholesky(weight)) for weight in weights]
    off = _residuals(lines, data, whiten, steps)
    counted = sum(len(d.value) for d in data if d.side == 0 or np.any(d.off(
        d.figured.predict(lines, steps))))  # fmt: skip
    chi2 = float(off @ off + steps @ unknowns.information @ steps)
    return Posterior(steps, covariance, weights, chi2, counted)


def noise_of(
    figured: Figured, lines: Lines, steps: NDArray[np.float64], covariance: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the covariance (d, d) that the traces leave of a figure, over what is left."""
    return figured.noise(lines, steps, _within(covariance))


def _within(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a covariance of steps, no wider than the lines were traced."""
    value, vector = np.linalg.eigh(covariance)
    found: NDArray[np.float64] = (vector * np.minimum(value, _WIDEST**2)) @ vector.T
    return found


def _solve(
    lines: Lines,
    data: list[Datum],
    weights: list[NDArray[np.float64]],
    unknowns: Unknowns,
    start: NDArray[np.float64],
) -> NDArray[np.float64]:
    from scipy.optimize import least_squares

    root = np.linalg.cholesky(unknowns.information).T
    whiten = [np.linalg.inv(np.linalg.cholesky(weight)) for weight in weights]
    low, high = unknowns.limits()
    low, high = np.maximum(low, start - _REACH), np.minimum(high, start + _REACH)

    def residual(steps: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.r_[_residuals(lines, data, whiten, steps), root @ steps]

    inside = np.clip(start, low + 1e-6, high - 1e-6)
    found = least_squares(residual, inside, bounds=(low, high), x_scale=1.0, diff_step=1e-4,
                          xtol=1e-10, ftol=1e-10, gtol=1e-10)  # fmt: skip
    steps: NDArray[np.float64] = found.x
    return steps


def _residuals(
    lines: Lines,
    data: list[Datum],
    whiten: list[NDArray[np.float64]],
    steps: NDArray[np.float64],
) -> NDArray[np.float64]:
    parts = [w @ d.off(d.figured.predict(lines, steps)) for d, w in zip(data, whiten, strict=True)]
    return np.concatenate(parts) if parts else np.zeros(0)


def _information(
    lines: Lines,
    data: list[Datum],
    weights: list[NDArray[np.float64]],
    steps: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return what the data say of the steps, (k, k)."""
    k = len(steps)
    total = np.zeros((k, k))
    for datum, weight in zip(data, weights, strict=True):
        if datum.side and not np.any(datum.off(datum.figured.predict(lines, steps))):
            continue
        total += information_of(datum.figured, weight, lines, steps)
    return total


def information_of(
    figured: Figured, weight: NDArray[np.float64], lines: Lines, steps: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return JᵀW⁻¹J of a figure, (k, k)."""
    slope = figured.jacobian(lines, steps)
    found: NDArray[np.float64] = slope.T @ np.linalg.solve(weight, slope)
    return found
