"""What a tip traces of a filled groove, in closed form.

Dilation of a maximum is the maximum of the dilations, so the trace of max(walls, parabola) is the
higher of two: the walls', each raised by what the ball needs on a slope, with the ball's own arc
over the prism tips; and the parabola's, where the tip touches at the point of its own slope.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.tip import StylusTip

_NEWTON = 5
#: Curvature times radius from which the touching point is searched for.
_BLUNT = 0.98
#: Contact points tried where a parabola is sharper than the ball, so that it may touch twice.
_TRIED = 257


@dataclass(frozen=True)
class DilatedGroove:
    """A groove under a stylus tip; `rounding` [mm] is the radius of the prism tips themselves."""

    groove: Groove
    profile: Profile = "filled"
    tip: StylusTip | None = None
    rounding: float = 0.0

    def height(self, local: NDArray[np.float64], curvature: ArrayLike) -> NDArray[np.float64]:
        """Return the traced height [mm] at x (n,) [mm] from the groove's centre, -w … w.

        curvature: one [1/mm], or (n,). The height is 0 where the tip's lowest point would be at
        the bare groove's valley.
        """
        radius = self.tip.radius if self.tip else 0.0
        if radius + self.rounding == 0:
            return self.groove.height(local, curvature, self.profile)
        x = np.abs(local)
        surface = self._parabola(x, np.broadcast_to(np.asarray(curvature, float), x.shape))
        if self.profile == "ideal":
            return surface
        return np.maximum(surface, self._walls(x))

    def _walls(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the trace of the bare walls and tips."""
        groove, tip = self.groove, self.tip
        slope = groove.wall_slope
        if tip is not None and slope > tip.flank_slope:
            # The cone touches the prism tips only.
            return self._over_tip(groove.half_width - x)
        raised = slope * x + self._lift(slope)
        return self._rounded(raised, x, slope)

    def _parabola(
        self, x: NDArray[np.float64], curvature: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the trace of the parabola through both tips, between them."""
        groove, tip = self.groove, self.tip
        half = groove.half_width
        if tip is None:
            surface = groove.height(x, curvature, "ideal")
            return self._rounded(surface, x, curvature * half)
        touch = self._touch(x, np.minimum(curvature, _BLUNT / max(tip.radius, 1e-12)))
        sharp = curvature * tip.radius > _BLUNT
        if np.any(sharp):
            touch = touch.copy()
            touch[sharp] = self._touch_of_sharp(x[sharp], curvature[sharp])
        inside = np.clip(touch, -half, half)
        surface = groove.height(inside, curvature, "ideal") - tip.height(inside - x)
        return self._rounded(surface, x, np.minimum(curvature * half, tip.flank_slope))

    def _touch(self, x: NDArray[np.float64], curvature: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where on the parabola a tip over x touches: its slope there is the tip's."""
        tip = self.tip
        assert tip is not None
        steepest = np.minimum(
            tip.flank_slope / np.maximum(curvature, 1e-12), 10 * self.groove.half_width
        )
        touch = np.minimum(x / (1 - curvature * tip.radius * 0.9), steepest)
        for _ in range(_NEWTON):
            slope = curvature * touch
            size = np.hypot(1.0, slope)
            gap = touch - tip.radius * slope / size - x
            touch = touch - gap / (1 - tip.radius * curvature / size**3)
        # Steeper than the cone: its flank touches where the parabola has its slope.
        return np.clip(touch, 0.0, steepest)

    def _touch_of_sharp(
        self, x: NDArray[np.float64], curvature: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the same of a parabola sharper than the ball, which may touch it twice."""
        groove, tip = self.groove, self.tip
        assert tip is not None
        tried = np.linspace(-groove.half_width, groove.half_width, _TRIED)
        level = groove.height(tried[None], curvature[:, None], "ideal")
        at = np.argmax(level - tip.height(tried[None] - x[:, None]), axis=1)
        return tried[at]

    def _lift(self, slope: float) -> float:
        """Return how much higher a ball runs over a plane of a slope than the plane itself."""
        radius = self.tip.radius if self.tip else 0.0
        return radius * (float(np.hypot(1.0, slope)) - 1)

    def _rounded(
        self, surface: NDArray[np.float64], x: NDArray[np.float64], slope: ArrayLike
    ) -> NDArray[np.float64]:
        """Return a surface with the arc of ball and rounded tip over the prism tips."""
        radius = (self.tip.radius if self.tip else 0.0) + self.rounding
        if radius == 0:
            return surface
        steep: NDArray[np.float64] = np.maximum(np.asarray(slope, float), 0.0)
        size = np.hypot(1.0, steep)
        out = np.abs(self.groove.half_width - x)
        arc = (
            self.groove.depth
            - self.rounding * size
            + np.sqrt(np.maximum(radius**2 - out**2, 0.0))
            - (radius - self.rounding)
        )
        return np.where(out < radius * steep / size, arc, surface)

    def _over_tip(self, out: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the trace of a prism tip alone, at a distance [mm] from its axis."""
        tip = self.tip
        assert tip is not None
        flank = float(np.hypot(1.0, tip.flank_slope))
        radius = tip.radius + self.rounding
        centre = self.groove.depth - self.rounding * float(np.hypot(1.0, self.groove.wall_slope))
        arc = np.sqrt(np.maximum(radius**2 - out**2, 0.0))
        line = radius * flank - tip.flank_slope * out
        return centre - tip.radius + np.where(out < radius * tip.flank_slope / flank, arc, line)
