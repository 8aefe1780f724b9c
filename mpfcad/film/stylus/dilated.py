"""What a tip traces of a filled groove, in closed form.

Dilation of a maximum is the maximum of the dilations, so the trace of walls and resin is the
higher of two: the walls', each raised by what the ball needs on a slope, with the ball's own arc
over the prism tips; and the resin's, where the tip touches at the point of its own slope.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.meniscus import Meniscus
from mpfcad.film.stylus.tip import StylusTip


@dataclass(frozen=True)
class DilatedGroove:
    """A groove under a stylus tip; `rounding` [mm] is the radius of the prism tips themselves."""

    groove: Groove
    profile: Profile = "filled"
    tip: StylusTip | None = None
    rounding: float = 0.0

    def height(self, local: NDArray[np.float64], curvature: float) -> NDArray[np.float64]:
        """Return the traced height [mm] at x (n,) [mm] from the groove's centre, -w … w.

        curvature: [1/mm], of the parabola through the tips. The height is 0 where the tip's lowest
        point would be at the bare groove's valley.
        """
        if self.tip is None and self.rounding == 0:
            return self.groove.height(local, curvature, self.profile)
        return self.over(local, Meniscus.through_tips(self.groove, curvature, self.profile))

    def over(
        self,
        local: NDArray[np.float64],
        meniscus: Meniscus,
        number: NDArray[np.int64] | None = None,
        touch: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return the same of resin of any meniscus.

        number: which of the menisci lies at each place, (n,); None: the first. touch: where the tip
        touches the resin, (n,) [mm], if known.
        """
        return self._traced(local, meniscus, number, touch)[0]

    def touch(
        self, local: NDArray[np.float64], meniscus: Meniscus, number: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return where [mm] on the resin a tip over x, (n,), touches: its slope there is the tip's.

        A cone that is less steep than the resin touches where the resin has its slope.
        """
        return self._traced(local, meniscus, number, None)[1]

    def _traced(
        self,
        local: NDArray[np.float64],
        meniscus: Meniscus,
        number: NDArray[np.int64] | None,
        touch: NDArray[np.float64] | None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the traced heights, and where the tip touches the resin."""
        from mpfcad.film.stylus.kernel import trace

        groove, tip = self.groove, self.tip
        x = np.ascontiguousarray(local, float)
        known, height = touch is not None, np.empty(len(x))
        touch = np.empty(len(x)) if touch is None else touch
        trace(
            x,
            np.zeros(len(x), np.int64) if number is None else number,
            meniscus.contact,
            meniscus.level,
            meniscus.slope,
            float(meniscus.roundness),
            float(meniscus.flatness),
            (groove.half_width, groove.depth, groove.wall_slope),
            self.profile == "ideal",
            (float(tip.radius), tip.flank_slope, self.rounding)
            if tip
            else (0.0, math.inf, self.rounding),
            touch,
            known,
            height,
        )
        return height, touch
