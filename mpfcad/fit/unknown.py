"""The values that a fit seeks: their priors, and steps in units of their standard uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import Factor, correlation
from mpfcad.errors import InputError

#: What is known of a value without prior, in its units of sigma: as good as nothing.
_FREE = 1e-6


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Values and what is known of them before the measurements.

    Attributes
    ----------
    factors
        each value with its standard uncertainty, in which steps are counted
    information
        (k, k) float64, inverse of the prior's covariance of the steps
    is_free, is_scale
        (k,) bool: has no prior; steps multiply it (a luminance), else they add
    """

    factors: tuple[Factor, ...]
    information: NDArray[np.float64]
    is_free: NDArray[np.bool_]
    is_scale: NDArray[np.bool_]

    @property
    def names(self) -> list[str]:
        """Names with unit suffix."""
        return [factor.name for factor in self.factors]

    @property
    def prior(self) -> NDArray[np.float64]:
        """The prior's covariance of the steps, (k, k); 1 for a value without prior."""
        held = self.information + np.diag(np.where(self.is_free, 1.0 - _FREE, 0.0))
        return np.linalg.inv(held)

    def limits(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the least and the largest step of each value, (k,)."""
        low = [-np.inf if s else (f.low - f.value) / f.sigma for f, s in self._each()]
        high = [np.inf if s else (f.high - f.value) / f.sigma for f, s in self._each()]
        return np.array(low), np.array(high)

    def values(self, steps: NDArray[np.float64]) -> dict[str, float]:
        """Return the values at steps (k,)."""
        found = {}
        for (f, scales), z in zip(self._each(), steps.tolist(), strict=True):
            found[f.name] = (
                f.value * float(np.exp(z * f.sigma / f.value)) if scales else f.value + z * f.sigma
            )
        return found

    def unit(self, steps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return by how much each value changes a step at steps (k,), (k,)."""
        values = self.values(steps)
        return np.array(
            [f.sigma * (values[f.name] / f.value if s else 1.0) for f, s in self._each()]
        )

    def _each(self) -> list[tuple[Factor, bool]]:
        return list(zip(self.factors, self.is_scale.tolist(), strict=True))


def build_unknowns(
    factors: list[Factor],
    free: set[str],
    scales: set[str],
    covariance: tuple[list[str], NDArray[np.float64]] | None = None,
) -> Unknowns:
    """Return the unknowns of factors whose sigmas are those of the covariance, where it has them.

    Raises
    ------
    InputError
        when correlations leave no prior.
    """
    is_free = np.array([f.name in free for f in factors], bool)
    matrix = correlation(factors, covariance)
    if np.linalg.eigvalsh(matrix)[0] <= 1e-9:
        raise InputError("covariance: not positive: expected correlations within -1 … 1")
    information: NDArray[np.float64] = np.asarray(np.linalg.inv(matrix), np.float64)
    information[is_free] = 0
    information[:, is_free] = 0
    information[is_free, is_free] = _FREE
    is_scale = np.array([f.name in scales for f in factors], bool)
    return Unknowns(tuple(factors), information, is_free, is_scale)
