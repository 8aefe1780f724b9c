"""The Fourier series over the lamp pitch that luminances with standard errors follow."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.estimate import Estimate, estimate_sum

_HARMONICS = (4, 6, 8, 10, 12)


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
    luminance, error
        (n,) float64 [cd/m²], the points and their standard errors
    gain
        (1+2h, n) float64: coefficient = gain · luminance
    blocks
        of paths, that the errors come from
    """

    coefficient: NDArray[np.float64]
    covariance: NDArray[np.float64]
    chi2_excess: float
    luminance: NDArray[np.float64]
    error: NDArray[np.float64]
    gain: NDArray[np.float64]
    blocks: float

    @property
    def harmonics(self) -> int:
        """Number of harmonics h."""
        return (len(self.coefficient) - 1) // 2

    @property
    def mean(self) -> Estimate:
        """The mean luminance [cd/m²] over the pitch."""
        return self.amplitude(0)

    def amplitude(self, number: int) -> Estimate:
        """Return one coefficient [cd/m²]."""
        return self.sum(np.eye(len(self.coefficient))[number])

    def at(self, position: float) -> Estimate:
        """Return the fitted luminance [cd/m²] at a position in pitches."""
        return self.sum(basis(np.array([position]), self.harmonics)[0])

    def sum(self, weight: NDArray[np.float64]) -> Estimate:
        """Return Σ weight · coefficient [cd/m²], weight (1+2h,)."""
        return estimate_sum(weight @ self.gain, self.luminance, self.error, self.blocks)

    def freedom(self, weight: NDArray[np.float64]) -> float:
        """Return the degrees of freedom of the error of Σ weight · coefficient."""
        from mpfcad.optics.base.recorder import freedom_of_sum

        return freedom_of_sum(weight @ self.gain, self.error, self.blocks)

    def curve(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fitted luminance [cd/m²] at positions in pitches."""
        return basis(position, self.harmonics) @ self.coefficient


def basis(position: NDArray[np.float64], harmonics: int) -> NDArray[np.float64]:
    """Return 1, cos 2πu, sin 2πu, cos 4πu … at u, (n, 1+2h) float64."""
    columns = [np.ones_like(position)]
    for h in range(1, harmonics + 1):
        columns += [np.cos(2 * np.pi * h * position), np.sin(2 * np.pi * h * position)]
    return np.stack(columns, axis=1)


def fit_harmonics(
    position: NDArray[np.float64],
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
) -> HarmonicFit:
    """Return the weighted least-squares Fourier series through luminances over a pitch.

    Parameters
    ----------
    position
        (n,) float64, in pitches
    luminance, error
        (n,) float64 [cd/m²], value and standard error
    blocks
        of paths, that the errors come from; inf: they are known

    The fewest of 4, 6, 8, 10, 12 harmonics that leave no residual beyond noise are taken, so that a
    curve with sharp features is not smoothed flat: χ² within 3σ of its expectation, or, where the
    errors themselves are uncertain, within what is as improbable of Fisher's F.
    """
    weight = 1 / np.maximum(error, 1e-12 * np.abs(luminance).max() + 1e-300)
    for harmonics in _HARMONICS:
        scaled = basis(position, harmonics) * weight[:, None]
        covariance = np.linalg.inv(scaled.T @ scaled)
        gain = covariance @ (scaled * weight[:, None]).T
        coefficient = covariance @ (scaled.T @ (luminance * weight))
        chi2 = float(np.sum((luminance * weight - scaled @ coefficient) ** 2))
        freedom = len(position) - scaled.shape[1]
        excess = (chi2 - freedom) / np.sqrt(2 * freedom)
        if _is_noise(chi2, freedom, error, blocks):
            break
    return HarmonicFit(
        coefficient, covariance, float(excess), luminance, error, gain, blocks
    )  # fmt: skip


def _is_noise(chi2: float, freedom: int, error: NDArray[np.float64], blocks: float) -> bool:
    """Return whether χ² is no less probable than one 3σ above its expectation."""
    from scipy.special import chdtrc, fdtrc

    from mpfcad.optics.base.recorder import freedom_of_sum

    of_errors = freedom_of_sum(1 / np.maximum(error, 1e-300), error, blocks)
    limit = freedom + 3 * np.sqrt(2 * freedom)
    if np.isinf(of_errors):
        return bool(chi2 <= limit)
    return bool(fdtrc(freedom, of_errors, chi2 / freedom) >= chdtrc(freedom, limit))
