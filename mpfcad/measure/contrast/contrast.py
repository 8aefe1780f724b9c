"""Lamp-Mura contrast from noisy luminances, without the bias of a noisy maximum and minimum.

Contrast is (Lmax - Lmin)/(Lmax + Lmin) over one lamp pitch (Hsieh, MPF thesis, eq. 10). Maximum and
minimum of 33 noisy points overstate it by about two standard errors. Here the curve is a Fourier
series of the pitch fitted to all points; what bias is left in the fitted curve's contrast is taken
out by asking which true contrast gives, with noise of the fit's covariance, the contrast read as
its median (estimate), 97.5th and 2.5th percentile (ends of the 95 % interval). The answer depends
on the curve's shape, which is known only as well as the fit: each draw has a shape of its own.
"""

from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.fit import HarmonicFit, basis
from mpfcad.measure.estimate import TAIL, Estimate, wobble

_DRAWS = 2000
_POINTS_A_HARMONIC = 32
_GRID = 17
_STEPS = 1024
_NORMAL = NormalDist()


def contrast_of_harmonics(
    fit: HarmonicFit, seed: int = 0, *, points: int | None = None
) -> Estimate:
    """Return the lamp-Mura contrast of a fitted curve, median-unbiased, with its 95 % interval.

    `points`: the curve is read at so many, from one lamp to the next, both included; None for
    everywhere. The noise draws are fixed by `seed`; the result is deterministic.
    """
    fine = _POINTS_A_HARMONIC * fit.harmonics
    position = np.arange(fine) / fine if points is None else np.linspace(0, 1, points)
    reader = _Reader.of(fit, position)
    rng = np.random.Generator(np.random.Philox(seed))
    root = np.linalg.cholesky(fit.covariance)
    noise, other = (rng.standard_normal((_DRAWS, len(fit.coefficient))) @ root.T for _ in range(2))
    # What the reading's error is known to: that of the difference of its two ends.
    high, low = reader.places(fit.coefficient[None])[:, 0]
    noise *= wobble(rng, _DRAWS, fit.freedom(high - low))
    shape = _plausible_shapes(fit, other, rng)
    curve = shape @ reader.at.T
    ends = curve.max(axis=1), curve.min(axis=1)
    level = np.zeros_like(fit.coefficient)
    level[0] = fit.coefficient[0]
    return unbiased(reader.contrast, fit.coefficient, level, shape, ends, noise)


