"""The whole film: a row of grooves, one curvature each, on a flat base."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.field.field import CurvatureField, FieldFilm
from mpfcad.film.groove import PROFILES, Groove, Profile
from mpfcad.sound import refuse_unknown, refuse_unsound


@dataclass(frozen=True, eq=False)
class PrismFilm:
    """A prism film with grooves along y; lengths in mm.

    Its underside is z = 0, the valleys of the bare prisms z = base, the tips z = base + depth.
    Tips stand at x = 0, pitch, 2 pitch, … and y runs from 0 to length.

    Attributes
    ----------
    groove
        the bare V groove (pitch, depth)
    base
        thickness below the valleys
    length
        extent along the grooves
    profile
        `filled` or `ideal`
    curvature
        (n,) float64 [1/mm], C through the tips of each groove, left to right
    origin
        position [mm] on the panel of this film's x = 0; 0 for the panel itself
    """

    groove: Groove
    base: float
    length: float
    profile: Profile
    curvature: NDArray[np.float64]
    origin: float = 0.0
    varies_along: ClassVar[bool] = False

    def __post_init__(self) -> None:
        curvature = np.array(self.curvature, dtype=np.float64)
        curvature.flags.writeable = False
        object.__setattr__(self, "curvature", curvature)
        refuse_unknown("film.profile", self.profile, PROFILES)
        refuse_unsound("film.base", self.base, 0.0)
        refuse_unsound("film.length", self.length, 0.0, above=True)
        refuse_unsound("film.origin", self.origin)
        refuse_unsound("film.curvature", curvature, 0.0, self.groove.curvature_most(self.profile))

    @property
    def groove_count(self) -> int:
        """Number of grooves n."""
        return len(self.curvature)

    @property
    def width(self) -> float:
        """Extent across the grooves [mm]."""
        return self.groove_count * self.groove.pitch

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [mm]."""
        return self.width, self.length

    @property
    def thickness(self) -> float:
        """Extent from the underside to the tips [mm]."""
        return self.base + self.groove.depth

    @property
    def tip_position(self) -> NDArray[np.float64]:
        """Tip positions x, (n+1,) float64 [mm]."""
        return np.arange(self.groove_count + 1.0) * self.groove.pitch

    @property
    def groove_position(self) -> NDArray[np.float64]:
        """Groove centres x, (n,) float64 [mm]."""
        return np.arange(0.5, self.groove_count) * self.groove.pitch

    @property
    def content(self) -> tuple[NDArray[np.float64], ...]:
        """The curvature of each groove, (n,) float64 [1/mm]."""
        return (self.curvature,)

    def extremes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return smallest and largest curvature of each groove, (n,) float64 [1/mm]: the same."""
        return self.curvature, self.curvature

    def as_field(self) -> FieldFilm:
        """Return the film as one whose curvature is a field."""
        x, c = self.groove_position, self.curvature
        if len(x) == 1:
            x, c = np.append(x, x + self.groove.pitch), np.append(c, c)
        field = CurvatureField(x, np.array([0.0, self.length]), np.stack([c, c]))
        return FieldFilm(self.groove, self.length, self.groove_count, field, self.profile)

    @property
    def fill_fraction(self) -> NDArray[np.float64]:
        """Fill fraction of each groove, (n,) float64, 0…1."""
        return self.groove.fill_fraction(self.curvature)

    @property
    def resin_height(self) -> NDArray[np.float64]:
        """Resin of each groove over the area that it takes, its mean height, (n,) float64 [mm]."""
        return self.fill_fraction * self.groove.room

    @property
    def fill_volume(self) -> float:
        """Volume of the resin [mm³]."""
        return float(np.sum(self.fill_fraction)) * self.groove.area * self.length

    @property
    def prism_volume(self) -> float:
        """Volume of the prism film under the resin [mm³]."""
        mean = self.groove.prism_mean_height(self.curvature, self.profile)
        return float(np.sum(self.base + mean)) * self.groove.pitch * self.length

    @property
    def bare_volume(self) -> float:
        """Volume of the prisms without resin [mm³]; of a `filled` film."""
        return (self.base + self.groove.depth / 2) * self.width * self.length

    @property
    def volume(self) -> float:
        """Volume of prism film and resin together [mm³]."""
        return self.prism_volume + self.fill_volume

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Return the surface height z [mm] above the underside at x [mm]."""
        x = np.asarray(x, float)
        index = np.clip((x / self.groove.pitch).astype(int), 0, self.groove_count - 1)
        local = x - self.groove_position[index]
        return self.base + self.groove.height(local, self.curvature[index], self.profile)

    def cut(self, first: int, count: int, length: float) -> "PrismFilm":
        """Return the piece of `count` grooves from groove `first` on, `length` mm long."""
        return replace(
            self,
            curvature=self.curvature[first : first + count],
            length=length,
            origin=self.origin + first * self.groove.pitch,
        )
