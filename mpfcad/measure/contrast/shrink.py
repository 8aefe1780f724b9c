"""What noisy values may truly be, without a curve that joins them."""

import numpy as np
from numpy.typing import NDArray

_STEPS = 1024


def plausible(
    read: NDArray[np.float64], power: float, noise: NDArray[np.float64], rng: np.random.Generator
) -> tuple[NDArray[np.float64], float]:
    """Return true values that noisy ones may stand for, (draws, m), and the share kept of them.

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
    return (1 - kappa) * read + np.sqrt(1 - kappa) * noise, float(np.mean(1 - kappa))
