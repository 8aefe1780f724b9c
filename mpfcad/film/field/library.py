"""A film whose curvature varies in both directions as a library: few curvatures, and their places.

Curvatures are rounded to levels of equal steps. What rounding leaves is handed on to the pieces
that follow (error diffusion; Floyd and Steinberg, 1976), so means over many pieces are kept. A map
that is its own mirror image stays so: a quarter is rounded and mirrored.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.groove import Groove

#: Shares of what is left that go on: across, and to the three next along.
_SHARES = ((0, 1, 7 / 16), (1, -1, 3 / 16), (1, 0, 5 / 16), (1, 1, 1 / 16))


@dataclass(frozen=True, eq=False)
class PieceLibrary:
    """Groove pieces of few curvatures, and which stands where; lengths in mm.

    Attributes
    ----------
    groove, base
        the bare V groove; thickness below the valleys
    length
        of a piece along the groove
    curvature
        (k,) float64 [1/mm], C through the tips of each piece
    chosen
        (n, m) int64, the piece at each place across and along, from the lower left corner
    wanted
        (n, m) float64 [1/mm], the map that was rounded
    """

    groove: Groove
    base: float
    length: float
    curvature: NDArray[np.float64]
    chosen: NDArray[np.int64]
    wanted: NDArray[np.float64]

    @property
    def size(self) -> tuple[float, float]:
        """Extent [mm] across and along."""
        across, along = self.chosen.shape
        return across * self.groove.pitch, along * self.length

    @property
    def bare_volume(self) -> float:
        """Volume of the prisms without resin [mm³]."""
        width, length = self.size
        return (self.base + self.groove.depth / 2) * width * length

    @property
    def fill_fraction(self) -> float:
        """Mean fill of the grooves with resin."""
        fill = self.groove.fill_fraction(self.curvature)
        return float(np.mean(np.asarray(fill)[self.chosen]))

    def repeated(self, count: tuple[int, int]) -> "PieceLibrary":
        """Return the film of so many such films beside each other along x and y."""
        if count == (1, 1):
            return self
        return replace(self, chosen=np.tile(self.chosen, count), wanted=np.tile(self.wanted, count))

    def remapped(self, wanted: NDArray[np.float64], levels: int) -> "PieceLibrary":
        """Return the film of another map of the same shape."""
        return build_library(self.groove, self.base, self.length, wanted, levels)

    def cut(self, count: tuple[int, int]) -> "PieceLibrary":
        """Return the window of so many pieces at the lower left corner."""
        part = (slice(count[0]), slice(count[1]))
        return replace(self, chosen=self.chosen[part], wanted=self.wanted[part])

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return z [mm] over the underside at (x, y) [mm]."""
        i, k = places_of(self.chosen.shape, self.groove.pitch, self.length, x, y)
        local = np.asarray(x, float) - (i + 0.5) * self.groove.pitch
        return self.base + self.groove.height(local, self.curvature[self.chosen[i, k]])

    def piece(self, number: int) -> PrismFilm:
        """Return one piece as a film of one groove."""
        curvature = np.array([self.curvature[number]])
        return PrismFilm(self.groove, self.base, self.length, "filled", curvature)


def build_library(
    groove: Groove, base: float, length: float, wanted: NDArray[np.float64], levels: int
) -> PieceLibrary:
    """Return the library of a map of curvatures (n, m) [1/mm], rounded to so many levels.

    Raises
    ------
    InputError
        when a curvature cannot be had by resin in the groove.
    """
    refuse_other_curvatures(wanted, groove.curvature_empty)
    level, chosen = rounded(wanted, levels)
    return PieceLibrary(groove, base, length, level, chosen, wanted)


def places_of(
    shape: tuple[int, ...], pitch: float, length: float, x: ArrayLike, y: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the numbers across and along of the pieces over points [mm], one shape."""
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    found = (np.floor(at / size).astype(np.int64) for at, size in ((x, pitch), (y, length)))
    i, k = (np.clip(n, 0, count - 1) for n, count in zip(found, shape, strict=True))
    return i, k


def refuse_other_curvatures(wanted: NDArray[np.float64], most: float) -> None:
    """Raise for curvatures outside 0 … most [1/mm]."""
    low, high = float(wanted.min()), float(wanted.max())
    if not np.isfinite(wanted).all() or low < 0 or high > most:
        raise InputError(f"map: C {low:.4g} … {high:.4g} /mm: expected 0 … {most:.6g} /mm")


def rounded(
    wanted: NDArray[np.float64], levels: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the levels (k,) [1/mm] of a map (n, m), and the number of the level at each place."""
    low, high = float(wanted.min()), float(wanted.max())
    if high - low < 1e-9:
        return np.array([low]), np.zeros(wanted.shape, np.int64)
    level = np.linspace(low, high, max(2, levels))
    return level, mirrored(wanted, lambda part: diffused(part, level))


def mirrored(
    wanted: NDArray[np.float64], choose: Callable[[NDArray[np.float64]], NDArray[np.int64]]
) -> NDArray[np.int64]:
    """Return what is chosen at each place of a map (n, m).

    Of a map that is its own mirror image it is chosen over a quarter, and mirrored.
    """
    n, m = wanted.shape
    if not (np.allclose(wanted, wanted[::-1]) and np.allclose(wanted, wanted[:, ::-1])):
        return choose(wanted)
    quarter = choose(wanted[: -(-n // 2), : -(-m // 2)])
    half = np.concatenate([quarter, quarter[: n // 2][::-1]])
    return np.concatenate([half, half[:, : m // 2][:, ::-1]], axis=1)


def diffused(wanted: NDArray[np.float64], level: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the number of the level at each place, (n, m), what is left handed on."""
    step, last = level[1] - level[0], len(level) - 1
    rest = (wanted - level[0]) / step
    chosen = np.zeros(wanted.shape, np.int64)
    n, m = wanted.shape
    for i in range(n):
        for k in range(m):
            chosen[i, k] = min(max(int(np.floor(rest[i, k] + 0.5)), 0), last)
            left = rest[i, k] - chosen[i, k]
            for down, right, share in _SHARES:
                if i + down < n and 0 <= k + right < m:
                    rest[i + down, k + right] += share * left
    return chosen
