"""Which inputs to change together: a two-level factorial, so that each run tells of every input.

Columns of a Hadamard matrix whose numbers have an odd count of binary ones: main effects are then
free of every interaction of two (resolution IV; Box, Hunter and Hunter, "Statistics for
experimenters", 2005).
"""

import numpy as np
from numpy.typing import NDArray

#: Steps in units of each input's sigma.
STEP = 1.5
_LEAST_RUNS = 32


def factorial_steps(count: int) -> NDArray[np.float64]:
    """Return the steps of `count` inputs in each run, (runs, count) in units of sigma: ± `STEP`.

    32 runs for up to 16 inputs, twice as many for twice as many inputs.
    """
    runs = _LEAST_RUNS
    while runs // 2 < count:
        runs *= 2
    column = [i for i in range(runs) if i.bit_count() % 2][:count]
    row = np.arange(runs)
    signs = np.array([[(int(r) & c).bit_count() % 2 for c in column] for r in row])
    return STEP * (1.0 - 2.0 * signs.reshape(runs, count))
