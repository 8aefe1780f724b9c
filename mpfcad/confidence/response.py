"""How the luminance over a pitch follows the inputs: each harmonic, linear or curved.

Harmonics are carried, not the contrast: that is a maximum less a minimum, and an optimised film
sits in its least, where errors of either sign raise it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Response:
    """Relative coefficients over the pitch as functions of the inputs' steps in sigma.

    y(z) = start + z·slope + Σ z²·bend of the curved inputs, each (m,) coefficient over the mean.

    Attributes
    ----------
    start, start_covariance
        (m,), (m, m) float64, as stated, from the film's own trace
    slope
        (k, m) float64, effect of one sigma of each input
    slope_covariance
        (k, m, m) float64
    bend, bend_covariance
        (k, m), (k, m, m) float64, 0 of an input without second order
    basis
        (n, m) float64, the coefficients' functions where the curve is read
    """

    start: NDArray[np.float64]
    start_covariance: NDArray[np.float64]
    slope: NDArray[np.float64]
    slope_covariance: NDArray[np.float64]
    bend: NDArray[np.float64]
    bend_covariance: NDArray[np.float64]
    basis: NDArray[np.float64]

    def shrunk(self) -> "Response":
        """Return it with slopes and bends less what the traces' noise adds to their power.

        A noisy effect is too large in the mean of squares by its variance: it would widen the
        contrasts that the inputs give (James and Stein, "Estimation with quadratic loss", 1961).
        """
        return Response(
            self.start, self.start_covariance, *_shrink(self.slope, self.slope_covariance),
            *_shrink(self.bend, self.bend_covariance), self.basis,
        )  # fmt: skip

    def drawn(self, rng: np.random.Generator) -> "Response":
        """Return a response that the traces may stand for."""
        start = _draw(rng, self.start[None], self.start_covariance[None])[0]
        return Response(
            start, self.start_covariance, _draw(rng, self.slope, self.slope_covariance),
            self.slope_covariance, _draw(rng, self.bend, self.bend_covariance),
            self.bend_covariance, self.basis,
        )  # fmt: skip

    def contrast(self, steps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the contrasts of steps (n, k), (n,)."""
        found = self.start + steps @ self.slope + steps**2 @ self.bend
        curve = 1 + found @ self.basis.T
        high, low = curve.max(axis=1), curve.min(axis=1)
        return (high - low) / (high + low)


def fit_slopes(
    steps: NDArray[np.float64], found: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return slopes (k, m) and their covariances (k, m, m) of runs' steps (n, k), found (n, m)."""
    design = np.column_stack([np.ones(len(steps)), steps])
    inverse = np.linalg.inv(design.T @ design)
    coefficient = inverse @ design.T @ found
    rest = found - design @ coefficient
    scatter = rest.T @ rest / (len(steps) - design.shape[1])
    return coefficient[1:], np.diag(inverse)[1:, None, None] * scatter


def shrink_each(
    effect: NDArray[np.float64], covariance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return effects (k, m) with each coefficient's own noise taken off, and their covariances.

    For harmonics, of which an effect has few: taken off together, the noise of those that it does
    not have would take the effect with it.
    """
    noise = np.diagonal(covariance, axis1=1, axis2=2)
    power = np.where(effect == 0, 1.0, effect**2)
    kept = np.maximum(0.0, 1 - noise / power) * (effect != 0)
    root = np.sqrt(kept)
    return effect * kept, covariance * root[:, :, None] * root[:, None, :]


def _shrink(
    effect: NDArray[np.float64], covariance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    power = np.sum(effect**2, axis=1)
    noise = np.trace(covariance, axis1=1, axis2=2)
    kept = np.where(power > 0, np.maximum(0.0, 1 - noise / np.where(power > 0, power, 1.0)), 0.0)
    return effect * kept[:, None], covariance * kept[:, None, None]


def _draw(
    rng: np.random.Generator, mean: NDArray[np.float64], covariance: NDArray[np.float64]
) -> NDArray[np.float64]:
    value, vector = np.linalg.eigh(covariance)
    root = vector * np.sqrt(np.maximum(value, 0))[:, None, :]
    noise = rng.standard_normal((*mean.shape, 1))
    return mean + (root @ noise)[..., 0]
