"""The shape of the menisci that a trace shows, in words and figures."""

from dataclasses import dataclass

import numpy as np

from mpfcad.film.stylus.bound.interval import Interval
from mpfcad.film.stylus.bound.spread import Spread
from mpfcad.film.stylus.model import ROUNDNESS, WETTING
from mpfcad.film.stylus.solve import Fitted
from mpfcad.units import deg, um

#: Resin this near [mm] to the tips lies at them.
_AT_TIPS = 0.3 * um
#: A roundness that is known no better than this is not told.
_UNTOLD = 0.6
#: Wetting and roundness this near to 0 are 0.
_ZERO = 1e-3


@dataclass(frozen=True)
class MeniscusShape:
    """Where and how resin meets the walls, the mean over the grooves, with 95 % intervals.

    Attributes
    ----------
    below_tips
        how far [mm] below the prism tips
    wall_angle
        between wall and surface there [rad]: the contact angle, if the tips do not hold the resin
    roundness
        0: a parabola, 1: a circle
    through_tips
        whether a parabola through the tips, of the fill that is found, is one of what may be
    """

    below_tips: Interval
    wall_angle: Interval
    roundness: Interval
    through_tips: bool

    @property
    def words(self) -> str:
        """Return it in one line."""
        low, high = self.below_tips.low / um, self.below_tips.high / um
        where = "the tips" if high < _AT_TIPS / um else (
            f"the walls {self.below_tips.value / um:.1f} [{low:.1f}, {high:.1f}] µm below the tips"
        )  # fmt: skip
        angle = " … ".join(
            f"{max(a, 0.0) / deg:.0f}" for a in (self.wall_angle.low, self.wall_angle.high)
        )
        round_, half = self.roundness, (self.roundness.high - self.roundness.low) / 2
        form = f"roundness {round_.value:.1f} ± {half:.1f} (0 a parabola, 1 a circle)"
        form = "round or parabolic: not told" if half > _UNTOLD else form
        fits = "fits" if self.through_tips else "does not fit"
        return (
            f"resin meets {where} at {angle}° to the walls, {form}; "
            f"a parabola through the tips {fits}"
        )


def meniscus_shape(fit: Fitted, spread: Spread) -> MeniscusShape:
    """Return the shape of a fit's menisci, and of those that wetting and roundness leave open."""
    groove = fit.model.groove_of(fit.value)
    wet, round_ = float(fit.value[WETTING]), float(fit.value[ROUNDNESS])
    by_wetting, by_roundness = spread.shape

    def found(above: float) -> tuple[float, float]:
        value = fit.value.copy()
        value[WETTING] = np.clip(above, -1.0, 1.0)
        each = fit.model.menisci(value)
        whole = fit.whole
        slope = np.broadcast_to(each.slope, whole.shape)[whole]
        below = groove.wall_slope * (groove.half_width - each.contact[whole])
        angle = np.arctan(groove.wall_slope) - np.arctan(slope)
        return float(np.mean(below)), float(np.mean(angle))

    at, down, up = (found(wet + off) for off in (0.0, -by_wetting, by_wetting))
    below, angle = (
        Interval(a, min(a, b, c), max(a, b, c)) for a, b, c in zip(at, down, up, strict=True)
    )
    return MeniscusShape(
        below,
        angle,
        Interval(round_, round_ - by_roundness, round_ + by_roundness),
        abs(wet) <= by_wetting + _ZERO and abs(round_) <= by_roundness + _ZERO,
    )
