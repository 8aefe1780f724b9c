"""Response surfaces: how mean luminance and its harmonics over a pitch follow the assumed values.

Harmonics are smooth in the values where the contrast, a maximum less a minimum, is not; and a
regression over all trials averages the noise that each trace has.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

HARMONICS = 4
_PHASE = np.arange(129) / 256
_COSINES = np.cos(2 * np.pi * np.arange(1, HARMONICS + 1) * _PHASE[:, None])


def read_curve(luminance: NDArray[np.float64], error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (log mean, cosine amplitudes over the mean) of luminances over a pitch, (5,).

    The row of lamps and a uniform film are mirror-symmetric, so sines are noise and left out.
    """
    u = np.linspace(0, 1, len(luminance))
    basis = np.cos(2 * np.pi * np.arange(HARMONICS + 1) * u[:, None])
    weight = 1 / error
    found, *_ = np.linalg.lstsq(basis * weight[:, None], luminance * weight, rcond=None)
    return np.r_[np.log(found[0]), found[1:] / found[0]]


def contrast(amplitude: NDArray[np.float64]) -> float:
    """Return (Lmax - Lmin)/(Lmax + Lmin) of 1 + Σ a_h cos 2πhu (Hsieh, MPF thesis, eq. 10)."""
    curve = 1 + _COSINES @ amplitude
    return float((curve.max() - curve.min()) / (curve.max() + curve.min()))


@dataclass(frozen=True, eq=False)
class Surface:
    """A polynomial in curvature whose every coefficient is linear in the codes, plus one bow.

    Attributes
    ----------
    degree
        of the polynomial in (C - 65)/15
    coefficient
        (terms, 5) float64
    covariance
        (terms, terms) float64 for unit variance; `variance` (5,) multiplies it
    misfit
        (5,) standard deviation of the residuals over that of the traces' own noise
    """

    degree: int
    coefficient: NDArray[np.float64]
    covariance: NDArray[np.float64]
    variance: NDArray[np.float64]
    misfit: NDArray[np.float64]

    def __call__(self, code: NDArray[np.float64], curvature: float) -> NDArray[np.float64]:
        """Return (log mean, amplitudes) at codes (k,) and a curvature, (5,)."""
        return _terms(code[None], np.array([curvature]), self.degree)[0] @ self.coefficient

    def anchored(
        self,
        code: NDArray[np.float64],
        curvature: NDArray[np.float64],
        reading: NDArray[np.float64],
    ) -> "Surface":
        """Return the surface with its log luminance moved to pass through readings at one place.

        Arrays as in `fit_surface`; the move is a polynomial in curvature of the surface's degree.
        Luminance bends by more than its noise; the harmonics do not, and the regression over all
        trials knows them better than a few traces at one place do.
        """
        left = (reading - _terms(code, curvature, self.degree) @ self.coefficient)[:, 0]
        power = _powers(curvature, self.degree)
        moved = self.coefficient.copy()
        moved[: self.degree + 1, 0] += np.linalg.lstsq(power, left, rcond=None)[0]
        return replace(self, coefficient=moved)

    def draws(self, count: int, seed: int) -> list["Surface"]:
        """Return surfaces drawn with the regression's uncertainty."""
        rng = np.random.Generator(np.random.Philox(seed))
        root = np.linalg.cholesky(self.covariance)
        shape = (count, *self.coefficient.shape)
        noise = root @ rng.standard_normal(shape) * np.sqrt(self.variance)
        return [replace(self, coefficient=self.coefficient + n) for n in noise]


def fit_surface(
    code: NDArray[np.float64],
    curvature: NDArray[np.float64],
    reading: NDArray[np.float64],
    noise: float,
) -> Surface:
    """Return the least-squares surface through readings.

    Parameters
    ----------
    code, curvature, reading
        (n, k), (n,) and (n, 5) float64 of the trials
    noise
        standard error of one reading's amplitude from its trace; the variance taken is that of the
        residuals, so what the polynomial cannot follow counts as noise too
    """
    degree = min(2, len(np.unique(curvature)) - 1)
    terms = _terms(code, curvature, degree)
    inverse = np.linalg.inv(terms.T @ terms)
    coefficient = inverse @ terms.T @ reading
    left = reading - terms @ coefficient
    variance = (left**2).sum(0) / max(1, len(reading) - terms.shape[1])
    scale = np.r_[noise / np.sqrt(2), np.full(HARMONICS, noise)]
    return Surface(degree, coefficient, inverse, variance, np.sqrt(variance) / scale)


def _terms(code: NDArray, curvature: NDArray, degree: int) -> NDArray[np.float64]:
    """Return the polynomial's columns, (n, degree + 2 + k · max(1, degree)).

    Codes multiply every power of the curvature but the highest. The bow is the mean square code:
    two levels a factor cannot say which of the factors bends.
    """
    power = _powers(curvature, degree)
    columns = [power]
    columns += [code * power[:, [n]] for n in range(max(1, degree))]
    columns.append((code**2).mean(1, keepdims=True))
    return np.concatenate(columns, axis=1)


def _powers(curvature: NDArray, degree: int) -> NDArray[np.float64]:
    return ((curvature[:, None] - 65) / 15) ** np.arange(degree + 1)
