"""Films of equal cells in both directions, for backlights with points of light instead of lamps.

With p the profile of a groove (tips at ±w, valley at 0):

* `pyramid`: z = min(p(x), p(y)), quadrangular pyramids with concave faces around each tip;
* `paraboloid`: z = depth - C/2 (w² - x²) - C/2 (w² - y²), dishes with tips at the cells' corners.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import PROFILES, Groove, Profile
from mpfcad.sound import refuse_unknown, refuse_unsound

CellShape = Literal["pyramid", "paraboloid"]


@dataclass(frozen=True)
class CellFilm:
    """Equal cells on a square lattice, in mm; pyramids have their tips in the cells' middle.

    Attributes
    ----------
    groove
        pitch of the lattice, and depth
    base
        thickness below the bare valleys
    shape, profile
        `pyramid` with either profile; `paraboloid` with the ideal one
    curvature
        C through the tips [1/mm]
    count
        number of cells along x and y
    """

    groove: Groove
    base: float
    shape: CellShape
    profile: Profile
    curvature: float
    count: tuple[int, int]

    def __post_init__(self) -> None:
        refuse_unknown("film.cell", self.shape, get_args(CellShape))
        refuse_unknown("film.profile", self.profile, PROFILES)
        refuse_unsound("film.base", self.base, 0.0)
        refuse_unsound("film.count", self.count, 1)
        most = self.groove.curvature_most(self.profile)
        refuse_unsound("film.curvature", self.curvature, 0.0, most)
        if self.shape == "paraboloid" and self.profile != "ideal":
            raise InputError("film: cell paraboloid: profile filled: expected 'ideal', a mould's")
        if not self.lowest > 0:
            raise InputError(
                f"film: curvature {self.curvature:g} /mm: cells cut through the underside: "
                f"expected below {self._curvature_limit():.6g} /mm"
            )

    @property
    def thickness(self) -> float:
        """Height of the tips [mm]."""
        return self.base + self.groove.depth

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [mm]."""
        return self.count[0] * self.groove.pitch, self.count[1] * self.groove.pitch

    @property
    def lowest(self) -> float:
        """Height of the lowest place [mm]."""
        drop = self.curvature / 2 * self.groove.half_width**2
        if self.shape == "paraboloid":
            return self.thickness - 2 * drop
        if self.profile == "filled":
            drop = min(drop, self.groove.depth)
        return self.thickness - drop

    def _curvature_limit(self) -> float:
        share = 1 if self.shape == "paraboloid" else 2
        return share * self.thickness / self.groove.half_width**2

    @property
    def mean_height(self) -> float:
        """Mean height of the surface [mm].

        Of a pyramid ∫ p(w t) 2 (1 - t) dt over 0…1, as t = min(|x|, |y|)/w has that density.
        """
        w, drop = self.groove.half_width, self.curvature * self.groove.half_width**2
        if self.shape == "paraboloid":
            return self.thickness - 2 / 3 * drop
        reach = 1.0
        if self.profile == "filled":
            reach = float(self.groove.contact_position(self.curvature)) / w
        # Of (1 - t)(1 - t²) and of t (1 - t), from 0 and to 1.
        resin = reach - reach**2 / 2 - reach**3 / 3 + reach**4 / 4
        share = 2 * reach - reach**2
        wall = 2 * ((1 - reach**2) / 2 - (1 - reach**3) / 3)
        depth = self.groove.depth
        return self.base + depth * share - drop * resin + depth * wall

    @property
    def volume(self) -> float:
        """Volume [mm³]."""
        return self.mean_height * self.size[0] * self.size[1]

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return z [mm] over the underside at (x, y) [mm]."""
        local = self.local(x, y)
        if self.shape == "pyramid":
            nearer = np.min(np.abs(local), axis=0)
            return self.base + self.groove.height(nearer, self.curvature, self.profile)
        drop = self.curvature / 2 * (2 * self.groove.half_width**2 - np.sum(local**2, axis=0))
        return self.thickness - drop

    def slope(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return (dz/dx, dz/dy), (2, …), at (x, y) [mm]."""
        local = self.local(x, y)
        if self.shape == "paraboloid":
            return self.curvature * local
        slope = self.groove.slope(local, self.curvature, self.profile)
        across = np.abs(local[0]) < np.abs(local[1])
        return np.where(np.stack([across, ~across]), slope, 0.0)

    def local(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return (x, y), (2, …) [mm], from the nearest valley."""
        pitch, w = self.groove.pitch, self.groove.half_width
        # A pyramid's valleys lie on the cells' edges, a paraboloid's in the middle.
        shift = w if self.shape == "paraboloid" else 0.0
        place = np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)))
        return (place - shift + w) % pitch - w
