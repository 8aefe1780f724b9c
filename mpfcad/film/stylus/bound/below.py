"""How far below the tips resin may stand that is taken to reach them.

It is told by the corners alone that it leaves bare, which grow as the square of how far below it
stands, and it cannot stand above. So what that leaves open lies to one side, and no derivative
tells it: the fit is done again with less wetting, down to where its sum of squares is at 95 % of χ²
(profile likelihood).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.model import FILL, SLOPE, WETTING
from mpfcad.film.stylus.solve import RISE, Fitted, solve

#: Halvings of the range of wettings, and the share of a sum that the last step of a fit gains.
_HALVINGS, _CLOSE = 6, 1e-5


@dataclass(frozen=True)
class Below:
    """The least wetting that may be, and by how much the mean u is larger there."""

    wetting: float
    u: float


def below_tips(fit: Fitted, noise: float) -> Below:
    """Return what a fit whose resin is taken to reach the tips leaves open; slope held.

    noise: of heights [mm], as if they were independent.
    """
    model, value = fit.model, fit.value
    start = float(np.mean(fit.fills))
    least = _cost(model.residual(value), noise, model.prior(value))
    best, near = Below(0.0, 0.0), value
    low, high = -1.0, 0.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        held = replace(model, wettings=(middle, middle), held_slope=float(value[SLOPE]))
        tried = near.copy()
        tried[WETTING] = middle
        found = solve(held, tried, noise, close=_CLOSE)
        if _cost(held.residual(found), noise, held.prior(found)) - least > RISE:
            low = middle
            continue
        high, near = middle, found
        best = Below(middle, float(np.mean(found[FILL:][fit.whole])) - start)
    return best


def _cost(residual: NDArray[np.float64], noise: float, prior: NDArray[np.float64]) -> float:
    return float(np.sum((residual / noise) ** 2) + np.sum(prior**2))
