"""Clipped pixels: those at the top of a file's type, or piled up at the highest count."""

import numpy as np
from numpy.typing import NDArray

#: Pixels that share the highest count: fewer of them, or a smaller share, are no clipping.
_FEWEST, _SHARE = 16, 1e-3
#: The top of a wave in whole counts holds at most 2.4 times what the count below it holds.
_PILED = 4.0


def clipped(counts: NDArray[np.float64]) -> int:
    """Return how many pixels (any shape) are piled up at the highest count, 0 where none are.

    A camera of fewer bits than its file clips below the file's full scale. Then the highest count
    is had by many pixels, and by many more than each of the three counts below it.

    >>> clipped(np.minimum(np.arange(1000.0), 900.0)), clipped(np.arange(1000.0) // 20)
    (100, 0)
    """
    finite = counts[np.isfinite(counts)]
    _, number = np.unique(finite, return_counts=True)
    if not number.size or number[-1] < max(_FEWEST, _SHARE * finite.size):
        return 0
    below = int(number[-4:-1].max()) if number.size > 1 else 0
    return int(number[-1]) if number[-1] > _PILED * below else 0
