"""Lamp-Mura contrast from noisy luminances, without the bias of a noisy maximum and minimum.

Contrast is (Lmax - Lmin)/(Lmax + Lmin) over one lamp pitch (Hsieh, MPF thesis, eq. 10). Maximum and
minimum of 33 noisy points overstate it by about two standard errors. Here the curve is a Fourier
series of the pitch fitted to all points; what bias is left in the fitted curve's contrast is taken
out by asking which amplitude of that same curve, with noise of the fit's covariance added, gives
the contrast read as its median (estimate), 97.5th and 2.5th percentile (ends of the 95 % interval).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_HARMONICS = (4, 6, 8, 10, 12)
_DRAWS = 2000
_FINE = 257
_STEPS = 40


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
    def normal(cls, value: float, standard_error: float) -> "Estimate":
        """Return the estimate of a normally distributed figure."""
        half = 1.959963984540054 * standard_error
        return cls(value, value - half, value + half, standard_error)


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """A Fourier series over the pitch, fitted to luminances.

    Attributes
    ----------
    coefficient
        (1+2h,) float64 [cd/m²]: mean, then cosine and sine of each of h harmonics
    covariance
        (1+2h, 1+2h) float64, of the coefficients, from the points' standard errors
    chi2_excess
        (χ² - degrees of freedom)/√(2·degrees of freedom) of the fit
    """

    coefficient: NDArray[np.float64]
    covariance: NDArray[np.float64]
    chi2_excess: float

    @property
    def harmonics(self) -> int:
        """Number of harmonics h."""
        return (len(self.coefficient) - 1) // 2

    def curve(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fitted luminance [cd/m²] at positions in pitches."""
        return _basis(position, self.harmonics) @ self.coefficient


def _basis(position: NDArray[np.float64], harmonics: int) -> NDArray[np.float64]:
    """Return 1, cos 2πu, sin 2πu, cos 4πu … at u, (n, 1+2h) float64."""
    columns = [np.ones_like(position)]
    for h in range(1, harmonics + 1):
        columns += [np.cos(2 * np.pi * h * position), np.sin(2 * np.pi * h * position)]
    return np.stack(columns, axis=1)


def fit_harmonics(
    position: NDArray[np.float64], luminance: NDArray[np.float64], error: NDArray[np.float64]
) -> HarmonicFit:
    """Return the weighted least-squares Fourier series through luminances over a pitch.

    Parameters
    ----------
    position
        (n,) float64, in pitches
    luminance, error
        (n,) float64 [cd/m²], value and standard error

    The fewest of 4, 6, 8, 10, 12 harmonics that leave no residual beyond noise (χ² within 3σ of its
    expectation) are taken, so that a curve with sharp features is not smoothed flat.
    """
    weight = 1 / np.maximum(error, 1e-12 * np.abs(luminance).max() + 1e-300)
    for harmonics in _HARMONICS:
        basis = _basis(position, harmonics) * weight[:, None]
        covariance = np.linalg.inv(basis.T @ basis)
        coefficient = covariance @ (basis.T @ (luminance * weight))
        residual = luminance * weight - basis @ coefficient
        freedom = len(position) - basis.shape[1]
        excess = float((residual @ residual - freedom) / np.sqrt(2 * freedom))
        if excess <= 3:
            break
    return HarmonicFit(coefficient, covariance, excess)


def contrast_of_harmonics(fit: HarmonicFit, seed: int = 0) -> Estimate:
    """Return the lamp-Mura contrast of a fitted curve, median-unbiased, with its 95 % interval.

    The noise draws are fixed by `seed`; the result is deterministic.
    """
    fine = np.linspace(0, 1, _FINE)[:-1]
    basis = _basis(fine, fit.harmonics)
    curve = basis @ fit.coefficient
    mean = fit.coefficient[0]
    shape = curve - mean
    read = _contrast(curve)
    rng = np.random.Generator(np.random.Philox(seed))
    root = np.linalg.cholesky(fit.covariance)
    noise = rng.standard_normal((_DRAWS, len(fit.coefficient))) @ root.T @ basis.T

    def share_below(scale: float) -> float:
        """Return the share of draws about the scaled curve that read less contrast than seen."""
        return float(np.mean(_contrast(mean + scale * shape + noise) < read))

    def scale_where(share: float) -> float:
        low, high = 0.0, 1.0
        if share_below(0.0) <= share:
            return 0.0
        while share_below(high) > share:
            high *= 2
        for _ in range(_STEPS):
            middle = (low + high) / 2
            low, high = (middle, high) if share_below(middle) > share else (low, middle)
        return high

    value, lower, upper = (
        float(_contrast(mean + scale_where(share) * shape)) for share in (0.5, 0.975, 0.025)
    )
    return Estimate(value, lower, upper, (upper - lower) / (2 * 1.959963984540054))


def _contrast(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (max - min)/(max + min) over the last axis."""
    high, low = curve.max(axis=-1), curve.min(axis=-1)
    return (high - low) / (high + low)
