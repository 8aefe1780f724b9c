"""How far a map within its limits can go, by the linear model of a design's traces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.job.led_design import LedConstraintTable
from mpfcad.pipeline.led.tried import Tried

#: Places along each side of half a cell at which limits and light are held.
_PLACES = 17


@dataclass(frozen=True)
class Least:
    """The best map of the linear model.

    Attributes
    ----------
    contrast
        its (Lmax - Lmin)/(Lmax + Lmin)
    coefficient
        (h+1, h+1) float64 [1/mm], its series
    """

    contrast: float
    coefficient: NDArray[np.float64]


def least_contrast(limit: LedConstraintTable, from_: Tried, response: NDArray[np.float64]) -> Least:
    """Return the map of least contrast that the model has within limits of C.

    ln L(x, y) of a map is that of the trace `from_` plus Σ r_ij (c_ij - c_ij of it) cos cos, with
    the mean of C as it is there and r the response (h+1, h+1) [mm]. Least of Lmax - Lmin over all
    c_ij that keep C within its limits is a linear programme (HiGHS, by scipy): no map of so many
    harmonics and that mean does better, as far as each harmonic of L answers to its own harmonic
    of C alone, in proportion.
    """
    from scipy.optimize import linprog

    size = len(response)
    place = np.linspace(0, 0.5, _PLACES)
    wave = np.cos(2 * np.pi * np.outer(place, np.arange(size)))
    basis = np.einsum("xi,yj->xyij", wave, wave).reshape(-1, size * size)[:, 1:]
    rate, start = response.ravel()[1:], from_.map.coefficient.ravel()[1:]
    light = basis @ (from_.harmonic.ravel()[1:] - rate * start)
    mean = from_.map.coefficient[0, 0]
    count, one = len(basis), np.ones((len(basis), 1))
    none = np.zeros((count, 1))
    # Unknowns: the pattern's coefficients, Lmax and Lmin over the mean, less one.
    table = np.block([
        [basis * rate, -one, none],
        [-basis * rate, none, one],
        [basis, none, none],
        [-basis, none, none],
    ])  # fmt: skip
    most = np.concatenate([
        -light, light,
        np.full(count, limit.curvature_max_per_mm - mean),
        np.full(count, mean - limit.curvature_min_per_mm),
    ])  # fmt: skip
    goal = np.zeros(table.shape[1])
    goal[-2:] = 1.0, -1.0
    found = linprog(goal, A_ub=table, b_ub=most, bounds=(None, None), method="highs")
    high, low = found.x[-2:]
    coefficient = np.append(mean, found.x[:-2]).reshape(size, size)
    return Least(float((high - low) / (2 + high + low)), coefficient)
