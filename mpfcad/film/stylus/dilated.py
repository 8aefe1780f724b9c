"""What a tip traces of a filled groove, in closed form.

Dilation of a maximum is the maximum of the dilations, so the trace of walls and resin is the
higher of two: the walls', each raised by what the ball needs on a slope, with the ball's own arc
over the prism tips; and the resin's, where the tip touches at the point of its own slope.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.meniscus import Meniscus
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.units import nm

#: Steps of Newton's method to where the tip touches.
_NEWTON = 6
#: A touching point is known [mm] when a step is shorter.
_NEAR = 0.1 * nm


@dataclass(frozen=True)
class DilatedGroove:
    """A groove under a stylus tip; `rounding` [mm] is the radius of the prism tips themselves."""

    groove: Groove
    profile: Profile = "filled"
    tip: StylusTip | None = None
    rounding: float = 0.0

    def height(self, local: NDArray[np.float64], curvature: ArrayLike) -> NDArray[np.float64]:
        """Return the traced height [mm] at x (n,) [mm] from the groove's centre, -w … w.

        curvature: one [1/mm], or (n,), of the parabola through the tips. The height is 0 where the
        tip's lowest point would be at the bare groove's valley.
        """
        if self.tip is None and self.rounding == 0:
            return self.groove.height(local, curvature, self.profile)
        return self.over(local, Meniscus.through_tips(self.groove, curvature, self.profile))

    def over(
        self,
        local: NDArray[np.float64],
        meniscus: Meniscus,
        touch: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return the same of resin of any meniscus: one, or one at each place.

        touch: where the tip touches the resin, (n,) [mm], if known.
        """
        x = np.abs(local)
        surface = self._resin(x, meniscus, touch)
        if self.profile == "ideal":
            if self.tip is None or not np.any(meniscus.slope > self.tip.flank_slope):
                return surface
            return np.maximum(surface, self._over_tip(self.groove.half_width - x, meniscus.slope))
        return np.maximum(surface, self._walls(x))

    def _walls(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the trace of the bare walls and tips."""
        groove, tip = self.groove, self.tip
        slope = groove.wall_slope
        if tip is not None and slope > tip.flank_slope:
            # The cone touches the prism tips only.
            return self._over_tip(groove.half_width - x, slope)
        raised = slope * x + self._lift(slope)
        return self._rounded(raised, x, slope, groove.depth)

    def _resin(
        self, x: NDArray[np.float64], meniscus: Meniscus, touch: NDArray[np.float64] | None
    ) -> NDArray[np.float64]:
        """Return the trace of the resin; beyond its contact it goes on straight to the tips."""
        tip = self.tip
        at = self.touch(x, meniscus) if touch is None else np.minimum(touch, meniscus.contact)
        if tip is None:
            surface = meniscus.height(at) + meniscus.slope * (x - at)
            steepest = meniscus.slope
        else:
            surface = meniscus.height(at) - tip.height(at - x)
            steepest = np.minimum(meniscus.slope, tip.flank_slope)
        end = meniscus.level + meniscus.slope * (self.groove.half_width - meniscus.contact)
        return self._rounded(surface, x, steepest, end)

    def touch(self, local: NDArray[np.float64], meniscus: Meniscus) -> NDArray[np.float64]:
        """Return where [mm] on the resin a tip over x, (n,), touches: its slope there is the tip's.

        x(touch) is convex: Newton's method from above comes down to the root. A cone that is less
        steep than the resin touches where the resin has its slope.
        """
        tip, x = self.tip, np.abs(local)
        if tip is None or tip.radius == 0:
            return np.minimum(x, meniscus.reach(tip.flank_slope if tip else np.inf))
        reach = np.broadcast_to(meniscus.reach(tip.flank_slope), x.shape)
        blunt = 1 - 0.9 * tip.radius * meniscus.steepness(np.zeros_like(x))[1]
        touch = np.where(blunt > 0.12, np.minimum(x / np.maximum(blunt, 0.12), reach), reach)
        for _ in range(_NEWTON):
            slope, second = meniscus.steepness(touch)
            size = np.hypot(1.0, slope)
            gap = touch - tip.radius * slope / size - x
            rate = 1 - tip.radius * second / size**3
            step = np.where(rate > 1e-3, gap / np.maximum(rate, 1e-3), 0.0)
            last, touch = touch, np.clip(touch - step, 0.0, reach)
            if float(np.max(np.abs(touch - last))) < _NEAR:
                break
        return touch

    def _lift(self, slope: float) -> float:
        """Return how much higher a ball runs over a plane of a slope than the plane itself."""
        radius = self.tip.radius if self.tip else 0.0
        return radius * (float(np.hypot(1.0, slope)) - 1)

    def _rounded(
        self, surface: NDArray[np.float64], x: NDArray[np.float64], slope: ArrayLike, end: ArrayLike
    ) -> NDArray[np.float64]:
        """Return a surface with the arc of ball and rounded tip over its ends, at a height [mm]."""
        radius = (self.tip.radius if self.tip else 0.0) + self.rounding
        if radius == 0:
            return surface
        steep: NDArray[np.float64] = np.maximum(np.asarray(slope, float), 0.0)
        size = np.hypot(1.0, steep)
        out = np.abs(self.groove.half_width - x)
        arc = (
            np.asarray(end, float)
            - self.rounding * size
            + np.sqrt(np.maximum(radius**2 - out**2, 0.0))
            - (radius - self.rounding)
        )
        return np.where(out < radius * steep / size, arc, surface)

    def _over_tip(self, out: NDArray[np.float64], steep: ArrayLike) -> NDArray[np.float64]:
        """Return the trace of a prism tip alone, at a distance [mm] from its axis."""
        tip = self.tip
        assert tip is not None
        flank = float(np.hypot(1.0, tip.flank_slope))
        radius = tip.radius + self.rounding
        centre = self.groove.depth - self.rounding * np.hypot(1.0, steep)
        arc = np.sqrt(np.maximum(radius**2 - out**2, 0.0))
        line = radius * flank - tip.flank_slope * out
        return centre - tip.radius + np.where(out < radius * tip.flank_slope / flank, arc, line)
