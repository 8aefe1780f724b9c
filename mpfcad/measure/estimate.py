"""A figure with its 95 % interval, made from a standard error and its degrees of freedom.

Few replicates tell a standard error badly, so its multiple that holds 95 % is Student's t ("The
probable error of a mean", 1908), which L'Ecuyer, Nakayama, Owen and Tuffin ("Confidence intervals
for randomized quasi-Monte Carlo estimators", 2023) found to hold best for scrambled nets.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: What is left out on each side of a 95 % interval.
TAIL = 0.025


def reach(freedom: float = np.inf) -> float:
    """Return half a 95 % interval in standard errors of so many degrees of freedom."""
    from scipy.special import ndtri, stdtrit

    return float(ndtri(1 - TAIL) if np.isinf(freedom) else stdtrit(freedom, 1 - TAIL))


@dataclass(frozen=True)
class Estimate:
    """A figure with its 95 % interval [low, high] and standard error."""

    value: float
    low: float
    high: float
    standard_error: float

    @property
    def half_width(self) -> float:
        """Half the width of the 95 % interval."""
        return (self.high - self.low) / 2

    @classmethod
    def student(cls, value: float, standard_error: float, freedom: float) -> "Estimate":
        """Return the estimate of a figure whose error is known to so many degrees of freedom."""
        half = reach(freedom) * standard_error
        return cls(value, value - half, value + half, standard_error)

    def widened(self, error: float) -> "Estimate":
        """Return the estimate with an independent standard error more."""
        whole = float(np.hypot(self.standard_error, error))
        by = whole / self.standard_error if self.standard_error > 0 else 1.0
        low, high = (self.value + by * (end - self.value) for end in (self.low, self.high))
        return Estimate(self.value, low, high, whole)

    @classmethod
    def within(cls, value: float, low: float, high: float) -> "Estimate":
        """Return the estimate of a figure with its interval; its error is that of a normal one."""
        # Plain floats: numpy's compare to what no JSON holds.
        value, low, high = float(value), float(low), float(high)
        return cls(value, low, high, (high - low) / (2 * reach()))


def estimate_sum(
    weight: NDArray[np.float64],
    value: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float,
    *,
    own: bool = False,
) -> Estimate:
    """Return Σ weight · value of points with independent errors from so many blocks; all (p,).

    `own`: the errors come from each point's own blocks alone.
    """
    from mpfcad.optics.base.recorder import freedom_of_sum

    spread = float(np.sqrt(np.sum((weight * error) ** 2)))
    return Estimate.student(
        float(np.sum(weight * value)), spread, freedom_of_sum(weight, error, blocks, own=own)
    )


def wobble(rng: np.random.Generator, draws: int, freedom: float) -> NDArray[np.float64]:
    """Return what turns draws of normal noise into such of Student's t, (draws, 1): √(f/χ²)."""
    if np.isinf(freedom):
        return np.ones((draws, 1))
    return np.sqrt(freedom / rng.chisquare(freedom, (draws, 1)))
