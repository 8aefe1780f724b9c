"""Menisci of any shape that resin at rest may have in a groove: where and how it meets the walls.

The surface leaves the walls at ±a with the slope p, and is of the shape

    z(x) = s a - (1 - k - q) (S_0(a) - S_0(x)) - k (S_1(a) - S_1(x)) - q (S_2(a) - S_2(x)),

S_0 the parabola, S_1 the circle and S_2 the fourth power of that slope at a; k the roundness, q the
flatness. The resin below has the area a² (s - g), g(p, k, q) = (1 - k - q) 2p/3 + k g_1(atan p) +
q 2p/5 (g_1: `film.meniscus.segment_share`), so that a follows from p and the fill, and p from a and
the fill. Of a fill, the lowest a is that of level resin, and the highest that of resin that runs
along the walls, or up to the tips. The wetting tells where between them it is: 0 at the lowest, 1
at the highest.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.groove import Groove, Profile

#: How near 0 and 1 a fill may come.
_LEAST = 1e-9
_UNIT = Groove(2.0, 1.0)  # slope and half width 1: C is u


@dataclass(frozen=True, eq=False)
class Meniscus:
    """Those of some grooves, (m,) float64.

    Attributes
    ----------
    contact, level
        half width [mm] up to which resin lies, and its height [mm] there above the valley
    slope
        of its surface there
    roundness
        0: a parabola, 1: a circle
    flatness
        0: a parabola, 1: a fourth power, as of resin that dried
    """

    contact: NDArray[np.float64]
    level: NDArray[np.float64]
    slope: NDArray[np.float64]
    roundness: float = 0.0
    flatness: float = 0.0

    @classmethod
    def through_tips(cls, groove: Groove, curvature: ArrayLike, profile: Profile) -> "Meniscus":
        """Return the parabolas of curvatures [1/mm] through both tips."""
        curvature = np.atleast_1d(np.asarray(curvature, float))
        contact = np.full(curvature.shape, groove.half_width)
        if profile == "filled":
            contact = np.maximum(groove.contact_position(curvature), _LEAST * groove.half_width)
        level = groove.depth - groove.wall_slope * (groove.half_width - contact)
        return cls(contact, level, curvature * contact)

    @classmethod
    def holding(
        cls,
        groove: Groove,
        u: NDArray[np.float64],
        above: float,
        roundness: float,
        flatness: float = 0.0,
    ) -> "Meniscus":
        """Return menisci with the fill of parabolas through the tips, (m,).

        u: C·w/slope of those. above: by how much their wetting is above that of those.
        """
        from mpfcad.film.stylus.kernel import hold

        fill = np.clip(_UNIT.fill_fraction(u), _LEAST, 1 - _LEAST)
        part, slope, steep = np.empty_like(fill), np.empty_like(fill), groove.wall_slope
        hold(fill, _UNIT.contact_position(u), above, roundness, flatness, steep, part, slope)
        contact = part * groove.half_width
        return cls(contact, steep * contact, slope, roundness, flatness)
