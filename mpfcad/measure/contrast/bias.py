"""Without the bias of a noisy maximum and minimum: which truth a reading stands for.

What noisy values may truly be, and which true contrast gives, with their noise, the one that was
read.
"""

from collections.abc import Callable
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.estimate import TAIL, Estimate

_GRID = 13
_STEPS = 1024
_NORMAL = NormalDist()


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


def invert(value: float, readings: Callable[[float], NDArray[np.float64]]) -> Estimate:
    """Return the true contrasts of which `value` is read; `readings`: what draws read of one."""
    # A curve read flatter than most flat ones are would get an interval the shorter, the luckier
    # the reading, down to [0, 0]: it gets that of the median flat one (Cowan, Cranmer, Gross and
    # Vitells, "Power-constrained limits", 2011).
    value = max(value, float(np.median(readings(0.0))))
    # The share of draws that read less than seen falls with the true contrast, as a normal
    # distribution does nearly: straight in its quantiles, so a coarse grid is enough.
    spread = float(np.std(readings(value)))
    grid = np.linspace(max(0.0, value - 6 * spread), min(1.0, value + 6 * spread), _GRID)
    read = [readings(c) for c in grid]
    below = np.array([np.mean(one < value) for one in read])
    least = 0.5 / len(read[0])
    below = np.clip(np.minimum.accumulate(below), least, 1 - least)
    quantile = [-_NORMAL.inv_cdf(s) for s in below]

    def contrast_where(wanted: float) -> float:
        return float(np.interp(-_NORMAL.inv_cdf(wanted), quantile, grid))

    return Estimate.within(*(contrast_where(q) for q in (0.5, 1 - TAIL, TAIL)))


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
    mean, (top, bottom) = float(level[0]), ends
    noise = level + noise

    def readings(contrast: float) -> NDArray[np.float64]:
        """Return what the draws read, each about its shape with a true contrast, (draws,)."""
        return read(scale(contrast, mean, top, bottom)[:, None] * shape + noise)

    return invert(float(read(seen[None])[0]), readings)


def scale(
    contrast: float, mean: float, top: NDArray[np.float64], bottom: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the factors with which shapes of such ends about a mean have a contrast."""
    # At few places a shape can lie above its mean at all of them.
    span = np.maximum((top - bottom) - contrast * (top + bottom), 0.1 * (top - bottom))
    return 2 * contrast * mean / span
