"""How the luminance over a pitch follows the inputs: each harmonic, linear or curved.

Harmonics are carried, not the contrast: that is a maximum less a minimum, and an optimised film
sits in its least, where errors of either sign raise it.
"""

from dataclasses import dataclass
from functools import cached_property

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
        """Return it less what the traces' noise adds to the power of its start, slopes and bends.

        A noisy curve is too large in the mean of squares by its variance: it would raise the
        contrasts, and widen those that the inputs give (James and Stein, "Estimation with quadratic
        loss", 1961). What is left in doubt never vanishes with it (`_doubt`).
        """
        start, covariance = shrink_each(self.start[None], self.start_covariance[None])
        return Response(
            start[0], covariance[0], *_shrink(self.slope, self.slope_covariance),
            *_shrink(self.bend, self.bend_covariance), self.basis,
        )  # fmt: skip

    def drawn(self, rng: np.random.Generator) -> "Response":
        """Return a response that the traces may stand for."""
        start, slope, bend = self._roots
        return Response(
            _draw(rng, self.start[None], start)[0], self.start_covariance,
            _draw(rng, self.slope, slope), self.slope_covariance,
            _draw(rng, self.bend, bend), self.bend_covariance, self.basis,
        )  # fmt: skip

    @cached_property
    def _roots(self) -> list[NDArray[np.float64]]:
        """What noise of start, slopes and bends is drawn with, of each (k, m, m)."""
        covariance = self.start_covariance[None], self.slope_covariance, self.bend_covariance
        return [_root(one) for one in covariance]

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
    kept = np.maximum(0.0, 1 - noise / power)
    root = np.sqrt(_doubt(1, effect**2 / np.where(noise > 0, noise, 1.0)))
    return effect * kept, covariance * root[:, :, None] * root[:, None, :]


def _shrink(
    effect: NDArray[np.float64], covariance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    power = np.sum(effect**2, axis=1)
    noise = np.trace(covariance, axis1=1, axis2=2)
    kept = np.where(power > 0, np.maximum(0.0, 1 - noise / np.where(power > 0, power, 1.0)), 0.0)
    # As many independent values as the noise has (Satterthwaite, 1946).
    values = noise**2 / np.maximum(np.sum(covariance**2, axis=(1, 2)), 1e-300)
    doubt = _doubt(values, values * power / np.where(noise > 0, noise, 1.0))
    return effect * kept[:, None], covariance * doubt[:, None, None]


def _doubt(values: NDArray[np.float64] | int, power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how much of the noise's variance is left in what may stand behind noisy values.

    power: |read|² of so many `values` in units of the noise. The truth is normal about 0 with a
    variance that is not known, so that the share κ of noise in what is read is as likely here as
    there in (0, 1) (Strawderman, "Proper Bayes minimax estimators of the multivariate normal mean",
    1971): the mean of 1 - κ. An effect that cannot be told from noise is not known to be none.
    """
    from scipy.special import gammainc

    a, s = np.asarray(values) / 2 + 1, np.maximum(power / 2, 1e-9)
    share: NDArray[np.float64] = 1 - a / s * gammainc(a + 1, s) / gammainc(a, s)
    return share


def _root(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    value, vector = np.linalg.eigh(covariance)
    return np.asarray(vector * np.sqrt(np.maximum(value, 0))[:, None, :])


def _draw(
    rng: np.random.Generator, mean: NDArray[np.float64], root: NDArray[np.float64]
) -> NDArray[np.float64]:
    noise = rng.standard_normal((*mean.shape, 1))
    return mean + (root @ noise)[..., 0]
