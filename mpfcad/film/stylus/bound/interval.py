"""Intervals of curvature and fill from a fit: two readings of a scale, and what a tip hides."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mpfcad.film.groove import Groove
from mpfcad.film.stylus.bound.spread import Spread, spread_of
from mpfcad.film.stylus.model import PITCH, SLOPE, SLOPE_OFF
from mpfcad.film.stylus.solve import Fitted
from mpfcad.film.stylus.tip import StylusTip

_TWO_SIDED = 1.959964
#: Slopes nearer than this share are one.
_SAME = 1e-3
#: A scale nearer than this is as stated; slopes known no better than this are hidden.
_OFF, _HIDDEN = 2e-4, 0.04
#: How often heights are put on scale: the tip, of its own size, moves the slope a little.
_TIMES = 2
#: What a reader is told of walls that a cone hides.
HIDDEN_WORDS = (
    "the tip's cone may hide how steep the walls are: the fill's interval holds walls up to "
    f"{100 * _TWO_SIDED * SLOPE_OFF:.0f} % steeper"
)


@dataclass(frozen=True)
class Interval:
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


def hidden_slope(fit: Fitted, spread: Spread, cones: tuple[float, ...], *, told: bool) -> float:
    """Return by what share the walls may be steeper than they look: 0 where they are seen.

    A cone that is blunter than the walls touches the prism tips only, and draws its own flank: of
    walls steeper than that nothing is seen. `cones` are the full angles [rad] that the tip may
    have; where it was not `told`, walls of just a usual cone's slope are suspect.
    """
    flattest, steepest = spread.slope
    for angle in cones:
        flank = StylusTip(0.0, angle).flank_slope
        if steepest > flank * (1 - _SAME) and (told or flattest < flank * (1 + _SAME)):
            return _TWO_SIDED * SLOPE_OFF
    return 0.0


@dataclass(frozen=True)
class Scaled:
    """The fit of a trace that is put on the stated groove's scale, what it leaves open, and how.

    `heights` are the least, the likeliest and the largest factor that the heights read too much.
    """

    fit: Fitted
    spread: Spread
    heights: tuple[float, float, float]


def on_stated_scale(
    fit: Fitted, spread: Spread, groove: Groove, fitted: Callable[..., Fitted]
) -> Scaled:
    """Return the fit of a trace whose positions and heights are put on the stated groove's scale.

    The pitch tells the scale of positions, the walls' slope that of heights. What is not off for
    certain is left, and so is a slope that resin hides: `spread` holds what it may be. The tip is
    of its own size on the new scale, too. `fitted` takes the tip and by what to divide positions
    and heights.
    """
    x_part = z_part = 1.0
    pitch = float(fit.value[PITCH]) / groove.pitch
    if abs(pitch - 1) > max(_OFF, spread.log_pitch):
        x_part = pitch
        fit = fitted(fit.model.tip, x_part, z_part)
    # Walls in sight are as much steeper as positions are nearer.
    off = not spread.slope[0] * x_part <= groove.wall_slope <= spread.slope[1] * x_part
    for _ in range(_TIMES if off and not slope_hidden(spread, groove) else 0):
        slope = float(fit.value[SLOPE]) / groove.wall_slope
        if abs(slope - 1) <= _OFF:
            break
        z_part *= slope
        fit = fitted(fit.model.tip, x_part, z_part)
    told = spread_of(fit, scaled=True)
    low, high = (z_part * edge / groove.wall_slope for edge in told.slope)
    likely = z_part * told.likely_slope / groove.wall_slope
    return Scaled(fit, told, (low, likely, high))


def as_read(fit: Fitted, spread: Spread, groove: Groove) -> Scaled:
    """Return a fit that is left on the scale on which it was read."""
    low, high = (edge / groove.wall_slope for edge in spread.slope)
    return Scaled(fit, spread, (low, spread.likely_slope / groove.wall_slope, high))


def slope_hidden(spread: Spread, groove: Groove) -> bool:
    """Return whether resin hides the walls, so that their slope is hardly known."""
    return (spread.slope[1] - spread.slope[0]) / groove.wall_slope > _HIDDEN


def curvature_interval(
    fit: Fitted, spread: Spread, scaled: Scaled, groove: Groove, *, correct: bool
) -> Interval:
    """Return C as measured, with an interval that holds it as if the scale were off, too.

    scaled: the fit of the trace on the stated groove's scale; its u tells C there. `correct`: that
    alone.
    """
    covered, told = groove.curvature_covered, scaled.spread
    stated, low, high = (covered * u for u in (told.fill.value, told.fill.low, told.fill.high))
    top = scaled.fit.model.top * covered
    if correct:
        return Interval(stated, max(low, 0.0), min(high, top))
    measured, near = fit.curvature, spread.curvature
    error = min(high - low, near.high - near.low) / 2 / _TWO_SIDED
    part = _critical(abs(measured - stated), error)
    low = min(stated - part * (stated - low), measured - part * (measured - near.low))
    high = max(stated + part * (high - stated), measured + part * (near.high - measured))
    top = max(top, fit.model.top * fit.model.groove_of(fit.value).curvature_covered)
    return Interval(measured, max(low, 0.0), min(high, top))


def _critical(gap: float, error: float) -> float:
    """Return by what a half-width shrinks where the truth lies between two ends so far apart.

    From 1 where they meet to the one-sided quantile over the two-sided one: the root c of
    Φ(c + gap/error) - Φ(-c) = 0.95, over 1.96.
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    if error <= 0 or gap <= 0:
        return 1.0
    wide = min(gap / error, 50.0)
    root = brentq(lambda c: ndtr(c + wide) - ndtr(-c) - 0.95, 1.0, 3.0)
    return float(root) / _TWO_SIDED


def fill_interval(fit: Fitted, spread: Spread, hidden: float) -> Interval:
    """Return the mean fill fraction: a function of the grooves' u alone."""
    unit = Groove(2.0, 1.0)  # slope and half width 1: C is u

    def mean(shift: float) -> float:
        moved = np.clip(fit.fills + shift, 0.0, fit.model.top)
        return float(np.mean(unit.fill_fraction(moved)))

    at, told = float(np.mean(fit.fills)), spread.fill
    down = math.hypot(told.value - told.low, told.value * hidden / (1 + hidden))
    return Interval(mean(told.value - at), mean(told.high - at), mean(told.value - down - at))


def joined(intervals: list[Interval]) -> Interval:
    """Return the first's value with an interval that holds all of them."""
    return Interval(
        intervals[0].value, min(i.low for i in intervals), max(i.high for i in intervals)
    )