@dataclass(frozen=True, eq=False)
class _Reader:
    """Reads curves' contrast off their coefficients.

    Attributes
    ----------
    at
        (k, 1+2h) float64, the basis at the places where a curve is read
    variance
        (h,) float64 [cd²/m⁴], of the noise in a coefficient of each harmonic
    """

    at: NDArray[np.float64]
    variance: NDArray[np.float64]

    @classmethod
    def of(cls, fit: HarmonicFit, position: NDArray[np.float64]) -> "_Reader":
        """Return the reader of curves with a fit's noise at positions in pitches."""
        variance = np.diag(fit.covariance)[1:].reshape(-1, 2).mean(axis=1)
        return cls(basis(position, fit.harmonics), variance)

    def places(self, coefficient: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the basis where curves (n, 1+2h) are highest and lowest, (2, n, 1+2h).

        These are places of the curves with each harmonic shrunk by the noise in it, for the highest
        place of the curves themselves is one of high noise too.
        """
        pair = coefficient[:, 1:].reshape(len(coefficient), -1, 2)
        power = np.einsum("nhk,nhk->nh", pair, pair) / self.variance
        kept = np.repeat(1 - mean_share(power), 2, axis=1)
        shrunk = (coefficient[:, 1:] * kept) @ self.at[:, 1:].T
        return self.at[[shrunk.argmax(axis=1), shrunk.argmin(axis=1)]]

    def contrast(self, coefficient: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the contrast between those places of curves (n, 1+2h), (n,)."""
        high, low = np.einsum("enh,nh->en", self.places(coefficient), coefficient)
        return (high - low) / (high + low)


def _plausible_shapes(
    fit: HarmonicFit, noise: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return coefficients that the fitted ones may stand for, (draws, 1+2h), without the mean."""
    shape = np.zeros_like(noise)
    for first in range(1, len(fit.coefficient), 2):
        pair = slice(first, first + 2)
        seen = fit.coefficient[pair]
        power = seen @ np.linalg.solve(fit.covariance[pair, pair], seen)
        shape[:, pair] = plausible(seen, power, noise[:, pair], rng)
    return shape


def contrast_of_points(
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
    seed: int = 0,
) -> Estimate:
    """Return the contrast of single noisy points, median-unbiased, with its 95 % interval.

    luminance, error: (n,) float64 [cd/m²], value and standard error, this from so many blocks.
    """
    from mpfcad.optics.base.recorder import freedom_of_sum

    shape = luminance - luminance.mean()
    if shape.max() == shape.min():
        return Estimate(0.0, 0.0, 0.0, 0.0)
    rng = np.random.Generator(np.random.Philox(seed))
    noise, other = (rng.standard_normal((_DRAWS, len(luminance))) * error for _ in range(2))
    ends = np.zeros(len(luminance))
    ends[[np.argmax(luminance), np.argmin(luminance)]] = 1, -1
    noise *= wobble(rng, _DRAWS, freedom_of_sum(ends, error, blocks))
    power = float(np.sum((shape / np.maximum(error, 1e-12 * luminance.max())) ** 2))
    shapes = plausible(shape, power, other, rng)
    ends = shapes.max(axis=1), shapes.min(axis=1)
    level = np.full(len(luminance), luminance.mean())
    return unbiased(_contrast, luminance, level, shapes, ends, noise)


def plausible(
    read: NDArray[np.float64], power: float, noise: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return true values that noisy ones may stand for, (draws, m).

    read: (m,), |read|² = `power` in units of the noise; noise: (draws, m) that such values have.

    The truth is taken as normal about 0, with the share κ of noise in what is read as likely here
    as there in (0, 1) (Strawderman, "Proper Bayes minimax estimators of the multivariate normal
    mean", 1971). Once read, κ has the density κ^(m/2) exp(-κ·power/2), and the truth given κ is
    normal about (1-κ)·read with 1-κ times the noise's covariance. Taken as read, the shape of a
    noisy curve is rougher than the truth; taken as certain once shrunk, intervals are too narrow.
    """
    a, s = len(read) / 2 + 1, power / 2
    end = 1.0 if s == 0 else min(1.0, (a + 8 * np.sqrt(a) + 20) / s)
    step = (np.arange(_STEPS) + 0.5) / _STEPS * end
    share = np.cumsum(step ** (a - 1) * np.exp(-step * s))
    kappa = np.interp(rng.random((len(noise), 1)) * share[-1], share, step)
    return (1 - kappa) * read + np.sqrt(1 - kappa) * noise


def mean_share(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of κ of `plausible` for pairs of such a power."""
    s = np.maximum(power / 2, 1e-3)
    left = np.exp(-s)
    return (2 - (s * s + 2 * s + 2) * left) / (s * (1 - (1 + s) * left))


def unbiased(
    read: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    seen: NDArray[np.float64],
    level: NDArray[np.float64],
    shape: NDArray[np.float64],
    ends: tuple[NDArray[np.float64], NDArray[np.float64]],
    noise: NDArray[np.float64],
) -> Estimate:
    """Return the true contrasts of which, with noise, that of `seen` is read.

    read: from (n, m) to contrasts (n,); seen: (m,) [cd/m²]; level: (m,), the same without any
    contrast; shape, noise: (draws, m); ends: (draws,), each shape's highest and lowest [cd/m²].
    """
    value, mean = float(read(seen[None])[0]), level[0]
    (top, bottom), noise = ends, level + noise

    def readings(contrast: float) -> NDArray[np.float64]:
        """Return what the draws read, each about its shape with a true contrast, (draws,)."""
        # At few places a shape can lie above its mean at all of them.
        span = np.maximum((top - bottom) - contrast * (top + bottom), 0.1 * (top - bottom))
        return read((2 * contrast * mean / span)[:, None] * shape + noise)

    # A curve read flatter than most flat ones are would get an interval the shorter, the luckier
    # the reading, down to [0, 0]: it gets that of the median flat one (Cowan, Cranmer, Gross and
    # Vitells, "Power-constrained limits", 2011).
    value = max(value, float(np.median(readings(0.0))))
    # The share of draws that read less than seen falls with the true contrast, as a normal
    # distribution does nearly: straight in its quantiles, so a coarse grid is enough.
    spread = float(np.std(readings(value)))
    grid = np.linspace(max(0.0, value - 6 * spread), min(1.0, value + 6 * spread), _GRID)
    below = np.array([np.mean(readings(c) < value) for c in grid])
    below = np.clip(np.minimum.accumulate(below), 0.5 / _DRAWS, 1 - 0.5 / _DRAWS)
    quantile = [-_NORMAL.inv_cdf(s) for s in below]

    def contrast_where(wanted: float) -> float:
        return float(np.interp(-_NORMAL.inv_cdf(wanted), quantile, grid))

    return Estimate.within(*(contrast_where(q) for q in (0.5, 1 - TAIL, TAIL)))


def _contrast(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (max - min)/(max + min) over the last axis."""
    high, low = curve.max(axis=-1), curve.min(axis=-1)
    return (high - low) / (high + low)
