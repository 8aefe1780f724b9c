"""Intervals of curvature and fill from a fit: two readings of a scale, and what a tip hides."""

from dataclasses import dataclass

import numpy as np

from mpfcad.film.groove import Groove
from mpfcad.film.stylus.model import SLOPE, SLOPE_OFF, Fitted
from mpfcad.film.stylus.spread import Spread
from mpfcad.film.stylus.tip import StylusTip

#: The larger of two half-widths is too wide: this share of it holds 95 % of simulated truths.
SHARE = 0.8
_TWO_SIDED = 1.959964
#: Slopes nearer than this share are one.
_SAME = 1e-3
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
    slope = float(fit.value[SLOPE])
    for angle in cones:
        steeper = slope / StylusTip(0.0, angle).flank_slope - 1
        if steeper > -spread.log_slope - _SAME and (told or steeper < spread.log_slope + _SAME):
            return _TWO_SIDED * SLOPE_OFF
    return 0.0


def curvature_interval(fit: Fitted, spread: Spread, groove: Groove, *, correct: bool) -> Interval:
    """Return C as measured, with an interval that holds it as if the scale were off, too."""
    mean = max(float(np.mean(fit.fills)), 1e-9)
    stated = mean * groove.curvature_covered
    measured = stated if correct else fit.curvature
    low, high = sorted((measured, stated))
    half = SHARE * (stated * spread.fill / mean if correct else measured * spread.log_curvature)
    reach = half * _critical(high - low, half / _TWO_SIDED)
    down, up = spread.unseen[0] / mean, spread.unseen[1] / mean
    return Interval(
        measured,
        max(min(low - reach, low * (1 - down)), 0.0),
        min(max(high + reach, high * (1 + up)), fit.model.top * high / mean),
    )


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

    down, up = (max(SHARE * spread.fill, unseen) for unseen in spread.unseen)
    steeper = float(np.mean(fit.fills)) * hidden / (1 + hidden)
    return Interval(mean(0.0), mean(up), mean(-float(np.hypot(down, steeper))))


def joined(intervals: list[Interval]) -> Interval:
    """Return the first's value with an interval that holds all of them."""
    return Interval(
        intervals[0].value, min(i.low for i in intervals), max(i.high for i in intervals)
    )
