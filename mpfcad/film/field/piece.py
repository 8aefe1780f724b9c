"""A window of a film whose curvature varies along the grooves too: what can be drawn of one.

Across, each groove has the curvature at its centre, as everywhere; along, it is linear between the
field's nodes. So the surface is the parabola z = thickness - C(y)/2 (w² - x²) of each place, of
second degree in x and first in y between two nodes; where it meets the wall, at 2 s/C(y) - w, the
contact line is a hyperbola in the wall's plane.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.field.field import FieldFilm, bracket
from mpfcad.film.groove import PROFILES, Groove, Profile
from mpfcad.sound import refuse_unknown, refuse_unsound

#: A curvature [1/mm] this near to where walls or resin vanish is taken to be there: parts of 6 nm.
THRESHOLD_ROOM = 0.005
#: Ends whose curvatures differ by less [1/mm] are made equal, so that the piece repeats.
END_ROOM = 1e-6
#: Decimals of a place [mm] where walls begin to show.
PLACE_DECIMALS = 5
#: Nodes nearer [mm] to an end are taken for it.
NODE_ROOM = 1e-6


@dataclass(frozen=True, eq=False)
class FieldPiece:
    """Some grooves of a film, a stretch of them; x and y from the lower left corner, in mm.

    Attributes
    ----------
    groove, base, profile
        as of the film
    origin
        (x, y) [mm] on the panel of the lower left corner, which is on a tip
    along
        (k,) float64 [mm], from 0 to the length, where curvatures are given
    curvature
        (n, k) float64 [1/mm], C through the tips of each groove there, linear between
    """

    groove: Groove
    base: float
    profile: Profile
    origin: tuple[float, float]
    along: NDArray[np.float64]
    curvature: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("along", "curvature"):
            values = np.array(getattr(self, name), dtype=np.float64)
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        refuse_unknown("film.profile", self.profile, PROFILES)
        refuse_unsound("film.base", self.base, 0.0)
        most = self.groove.curvature_most(self.profile)
        refuse_unsound("film.curvature", self.curvature, 0.0, most)
        limit = 2 * self.thickness / self.groove.half_width**2
        top = float(self.curvature.max())
        if self.profile == "ideal" and top >= limit:
            raise InputError(
                f"film: curvature {top:g} /mm: a groove cuts through the underside: expected below "
                f"{limit:.6g} /mm"
            )

    @property
    def groove_count(self) -> int:
        """Number of grooves n."""
        return len(self.curvature)

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [mm]."""
        return self.groove_count * self.groove.pitch, float(self.along[-1])

    @property
    def thickness(self) -> float:
        """Height of the tips [mm]."""
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
    def has_equal_ends(self) -> bool:
        """Whether both ends have the same cross-section, as of a piece that repeats along."""
        return bool(np.array_equal(self.curvature[:, 0], self.curvature[:, -1]))

    @property
    def steepest(self) -> float:
        """Largest |dz/dx| of the surface."""
        parabola = float(self.curvature.max()) * self.groove.half_width
        return max(parabola, self.groove.wall_slope) if self.profile == "filled" else parabola

    @property
    def volume(self) -> float:
        """Volume [mm³]: closed form across, Gauss's rule along (exact to rounding)."""
        place, weight = np.polynomial.legendre.leggauss(12)
        total = 0.0
        for row in self.curvature:
            along, curvature = self.split(row)
            span, middle = np.diff(along) / 2, (curvature[:-1] + curvature[1:]) / 2
            node = middle + np.outer(place, np.diff(curvature) / 2)
            total += float(np.sum(weight @ (span * self.groove.mean_height(node, self.profile))))
        return (total + self.base * self.size[1] * self.groove_count) * self.groove.pitch

    @property
    def bare_volume(self) -> float:
        """Volume of the prisms without resin [mm³]; of a `filled` film."""
        width, length = self.size
        return (self.base + self.groove.depth / 2) * width * length

    def split(self, row: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return y [mm] and C [1/mm] of one groove where it bends, or its walls begin to show.

        `row` is the groove's row of `curvature`. Nodes on a straight line between their neighbours
        are left out.
        """
        rate = np.diff(row) / np.diff(self.along)
        size = np.abs(row).max() + 1.0
        bends = np.abs(np.diff(rate)) * np.diff(self.along)[1:] > 1e-12 * size
        kept = np.concatenate([[True], bends, [True]])
        along, row = self.along[kept], row[kept]
        limit = self.groove.curvature_covered
        crossing = (row[:-1] - limit) * (row[1:] - limit) < 0
        if self.profile == "ideal" or not crossing.any():
            return along, row
        share = (limit - row[:-1][crossing]) / np.diff(row)[crossing]
        low, high = along[:-1][crossing], along[1:][crossing]
        extra = low + share * (high - low)
        # Neighbouring grooves with next to the same curvature shall have the same places.
        rounded = np.round(extra, PLACE_DECIMALS)
        extra = np.where((rounded > low) & (rounded < high), rounded, extra)
        order = np.argsort(np.concatenate([along, extra]), kind="stable")
        return (
            np.concatenate([along, extra])[order],
            np.concatenate([row, np.full(len(extra), limit)])[order],
        )

    def contact(self, curvature: ArrayLike) -> NDArray[np.float64]:
        """Return |x| [mm] from a groove's centre up to which its surface is the parabola."""
        if self.profile == "ideal":
            return np.full(np.shape(curvature), self.groove.half_width)
        return self.groove.contact_position(curvature)

    def curvature_at(self, groove: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return C [1/mm] of a groove (counted from 0) at y [mm]."""
        number = np.asarray(groove)
        index, weight = bracket(self.along, y)
        low, high = self.curvature[number, index], self.curvature[number, index + 1]
        return np.where(weight == 1, high, low + weight * (high - low))

    def local(self, x: ArrayLike) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the groove at x [mm], and how far x lies from its centre [mm]."""
        x = np.asarray(x, float)
        groove = np.clip((x / self.groove.pitch).astype(int), 0, self.groove_count - 1)
        return groove, x - self.groove_position[groove]

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return z [mm] over the underside at (x, y) [mm]."""
        groove, local = self.local(x)
        curvature = self.curvature_at(groove, y)
        return self.base + self.groove.height(local, curvature, self.profile)


def cut_piece(
    film: FieldFilm, first: int, count: int, start: float, length: float, base: float
) -> FieldPiece:
    """Return `count` grooves from groove `first` on, from y = `start` on, `length` long [mm]."""
    centre = film.groove_position[first : first + count]
    node = film.field.along - start
    inside = node[(node > NODE_ROOM) & (node < length - NODE_ROOM)]
    along = np.concatenate([[0.0], inside, [length]])
    index, weight = bracket(film.field.along, along + start)
    node = film.field.on_grooves(centre)
    curvature = node[:, index] + weight * (node[:, index + 1] - node[:, index])
    if film.profile == "filled":
        for limit in (film.groove.curvature_covered, film.groove.curvature_empty):
            curvature[np.abs(curvature - limit) < THRESHOLD_ROOM] = limit
    if np.abs(curvature[:, -1] - curvature[:, 0]).max() < END_ROOM:
        curvature[:, -1] = curvature[:, 0]
    origin = (first * film.groove.pitch, start)
    return FieldPiece(film.groove, base, film.profile, origin, along, curvature)
