"""What is read off the traces of one view, as a straight line in the values' steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


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
    inverse, scatter
        (k, k), (m, m) float64: the slopes' covariance is their product
    bow
        (m,) float64: by how much runs a step away in all values lie off the line in the mean
    """

    at: NDArray[np.float64]
    start: NDArray[np.float64]
    start_covariance: NDArray[np.float64]
    slope: NDArray[np.float64]
    inverse: NDArray[np.float64]
    scatter: NDArray[np.float64]
    bow: NDArray[np.float64]

    def reading(self, steps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the readings at steps (k,), (m,)."""
        found: NDArray[np.float64] = self.start + (steps - self.at) @ self.slope
        return found

    def noise(
        self, steps: NDArray[np.float64], covariance: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the covariance (m, m) of the readings over values known to a covariance (k, k).

        Of the trace at the middle, of the slopes over so wide a range, and of what is not straight.
        """
        away = steps - self.at
        wide = float(np.sum(self.inverse * (covariance + np.outer(away, away))))
        return self.start_covariance + wide * self.scatter + np.outer(self.bow, self.bow)


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
    share, and what is not straight.
    """
    away = (steps - at)[:, is_active]
    design = np.column_stack([np.ones(len(away)), away])
    inverse = np.linalg.inv(design.T @ design)
    coefficient = inverse @ design.T @ found
    rest = found - design @ coefficient
    scatter = rest.T @ rest / max(1, len(steps) - design.shape[1])
    k, m = steps.shape[1], found.shape[1]
    slope, wide = np.zeros((k, m)), np.zeros((k, k))
    slope[is_active] = coefficient[1:]
    wide[np.ix_(is_active, is_active)] = inverse[1:, 1:]
    square = np.mean(np.sum(away**2, axis=1)) / max(1, away.shape[1])
    bow = (coefficient[0] - start) / max(float(square), 1.0)
    noise = np.diag(start_covariance) + np.diag(scatter) * inverse[0, 0]
    # What the noise of both may have made is no bow (James and Stein, 1961).
    kept = np.maximum(0.0, 1 - noise / np.where(bow == 0, 1.0, bow**2))
    return Line(at, start, start_covariance, slope, wide, scatter, bow * kept)
