"""Figures read off several noisy values, with the bias and spread that the noise gives them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.estimate import TAIL, Estimate

_DRAWS = 1000


def estimate_by_draws(
    figure: Callable[[NDArray[np.float64]], float | None],
    value: NDArray[np.float64],
    error: NDArray[np.float64],
    freedom: float = np.inf,
    seed: int = 0,
) -> Estimate | None:
    """Return a figure of noisy values with its 95 % interval; None where the values have none.

    Parameters
    ----------
    figure
        what is read off (n,) values, or None when they do not have it
    value, error
        (n,) float64, values and their standard errors
    freedom
        degrees of freedom of those errors, as of one value's

    Noise is added to the values again and again (Efron, "Bootstrap methods", 1979): how much the
    figure then rises in the mean is its bias, taken off once, and its spread is the standard error.
    Draws are fixed by `seed`.
    """
    read = figure(value)
    if read is None:
        return None
    rng = np.random.Generator(np.random.Philox(seed))
    noisy = value + rng.standard_normal((_DRAWS, len(value))) * error
    readings = [reading for reading in map(figure, noisy) if reading is not None]
    if len(readings) < (1 - TAIL) * _DRAWS:
        return None
    unbiased = float(2 * read - np.mean(readings))
    return Estimate.student(unbiased, float(np.std(readings)), freedom)
