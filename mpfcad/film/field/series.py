"""A map C(x, y) over a cell of LEDs as a series of cosines, the LED at x = y = 0."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class CurvatureSeries:
    """C(x, y) = Σ c_ij cos(2πi x/Px) cos(2πj y/Py), Px and Py the sides of the cell.

    Attributes
    ----------
    coefficient
        (h, k) float64 [1/mm], c_ij; c_00 is the mean

    Examples
    --------
    >>> series = CurvatureSeries(np.array([[60.0, 1.0], [2.0, 0.0]]))
    >>> series.at(np.array([0.0, 0.5]), np.array([0.0]))
    array([[63.],
           [59.]])
    """

    coefficient: NDArray[np.float64]

    def at(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return C [1/mm] at all of u by all of v in periods, (n, m)."""
        across, along = (
            np.cos(2 * np.pi * np.outer(place, np.arange(count)))
            for place, count in zip((u, v), self.coefficient.shape, strict=True)
        )
        return np.asarray(across @ self.coefficient @ along.T)

    @property
    def turned(self) -> "CurvatureSeries":
        """The same map as a film sees it that lies across."""
        return CurvatureSeries(self.coefficient.T.copy())
