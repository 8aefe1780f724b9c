"""A film as it is made: with its own pitch and prism angle, rounded, or of a measured profile."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.geometry import PrismFilm
from mpfcad.film.groove import Groove
from mpfcad.film.imperfection import Imperfection, build_section
from mpfcad.film.resin import bare_mean_height, curvature_of_resin
from mpfcad.film.section import Section


@dataclass(frozen=True, eq=False)
class MadeFilm:
    """A row of grooves and how it departs from sharp prisms and parabolas.

    Attributes
    ----------
    film
        pitch and depth as made; C through the tips, were they sharp; of a measured surface, the C
        of a groove with as much resin
    imperfection
        radii, the measured surface, or the angle of a resin at rest
    resin_factor
        (n,) float64, resin of each groove over what the mask gives it; None: as much
    """

    film: PrismFilm
    imperfection: Imperfection
    resin_factor: NDArray[np.float64] | None = None

    @property
    def groove(self) -> Groove:
        """The bare groove as made."""
        return self.film.groove

    @property
    def thickness(self) -> float:
        """Extent from the underside to the tips, were they sharp [mm]."""
        return self.film.thickness

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [mm]."""
        return self.film.size

    def section(self, sliver: float | None = None) -> Section:
        """Return its cross-section, parts narrower than `sliver` [mm] merged."""
        options = {} if sliver is None else {"sliver": sliver}
        return build_section(self.film, self.imperfection, **options)

    def with_resin(self, height: NDArray[np.float64]) -> "MadeFilm":
        """Return the film whose grooves hold `height` (n,) [mm] of resin over their area.

        That is what the mask gives; `resin_factor` goes on top. An `ideal` film stays as it is.

        Raises
        ------
        InputError
            when a groove cannot hold so much.
        """
        if self.film.profile == "ideal":
            return self
        given = height if self.resin_factor is None else height * self.resin_factor
        curvature = curvature_of_resin(self.film, self.imperfection, given)
        return replace(self, film=replace(self.film, curvature=curvature))

    @property
    def bare_volume(self) -> float:
        """Volume of the prisms without resin [mm³]; of a `filled` film."""
        mean = bare_mean_height(self.film, self.imperfection)
        return mean * self.film.width * self.film.length

    def cut(self, first: int, count: int, length: float) -> "MadeFilm":
        """Return the piece of `count` grooves from groove `first` on, `length` mm long."""
        factor = self.resin_factor
        part = None if factor is None else factor[first : first + count]
        return replace(self, film=self.film.cut(first, count, length), resin_factor=part)

    def bare_height(self, x: ArrayLike) -> NDArray[np.float64] | None:
        """Return z [mm] of the bare prisms' walls and round valleys at x [mm], tips left sharp.

        None where prism and resin are not known apart: of an `ideal` film and a measured surface.
        """
        film, radius = self.film, self.imperfection.valley_radius
        if film.profile == "ideal" or self.imperfection.measured is not None:
            return None
        x = np.asarray(x, float)
        slope = film.groove.wall_slope
        index = np.clip((x / film.groove.pitch).astype(int), 0, film.groove_count - 1)
        local = np.abs(x - film.groove_position[index])
        # The circle that touches both walls: its centre lies r √(1 + s²) above their corner.
        arc = radius * np.hypot(1, slope) - np.sqrt(np.maximum(radius**2 - local**2, 0.0))
        inside = local < radius * slope / np.hypot(1, slope)
        return film.base + np.where(inside, arc, slope * local)
