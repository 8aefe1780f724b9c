"""What maps reach: the extremes of the luminance between the lamps over that above a lamp.

Found by a local search in the model; a bound over all maps is that of `bound`. Where even the
largest ratio L(0.5)/L(0) is below 1, the ranges of luminance above and between the lamps do not
overlap. The maps here are free in every cell within the range of C; they need not be smooth.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import row_position
from mpfcad.design.optimum import Correction
from mpfcad.design.response import Response

_STEPS = 30
_TRUST, _SMALLEST = 20.0, 0.5


@dataclass(frozen=True, eq=False)
class Reach:
    """Extremes of L(0.5)/L(0) by the corrected model.

    Attributes
    ----------
    ratio
        smallest and largest ratio
    rows
        C [1/mm] at the map's rows that gives each
    """

    ratio: tuple[float, float]
    rows: tuple[NDArray[np.float64], NDArray[np.float64]]

    @property
    def overlaps(self) -> bool:
        """Whether maps on both sides of L(0.5) = L(0) are reached."""
        return self.ratio[0] <= 1 <= self.ratio[1]


def find_reach(
    response: Response, correction: Correction, curvature_min: float, curvature_max: float
) -> Reach:
    """Return the extremes that a search finds over the maps with C in the given range [1/mm].

    From the uniform film of the range's middle by steps along the derivative's sign, each halved
    until it helps.
    """
    middle = (curvature_min + curvature_max) / 2
    found = [
        _climb(response, correction, sign, curvature_min, curvature_max, middle)
        for sign in (-1.0, 1.0)
    ]
    low, high = (float(np.exp(end[0])) for end in found)
    cell = np.minimum((row_position() * response.grid.cells).astype(int), response.grid.cells - 1)
    return Reach((low, high), tuple(end[1][cell] for end in found))


def _climb(
    response: Response,
    correction: Correction,
    sign: float,
    low: float,
    high: float,
    value: float,
) -> tuple[float, NDArray[np.float64]]:
    """Return the largest sign · ln L(0.5)/L(0) found from a uniform film, and its C by cell."""
    cells = response.grid.cells
    above, between = (0, cells - 1), (cells // 2 - 1, cells // 2)
    curvature, trust = np.full(cells, value), _TRUST

    def log_ratio(luminance: NDArray[np.float64]) -> float:
        curve = correction.apply(response.grid.centre, luminance)
        return float(np.log(curve[list(between)].mean() / curve[list(above)].mean()))

    best = log_ratio(response.luminance(curvature))
    for _ in range(_STEPS):
        weight = response.smooth[[0, between[0]]]
        luminance, rows = response.derivative(curvature, weight)
        slope = np.subtract(*(rows / (weight @ luminance)[:, None])[::-1])
        slope = sign * (slope + slope[::-1])
        while trust >= _SMALLEST:
            trial = np.clip(curvature + trust * np.sign(slope), low, high)
            ratio = log_ratio(response.luminance(trial))
            if sign * (ratio - best) > 1e-5:
                break
            trust /= 2
        else:
            return best, curvature
        best, curvature = ratio, trial
    return best, curvature
