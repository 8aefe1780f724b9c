"""Menisci of any shape that resin at rest may have in a groove: where and how it meets the walls.

The surface leaves the walls at ±a with the slope p, and is of the shape

    z(x) = s a - (1 - k) (S_0(a) - S_0(x)) - k (S_1(a) - S_1(x)),

S_0 the parabola and S_1 the circle of that slope at a, k the roundness. The resin below has the
area a² (s - g), g(p, k) = (1 - k) 2p/3 + k g_1(atan p) (g_1: `segment_share`), so that a follows
from p and the fill, and p from a and the fill. Of a fill, the lowest a is that of level resin, and
the highest that of resin that runs along the walls, or up to the tips. The wetting tells where
between them it is: 0 at the lowest, 1 at the highest.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.meniscus import segment_share

#: Steps of Newton's method, and how near 0 and 1 a fill may come.
_NEWTON, _LEAST = 5, 1e-9
_UNIT = Groove(2.0, 1.0)  # slope and half width 1: C is u


@dataclass(frozen=True, eq=False)
class Meniscus:
    """One, or one at each of (n,) places: float64 arrays that broadcast.

    Attributes
    ----------
    contact, level
        half width [mm] up to which resin lies, and its height [mm] there above the valley
    slope
        of its surface there
    roundness
        0: a parabola, 1: a circle
    """

    contact: NDArray[np.float64]
    level: NDArray[np.float64]
    slope: NDArray[np.float64]
    roundness: float = 0.0

    @classmethod
    def through_tips(cls, groove: Groove, curvature: ArrayLike, profile: Profile) -> "Meniscus":
        """Return the parabola of a curvature [1/mm] through both tips."""
        curvature = np.asarray(curvature, float)
        contact = np.full(curvature.shape, groove.half_width)
        if profile == "filled":
            contact = np.maximum(groove.contact_position(curvature), _LEAST * groove.half_width)
        level = groove.depth - groove.wall_slope * (groove.half_width - contact)
        return cls(contact, level, curvature * contact)

    @classmethod
    def holding(
        cls, groove: Groove, u: NDArray[np.float64], above: float, roundness: float
    ) -> "Meniscus":
        """Return menisci with the fill of parabolas through the tips, (n,).

        u: C·w/slope of those. above: by how much their wetting is above that of those.
        """
        fill = np.clip(_UNIT.fill_fraction(u), _LEAST, 1 - _LEAST)
        level = np.sqrt(fill)
        own = _UNIT.contact_position(u)
        through = (own - level) / (np.minimum(np.sqrt(3 * fill), 1.0) - level)
        wetting = np.clip(through + above, 0.0, 1.0)
        steep = groove.wall_slope
        along = np.minimum(np.sqrt(fill / (1 - _share(np.asarray(steep), roundness) / steep)), 1.0)
        part = level + wetting * (along - level)
        slope = _slope_of(steep * (1 - fill / part**2), steep, roundness)
        contact = part * groove.half_width
        return cls(contact, steep * contact, slope, roundness)

    def of(self, number: NDArray[np.int64]) -> "Meniscus":
        """Return those of the grooves of some places, (n,)."""
        return Meniscus(
            self.contact[number], self.level[number], self.slope[number], self.roundness
        )

    def height(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the height [mm] above the valley at |x| up to the contact."""
        drop = (self.contact - x) * (self.contact + x)
        below = (1 - self.roundness) * self.slope / (2 * self.contact) * drop
        if self.roundness:
            bend = self.bend
            below = below + self.roundness * bend * drop / (
                np.sqrt(1 - (bend * x) ** 2) + np.sqrt(1 - (bend * self.contact) ** 2)
            )
        height: NDArray[np.float64] = self.level - below
        return height

    @cached_property
    def bend(self) -> NDArray[np.float64]:
        """The circle's curvature [1/mm]."""
        bend: NDArray[np.float64] = self.slope / (np.hypot(1.0, self.slope) * self.contact)
        return bend

    def steepness(self, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return slope and second derivative [1/mm] at |x| up to the contact."""
        straight = (1 - self.roundness) * self.slope / self.contact
        if not self.roundness:
            return straight * x, np.broadcast_to(straight, x.shape)
        bend = self.bend
        up = 1 / np.sqrt(1 - (bend * x) ** 2)
        round_ = self.roundness * bend * up
        return (straight + round_) * x, straight + round_ * up**2

    def reach(self, steepest: float) -> NDArray[np.float64]:
        """Return up to which |x| [mm] the surface is no steeper than a slope."""
        if np.all(self.slope <= steepest):
            return self.contact
        x = self.contact
        for _ in range(_NEWTON):  # convex: from the contact down to the root
            slope, second = self.steepness(x)
            x = np.minimum(x, np.maximum(x - (slope - steepest) / np.maximum(second, 1e-12), 0.0))
        return np.where(self.slope <= steepest, self.contact, x)


def _share(slope: NDArray[np.float64], roundness: float) -> NDArray[np.float64]:
    """Return the area between chord and meniscus over a²."""
    return (1 - roundness) * 2 * slope / 3 + roundness * segment_share(np.arctan(slope))


def _slope_of(share: NDArray[np.float64], steep: float, roundness: float) -> NDArray[np.float64]:
    """Return the slope at the contact of an area between chord and meniscus over a², (n,)."""
    share = np.maximum(share, _LEAST)
    slope = 1.5 * share
    for _ in range(_NEWTON if roundness else 0):
        angle = np.arctan(slope)
        round_ = segment_share(angle)
        found = (1 - roundness) * 2 * slope / 3 + roundness * round_
        # dg₁/dβ = 2 - 2 g₁ cot β, dβ/dp = cos² β
        rate = (1 - roundness) * 2 / 3 + roundness * 2 * (1 - round_ / slope) * np.cos(angle) ** 2
        slope = np.clip(slope - (found - share) / rate, _LEAST, 2 * steep)
    return np.minimum(slope, steep)
