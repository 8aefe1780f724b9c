"""Films of equal cells in both directions, for backlights with points of light instead of lamps.

With p the profile of a groove (tips at ±w, valley at 0):

* `pyramid`: z = min(p(x), p(y)), quadrangular pyramids with concave faces around each tip;
* `paraboloid`: z = depth - C/2 (w² - x²) - C/2 (w² - y²), dishes with tips at the cells' corners.

The faces that rise along y may have a curvature of their own.
"""

from dataclasses import dataclass
from itertools import pairwise
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
        C through the tips [1/mm]; with `along`, that of the profile along x alone
    count
        number of cells along x and y
    along
        C of the profile along y; None: the same
    tip_to_tip
        whether pyramids, too, have their valleys in the cells' middle and their tips on the
        corners, as the cells of a map have them
    """

    groove: Groove
    base: float
    shape: CellShape
    profile: Profile
    curvature: float
    count: tuple[int, int]
    along: float | None = None
    tip_to_tip: bool = False

    def __post_init__(self) -> None:
        refuse_unknown("film.cell", self.shape, get_args(CellShape))
        refuse_unknown("film.profile", self.profile, PROFILES)
        refuse_unsound("film.base", self.base, 0.0)
        refuse_unsound("film.count", self.count, 1)
        most = self.groove.curvature_most(self.profile)
        for curvature in self.both:
            refuse_unsound("film.curvature", curvature, 0.0, most)
        if self.shape == "paraboloid" and self.profile != "ideal":
            raise InputError("film: cell paraboloid: profile filled: expected 'ideal', a mould's")
        if not self.lowest > 0:
            raise InputError(
                f"film: curvature {max(self.both):g} /mm: cells cut through the underside: "
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
    def both(self) -> tuple[float, float]:
        """C of the profiles along x and along y [1/mm]."""
        return self.curvature, self.curvature if self.along is None else self.along

    @property
    def lowest(self) -> float:
        """Height of the lowest place [mm]."""
        drops = [curvature / 2 * self.groove.half_width**2 for curvature in self.both]
        if self.shape == "paraboloid":
            return self.thickness - sum(drops)
        if self.profile == "filled":
            drops = [min(drop, self.groove.depth) for drop in drops]
        return self.thickness - max(drops)

    def _curvature_limit(self) -> float:
        share = 1 if self.shape == "paraboloid" else 2
        return share * self.thickness / self.groove.half_width**2

    @property
    def bare_height(self) -> float:
        """Mean height of bare pyramids [mm]; a third of their depth over the base."""
        return self.base + self.groove.depth / 3

    @property
    def mean_height(self) -> float:
        """Mean height of the surface [mm].

        Of a pyramid of one curvature ∫ p(w t) 2 (1 - t) dt over 0…1, as t = min(|x|, |y|)/w has
        that density; of two, `mean_of_lower`.
        """
        w, depth = self.groove.half_width, self.groove.depth
        if self.shape == "paraboloid":
            return self.thickness - sum(self.both) * w**2 / 3
        if self.both[0] != self.both[1]:
            return self.base + mean_of_lower(self.groove, self.profile, self.both)
        drop = self.curvature * w**2
        reach = 1.0
        if self.profile == "filled":
            reach = float(self.groove.contact_position(self.curvature)) / w
        # Of (1 - t)(1 - t²) and of t (1 - t), from 0 and to 1.
        resin = reach - reach**2 / 2 - reach**3 / 3 + reach**4 / 4
        share = 2 * reach - reach**2
        wall = 2 * ((1 - reach**2) / 2 - (1 - reach**3) / 3)
        return self.base + depth * share - drop * resin + depth * wall

    @property
    def volume(self) -> float:
        """Volume [mm³]."""
        return self.mean_height * self.size[0] * self.size[1]

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return z [mm] over the underside at (x, y) [mm]."""
        along_x, along_y = np.abs(self.local(x, y))
        if self.shape == "pyramid":
            profiles = [
                self.groove.height(at, curvature, self.profile)
                for at, curvature in zip((along_x, along_y), self.both, strict=True)
            ]
            return self.base + np.minimum(*profiles)
        w = self.groove.half_width
        room = (w**2 - along_x**2, w**2 - along_y**2)
        return self.thickness - (self.both[0] * room[0] + self.both[1] * room[1]) / 2

    def slope(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return (dz/dx, dz/dy), (2, …), at (x, y) [mm]."""
        local = self.local(x, y)
        curvature = np.reshape(self.both, (2,) + (1,) * (local.ndim - 1))
        if self.shape == "paraboloid":
            return curvature * local
        slope = self.groove.slope(local, curvature, self.profile)
        height = self.groove.height(local, curvature, self.profile)
        across = height[0] < height[1]
        return np.where(np.stack([across, ~across]), slope, 0.0)

    def local(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return (x, y), (2, …) [mm], from the nearest valley."""
        pitch, w = self.groove.pitch, self.groove.half_width
        # A pyramid's valleys lie on the cells' edges, a paraboloid's in the middle.
        shift = w if self.shape == "paraboloid" or self.tip_to_tip else 0.0
        place = np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)))
        return (place - shift + w) % pitch - w


def mean_of_lower(groove: Groove, profile: Profile, curvature: tuple[float, float]) -> float:
    """Return the mean of min(p(x), q(y)) [mm] over a cell, p and q profiles of both curvatures.

    ∫ (1 - ξ(z)) (1 - η(z)) dz over z from the lowest place to the tips, on top of that place: the
    share of the cell that lies above z, ξ and η where p and q come to z, over w. By Gauss's rule
    between the heights at which a profile begins or turns into its wall; z = a + (b - a) v² takes
    the roots away.
    """
    starts = [float(groove.height(0.0, c, profile)) for c in curvature]
    breaks = [*starts, groove.depth]
    if profile == "filled":
        breaks += [float(groove.contact_position(c)) * groove.wall_slope for c in curvature]
    place, weight = np.polynomial.legendre.leggauss(48)
    place, weight = (place + 1) / 2, weight / 2
    total = min(starts)
    edges = np.unique(np.clip(breaks, total, groove.depth))
    for low, high in pairwise(edges):
        z = low + (high - low) * place**2
        open_share = np.prod([1 - reach_of(groove, profile, c, z) for c in curvature], axis=0)
        total += float(np.sum(weight * 2 * place * (high - low) * open_share))
    return total


def reach_of(
    groove: Groove, profile: Profile, curvature: float, z: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return at which |x| over w, 0…1, a profile comes to the height z [mm] over the valley."""
    drop = curvature / 2 * groove.half_width**2
    inner = 1 - np.divide(groove.depth - z, drop, out=np.full_like(z, np.inf), where=drop > 0)
    reach = np.sqrt(np.clip(inner, 0.0, 1.0))
    return np.minimum(reach, z / groove.depth) if profile == "filled" else reach
