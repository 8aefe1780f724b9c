"""Ripple of slots after levelling, in closed form: what a proposal is made with.

Slots of ratio a every period P are a square wave; averaged with a Gauss curve of deviation σ its
n-th harmonic has the amplitude 2 sin(π n a)/(π n) · exp(-2 (π n σ/P)²).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.mask.pattern.levelling import FULL_WIDTH

HARMONICS = 12


def slot_ripple(
    ratio: ArrayLike, period: ArrayLike, levelling_length: ArrayLike
) -> NDArray[np.float64]:
    """Return the root mean square of the ratio's error; lengths in mm, arrays broadcast.

    Examples
    --------
    >>> float(slot_ripple(0.1, 0.4, 1.0)) < 1e-4 < float(slot_ripple(0.1, 2.3, 1.0))
    True
    """
    n = np.arange(1, HARMONICS + 1)
    a, p, length = (np.asarray(v, float)[..., None] for v in (ratio, period, levelling_length))
    amplitude = 2 * np.sin(np.pi * n * a) / (np.pi * n)
    left = amplitude * np.exp(-2 * (np.pi * n * length / FULL_WIDTH / p) ** 2)
    return np.sqrt(np.sum(left**2, axis=-1) / 2)
