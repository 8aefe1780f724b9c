"""A film of pyramids or dishes whose curvatures vary from cell to cell, as a library of few cells.

Curvatures are rounded to levels as those of groove pieces are; the library holds each pair of
levels that occurs.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.cell import CellFilm, CellShape
from mpfcad.film.field.library import places_of, refuse_other_curvatures, rounded
from mpfcad.film.groove import Groove, Profile

#: Most different cells of a library.
MOST = 4096


@dataclass(frozen=True, eq=False)
class CellLibrary:
    """Cells of few curvatures, and which stands where; lengths in mm.

    Attributes
    ----------
    groove, base, shape, profile
        as a film of equal cells has them
    curvature
        (k, 2) float64 [1/mm], C of each kind of cell along x and along y
    chosen
        (n, m) int64, the kind at each place along x and y, from the lower left corner
    wanted
        (n, m, 2) float64 [1/mm], the maps that were rounded
    """

    groove: Groove
    base: float
    shape: CellShape
    profile: Profile
    curvature: NDArray[np.float64]
    chosen: NDArray[np.int64]
    wanted: NDArray[np.float64]

    @property
    def length(self) -> float:
        """Size of a cell along y [mm]."""
        return self.groove.pitch

    @property
    def size(self) -> tuple[float, float]:
        """Extent [mm] along x and y."""
        across, along = self.chosen.shape
        return across * self.groove.pitch, along * self.groove.pitch

    @property
    def bare_volume(self) -> float:
        """Volume of the pyramids without resin [mm³]."""
        return self.piece(0).bare_height * self.size[0] * self.size[1]

    @property
    def fill_fraction(self) -> float:
        """Mean fill of the room between the pyramids with resin."""
        volume = np.array([self.piece(number).volume for number in range(len(self.curvature))])
        whole = float(volume[self.chosen].sum()) - self.bare_volume
        return whole / (self.size[0] * self.size[1] * 2 * self.groove.depth / 3)

    def repeated(self, count: tuple[int, int]) -> "CellLibrary":
        """Return the film of so many such films beside each other along x and y."""
        if count == (1, 1):
            return self
        wanted = np.tile(self.wanted, (*count, 1))
        return replace(self, chosen=np.tile(self.chosen, count), wanted=wanted)

    def remapped(self, wanted: NDArray[np.float64], levels: int) -> "CellLibrary":
        """Return the film of other maps of the same shape."""
        return build_cell_library(self.groove, self.base, self.shape, self.profile, wanted, levels)

    def cut(self, count: tuple[int, int]) -> "CellLibrary":
        """Return the window of so many cells at the lower left corner."""
        part = (slice(count[0]), slice(count[1]))
        return replace(self, chosen=self.chosen[part], wanted=self.wanted[part])

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return z [mm] over the underside at (x, y) [mm]."""
        i, k = places_of(self.chosen.shape, self.groove.pitch, self.length, x, y)
        pitch, w = self.groove.pitch, self.groove.half_width
        local = [np.asarray(x, float) - (i + 0.5) * pitch, np.asarray(y, float) - (k + 0.5) * pitch]
        curvature = np.moveaxis(self.curvature[self.chosen[i, k]], -1, 0)
        if self.shape == "pyramid":
            both = zip(local, curvature, strict=True)
            return self.base + np.minimum(
                *(self.groove.height(t, c, self.profile) for t, c in both)
            )
        drop = sum(c / 2 * (w**2 - t**2) for t, c in zip(local, curvature, strict=True))
        return np.asarray(self.base + self.groove.depth - drop, np.float64)

    def piece(self, number: int) -> CellFilm:
        """Return one kind of cell as a film of one cell."""
        across, along = (float(c) for c in self.curvature[number])
        other = None if along == across else along
        return CellFilm(
            self.groove, self.base, self.shape, self.profile, across, (1, 1), other, tip_to_tip=True
        )


def build_cell_library(
    groove: Groove,
    base: float,
    shape: CellShape,
    profile: Profile,
    wanted: NDArray[np.float64],
    levels: int,
) -> CellLibrary:
    """Return the library of maps of curvatures (n, m, 2) [1/mm], each rounded to so many levels.

    Raises
    ------
    InputError
        when a curvature cannot be had, or the library has too many different cells.
    """
    refuse_other_curvatures(wanted, groove.curvature_most(profile))
    across, first = rounded(wanted[..., 0], levels)
    if np.array_equal(wanted[..., 0], wanted[..., 1]):
        pair = np.stack([across, across], axis=1)
        found = CellLibrary(groove, base, shape, profile, pair, first, wanted)
    else:
        along, second = rounded(wanted[..., 1], levels)
        used, chosen = np.unique(first * len(along) + second, return_inverse=True)
        pair = np.stack([across[used // len(along)], along[used % len(along)]], axis=1)
        place = chosen.reshape(first.shape).astype(np.int64)
        found = CellLibrary(groove, base, shape, profile, pair, place, wanted)
    if len(found.curvature) > MOST:
        raise InputError(
            f"map: {len(found.curvature)} different cells: expected at most {MOST}: fewer levels"
        )
    found.piece(int(np.argmax(found.curvature.sum(axis=1))))  # refuses cells that are too deep
    found.piece(int(np.argmax(found.curvature.max(axis=1))))
    return found
