"""What curvature and fill a trace gives at each slope of the walls, or scale of the heights.

Walls that are in sight tell their slope. Near C = slope/w and below resin hides them, and a trace
says no more than that they are no flatter than its parabola at the tips: what is known of the slope
has steep sides and several minima, which no derivative at the best fit tells. So the fit is done
again at slopes, or scales, all over what the prior allows, and those count whose sum of squares is
within 95 % of χ² of the least one (profile likelihood: Pawitan, In All Likelihood, Oxford 2001,
ch. 3).
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.model import FILL, PITCH, SLOPE, SLOPE_OFF
from mpfcad.film.stylus.solve import RISE, Fitted, solve

#: ln(slope over the stated one) that are tried, and how often the step at an end is halved.
_TRIED, _HALVINGS = np.linspace(-0.08, 0.08, 9), 3
#: Farther than a slope whose sum of squares is so much larger none is tried.
_FAR = 60.0
#: A fit is as good as found when a step gains so much of a sum of some thousand.
_CLOSE = 1e-5


@dataclass(frozen=True, eq=False)
class Held:
    """The fit where walls read exp(`off`) times as steep as stated.

    `cost` is the sum of squares, noise and priors as one, less the least one.
    """

    off: float
    value: NDArray[np.float64]
    cost: float
    fill: float
    curvature: float


def held_fits(fit: Fitted, noise: float, *, scaled: bool) -> list[Held]:
    """Return fits within 95 % over all slopes of the walls, flattest first.

    noise: of heights [mm], as if they were independent. scaled: the walls are as stated, and the
    heights' scale is off instead; the tip is of its own size.
    """
    start = math.log(fit.value[SLOPE] / fit.model.groove.wall_slope)
    best = _at(fit, start, start, fit.value, noise, scaled)
    found = [best]
    for sign in (-1, 1):
        near = best
        for off in sorted((t for t in _TRIED if (t - start) * sign > 0), key=abs):
            near = _at(fit, float(off), near.off, near.value, noise, scaled)
            found.append(near)
            if near.cost > min(held.cost for held in found) + _FAR:
                break
    found.sort(key=lambda held: held.off)
    for _ in range(_HALVINGS):
        end = min(held.cost for held in found) + RISE
        for a, b in list(pairwise(found)):
            if (a.cost <= end) == (b.cost <= end):
                continue
            near = a if a.cost <= end else b
            middle = (a.off + b.off) / 2
            found.append(_at(fit, middle, near.off, near.value, noise, scaled))
        found.sort(key=lambda held: held.off)
    least = min(held.cost for held in found)
    found = [replace(held, cost=held.cost - least) for held in found]
    ends = [_end(a, b) for a, b in pairwise(found) if (a.cost <= RISE) != (b.cost <= RISE)]
    kept = [held for held in found if held.cost <= RISE]
    return sorted([*kept, *ends], key=lambda held: held.off)


def _end(a: Held, b: Held) -> Held:
    """Return where, between a fit within 95 % and one beyond, the sum of squares is at that.

    Its root is taken as straight, as about a least one it is.
    """
    inside, outside = (a, b) if a.cost <= b.cost else (b, a)
    roots = [math.sqrt(c) for c in (inside.cost, RISE, outside.cost)]
    part = (roots[1] - roots[0]) / (roots[2] - roots[0])

    def between(one: float, other: float) -> float:
        return one + part * (other - one)

    return Held(
        between(inside.off, outside.off), inside.value, RISE,
        between(inside.fill, outside.fill), between(inside.curvature, outside.curvature),
    )  # fmt: skip


def _at(
    fit: Fitted, off: float, near: float, value: NDArray[np.float64], noise: float, scaled: bool
) -> Held:
    """Return the fit at an `off`, from the values of one near it."""
    stated, size = fit.model.groove.wall_slope, math.exp(off)
    start = value.copy()
    # What a covered groove shows is C, not u.
    start[FILL:] *= math.exp(near - off)
    start[SLOPE] = stated if scaled else stated * size
    model = replace(fit.model, held_slope=float(start[SLOPE]))
    if scaled:
        model, noise = replace(model, z=model.z / size), noise / size
    found = solve(model, start, noise, close=_CLOSE)
    cost = np.sum((model.residual(found) / noise) ** 2) + np.sum(model.prior(found) ** 2)
    if scaled:
        cost += (off / SLOPE_OFF) ** 2
    u = float(np.mean(found[FILL:][fit.whole]))
    curvature = u * float(found[SLOPE]) / (float(found[PITCH]) / 2)
    return Held(off, found, float(cost), u, curvature)
