"""A map under LEDs that was traced, and the harmonics of its light."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CurvatureSeries
from mpfcad.measure import CellResult


@dataclass(frozen=True, eq=False)
class Tried:
    """A map that was traced.

    Attributes
    ----------
    map
        its series
    found
        the luminance over the cell
    harmonic
        (h+1, h+1) float64, amplitudes of the luminance's cosines over the mean
    """

    map: CurvatureSeries
    found: CellResult
    harmonic: NDArray[np.float64]


def cosines(found: CellResult, size: int) -> NDArray[np.float64]:
    """Return the amplitudes of the luminance's cosines over the mean, (size, size); 0 beyond."""
    amplitude = np.zeros((size, size))
    series = found.series
    for (i, j), value in zip(series.order, series.coefficient, strict=True):
        even = (i == 0 or i % 2 == 1) and (j == 0 or j % 2 == 1)
        a, b = (int(i) + 1) // 2, (int(j) + 1) // 2
        if even and a < size and b < size:
            amplitude[a, b] = value / series.coefficient[0]
    amplitude[0, 0] = 0.0
    return amplitude
