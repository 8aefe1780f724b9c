"""What is read off the traces of one view, as a straight line in the values' steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_EPSILON, _TINY = float(np.finfo(float).eps), 1e-280


@dataclass(frozen=True, eq=False)
class Line:
    """Readings y(z) = start + (z - at)·slope of a view, and what is not known of them.

    Attributes
    ----------
    at
        (k,) float64, steps about which they were traced
    start, start_covariance
        (m,), (m, m) float64, there, from a trace of its own
    slope
        (k, m) float64, 0 of a value that the view does not depend on
    slope_covariance
        (m, k, k) float64, of each reading's slopes
    bow
        (m,) float64: by how much runs a step away in all values lie off the line in the mean
    rest
        (n, m) float64: by how much each run lies off it
    """

    at: NDArray[np.float64]
    start: NDArray[np.float64]
    start_covariance: NDArray[np.float64]
    slope: NDArray[np.float64]
    slope_covariance: NDArray[np.float64]
    bow: NDArray[np.float64]
    rest: NDArray[np.float64]

    def reading(self, steps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the readings at steps (k,), (m,)."""
        found: NDArray[np.float64] = self.start + (steps - self.at) @ self.slope
        return found

    def spread(
        self, steps: NDArray[np.float64], covariance: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return each reading's variance (m,) by its slopes, over values known to (k, k)."""
        away = steps - self.at
        over = covariance + np.outer(away, away)
        found: NDArray[np.float64] = np.sum(self.slope_covariance * over, axis=(1, 2))
        return found


def noise_of_lines(
    lines: list[Line], steps: NDArray[np.float64], covariance: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the covariance of the readings of lines side by side, over values known to (k, k).

    Of the traces at the middle, of the slopes over so wide a range, and of what is not straight.
    The lines' runs changed the values alike: what lies off a line in one lies off in the other too,
    and drops out of their ratio.
    """
    from scipy.linalg import block_diag

    rest = np.hstack([line.rest for line in lines])
    size = np.sqrt(np.sum(rest**2, axis=0))
    together = rest.T @ rest / np.outer(np.where(size > 0, size, 1), np.where(size > 0, size, 1))
    wide = np.sqrt(np.concatenate([line.spread(steps, covariance) for line in lines]))
    bow = np.concatenate([line.bow for line in lines])
    found: NDArray[np.float64] = block_diag(*[line.start_covariance for line in lines])
    return found + together * np.outer(wide, wide) + np.outer(bow, bow)


def flat_line(
    at: NDArray[np.float64],
    runs: int,
    start: NDArray[np.float64],
    start_covariance: NDArray[np.float64],
) -> Line:
    """Return the line of a view that depends on none of the values, beside lines of `runs`."""
    k, m = len(at), len(start)
    none = np.zeros((k, m)), np.zeros((m, k, k)), np.zeros(m), np.zeros((runs, m))
    return Line(at, start, start_covariance, *none)


def fit_line(
    at: NDArray[np.float64],
    steps: NDArray[np.float64],
    found: NDArray[np.float64],
    start: NDArray[np.float64],
    start_covariance: NDArray[np.float64],
    is_active: NDArray[np.bool_],
) -> Line:
    """Return the line through runs at steps (n, k) that read (n, m), by least squares.

    `is_active` (k,): which values the view depends on; the others have no slope, and no noise.
    All runs share their random numbers, so the scatter about the line is what noise they do not
    share, and what is not straight. Slopes of a reading are taken as of one size, which the runs
    tell, and drawn towards 0 as far as noise may have made them (Efron and Morris, "Stein's
    estimation rule and its competitors", 1973): so noise is not taken for knowledge.
    """
    away = (steps - at)[:, is_active]
    middle = away.mean(axis=0)
    inner = (away - middle).T @ (away - middle)
    mean = found.mean(axis=0)
    raw = np.linalg.solve(inner, (away - middle).T @ (found - mean))
    rest = found - mean - (away - middle) @ raw
    scatter = np.sum(rest**2, axis=0) / max(1, len(steps) - away.shape[1] - 1)
    # Exactly straight readings are known to their last bit, no better.
    scatter = np.maximum(scatter, (_EPSILON * np.abs(found).max(axis=0)) ** 2 + _TINY)
    k, m = steps.shape[1], found.shape[1]
    slope, spread = np.zeros((k, m)), np.zeros((m, k, k))
    part = np.ix_(is_active, is_active)
    for j in range(m):
        size = _size(raw[:, j], inner, float(scatter[j]))
        ridge = np.linalg.inv(inner / scatter[j] + np.eye(len(inner)) / size)
        slope[is_active, j] = ridge @ (inner / scatter[j]) @ raw[:, j]
        spread[j][part] = ridge
    square = float(np.mean(away**2))
    bow = (mean - middle @ slope[is_active] - start) / max(square, 1.0)
    noise = np.diag(start_covariance) + scatter / len(steps)
    # What the noise of both may have made is no bow (James and Stein, 1961).
    kept = np.maximum(0.0, 1 - noise / np.where(bow == 0, 1.0, bow**2))
    return Line(at, start, start_covariance, slope, spread, bow * kept, rest)


def _size(slope: NDArray[np.float64], inner: NDArray[np.float64], scatter: float) -> float:
    """Return the mean square of the true slopes (k,), at least what their noise may hide."""
    count, weight = len(slope), float(np.trace(inner))
    power = float(slope @ inner @ slope) - count * scatter
    return max(power, scatter * float(np.sqrt(2 * count))) / weight
