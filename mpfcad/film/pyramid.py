"""The valleys between pyramids as a groove: what a print fills, by volume.

A print gives a film so much resin an area, whatever lies under it. Between pyramids there is room
for 2/3 of their depth, in a groove for half of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.groove import Groove, Profile

_HALVINGS = 60


@dataclass(frozen=True)
class PyramidGroove(Groove):
    """The valleys between filled quadrangular pyramids, z = max(s t, p(t)), t = min(|x|, |y|).

    Fill fractions are shares of the room between the bare pyramids.
    """

    @property
    def area(self) -> float:
        """Room between the pyramids over a pitch, (2/3) depth · pitch [mm²]."""
        return self.room * self.pitch

    @property
    def room(self) -> float:
        """Resin that fills it, over the film's area [mm]: two thirds of the depth."""
        return 2 * self.depth / 3

    def fill_fraction(self, curvature: ArrayLike) -> NDArray[np.float64]:
        """Return the resin's share of the room, 0…1.

        ∫ (p(t) - s t) 2 (1 - t/w) dt/w over 0…ξ, ξ the contact over w, over (2/3) depth: with u =
        C w/(2 s), (3/2) [(1 - u) a - b + u c], a = 2ξ - ξ², b = ξ² - 2ξ³/3, c = 2ξ³/3 - ξ⁴/2.
        """
        u = np.asarray(curvature, float) * self.half_width / (2 * self.wall_slope)
        xi = self.contact_position(curvature) / self.half_width
        resin = (1 - u) * (2 * xi - xi**2) - (xi**2 - 2 * xi**3 / 3)
        return 1.5 * (resin + u * (2 * xi**3 / 3 - xi**4 / 2))

    def curvature_of_fill(self, fill_fraction: ArrayLike) -> NDArray[np.float64]:
        """Return the C [1/mm] of a fill fraction, by bisection to the last digits."""
        fill = np.asarray(fill_fraction, float)
        low, high = np.zeros_like(fill), np.full_like(fill, self.curvature_empty)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            more = self.fill_fraction(middle) > fill
            low, high = np.where(more, middle, low), np.where(more, high, middle)
        return np.where(fill <= 0, self.curvature_empty, (low + high) / 2)

    def mean_height(self, curvature: ArrayLike, profile: Profile = "filled") -> NDArray[np.float64]:
        """Return the surface's mean height [mm] above the valleys' bottom over a cell."""
        if profile == "ideal":
            return self.depth - np.asarray(curvature, float) * self.half_width**2 * 5 / 12
        return self.depth / 3 + self.room * self.fill_fraction(curvature)
