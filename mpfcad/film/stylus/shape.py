"""The shape of the menisci that a trace shows, in words and figures."""

from dataclasses import dataclass, replace

import numpy as np

from mpfcad.film.stylus.bound.interval import Interval
from mpfcad.film.stylus.bound.spread import Spread
from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import FLATNESS, ROUNDNESS, WETTING
from mpfcad.film.stylus.solve import Fitted, solve
from mpfcad.units import deg, um

#: Resin this near [mm] to the tips lies at them.
_AT_TIPS = 0.3 * um
#: A roundness that is known no better than this is not told.
_UNTOLD = 0.6
#: 95 % of χ² with the three degrees of freedom of a meniscus's shape.
_RISE = 7.814728


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
    flatness
        0: of resin at rest, 1: a fourth power
    through_tips
        whether parabolas through the tips fit as well as noise allows
    """

    below_tips: Interval
    wall_angle: Interval
    roundness: Interval
    flatness: Interval
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
        flat = self.flatness
        if flat.low > 0 or flat.high < 0:
            half = (flat.high - flat.low) / 2
            form = f"flatness {flat.value:.2f} ± {half:.2f} (0 at rest, 1 a fourth power)"
        fits = "fits" if self.through_tips else "does not fit"
        return (
            f"resin meets {where} at {angle}° to the walls, {form}; "
            f"a parabola through the tips {fits}"
        )


def meniscus_shape(fit: Fitted, spread: Spread) -> MeniscusShape:
    """Return the shape of a fit's menisci, and of those that the trace leaves open."""
    groove = fit.model.groove_of(fit.value)
    wet, round_, flat = (float(fit.value[i]) for i in (WETTING, ROUNDNESS, FLATNESS))
    by_wetting, by_roundness, by_flatness = spread.shape

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
        Interval(flat, flat - by_flatness, flat + by_flatness),
        _through_tips(fit),
    )


def _through_tips(fit: Fitted) -> bool:
    """Return whether parabolas through the tips leave no more than noise beside the best fit."""
    model = replace(fit.model, parabolic=True)
    found = solve(model, fit.value, fit.noise, close=1e-5)
    left, there = fit.model.residual(fit.value), model.residual(found)
    rise = (np.sum(there**2) - np.sum(left**2)) / fit.noise**2
    return bool(rise < _RISE * correlation_sum(left))
