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
    harmonic, error
        (h+1, h+1) float64, amplitudes of the luminance's cosines over the mean and their standard
        errors; 0 and infinite where the trace has none
    """

    map: CurvatureSeries
    found: CellResult
    harmonic: NDArray[np.float64]
    error: NDArray[np.float64]

    @property
    def mean(self) -> float:
        """Mean of C [1/mm]."""
        return float(self.map.coefficient[0, 0])


def read_tried(chosen: CurvatureSeries, found: CellResult) -> Tried:
    """Return a map with the cosines of its light, as many as the map has."""
    size = len(chosen.coefficient)
    amplitude, error = np.zeros((size, size)), np.full((size, size), np.inf)
    series, mean = found.series, found.series.coefficient[0]
    deviation = np.sqrt(np.diagonal(series.covariance))
    for (i, j), value, off in zip(series.order, series.coefficient, deviation, strict=True):
        even = (i == 0 or i % 2 == 1) and (j == 0 or j % 2 == 1)
        a, b = (int(i) + 1) // 2, (int(j) + 1) // 2
        if even and a < size and b < size:
            amplitude[a, b], error[a, b] = value / mean, off / mean
    amplitude[0, 0] = 0.0
    return Tried(chosen, found, amplitude, error)
