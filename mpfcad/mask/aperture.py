"""What every mask of a panel tells: its apertures as arrays and tiles, and its ratios."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import Process
from mpfcad.mask.array import ApertureArray, TileArray
from mpfcad.mask.rule import MaskRules


@dataclass(frozen=True, eq=False)
class Mask(ABC):
    """What every mask of a panel tells; it is never flattened.

    Attributes
    ----------
    name
        the job's name
    content_hash
        first 12 hexadecimal digits of SHA-256 over the curvatures (little-endian float64)
    rules
        what was asked for
    pitch, length
        of the grooves [mm]
    groove_count
        number of grooves n
    """

    name: str
    content_hash: str
    rules: MaskRules
    pitch: float
    length: float
    groove_count: int

    @property
    def width(self) -> float:
        """Extent across the grooves [mm]."""
        return self.groove_count * self.pitch

    @property
    @abstractmethod
    def period(self) -> float:
        """Distance of the apertures along the grooves as made [mm]."""

    @property
    @abstractmethod
    def arrays(self) -> Iterable[ApertureArray]:
        """Arrays of apertures, each within one groove; may be gone through again and again.

        A dithered panel makes them as one goes, so that they never stand in memory together.
        """

    @property
    def tile_arrays(self) -> Iterable[TileArray]:
        """Tiles of apertures, besides `arrays`."""
        return ()

    @property
    @abstractmethod
    def aperture_count(self) -> int:
        """Number of apertures in all."""

    @property
    @abstractmethod
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""

    @property
    def printed_share(self) -> NDArray[np.float64] | None:
        """Share of each groove's length that is to be printed, (n,) float64; None: all of it."""
        return None

    @property
    @abstractmethod
    def wanted_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio that each groove's curvature needs, its mean along, (n,) float64."""

    @abstractmethod
    def open_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the ratio as drawn, integrated along from 0 to each position [mm].

        Of `count` grooves from groove `first` on; (count, k) for (k,) positions.
        """

    @abstractmethod
    def wanted_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the wanted ratio, integrated like `open_length`."""

    @property
    @abstractmethod
    def smallest_features(self) -> tuple[float | None, float | None]:
        """Smallest aperture and web as drawn [mm]; None where there is none."""

    @property
    def is_lattice(self) -> bool:
        """Whether the apertures of a groove are one array."""
        return False

    @property
    def closed_arrays(self) -> Iterable[ApertureArray] | None:
        """Rectangles that cover what is closed, without overlap; None where that is not made."""
        return None

    def wanted_places(self, cell: float) -> tuple[NDArray[np.float64], float]:
        """Return the wanted ratio where a print is judged, and the places' distance across [mm].

        Of squares of side `cell` [mm]: a map of both directions varies along its grooves.
        """
        return self.wanted_map(cell), cell

    def wanted_curvature(self, process: Process, cell: float) -> tuple[NDArray[np.float64], float]:
        """Return C [1/mm] where it changes as the print is shifted, and the places' distance [mm].

        As `wanted_places`; along by across, or across alone.
        """
        wanted, step = self.wanted_places(cell)
        return process.curvature(wanted), step

    @cached_property
    def ratio_ends(self) -> tuple[float, float]:
        """Smallest wanted ratio above 0, and the largest: of squares of 1 mm; 0, 0 without resin.

        A map of both directions varies along its grooves, so that their means say too little.
        """
        return ends_of(self.wanted_map(1.0))

    def ratio_map(self, cell: float) -> NDArray[np.float64]:
        """Return the mean ratio as drawn over squares of side `cell` [mm], (along, across).

        Squares are counted from the panel's lower left corner; the last of a side are cut, and so
        are apertures by the squares' edges along.
        """
        return self._map(self.open_length, cell)

    def wanted_map(self, cell: float) -> NDArray[np.float64]:
        """Return the mean of the wanted ratio over the same squares."""
        return self._map(self.wanted_length, cell)

    def _map(
        self, integral: Callable[[int, int, NDArray], NDArray], cell: float
    ) -> NDArray[np.float64]:
        edge = square_edges(self.length, cell)
        parts = [integral(first, count, edge) for first, count in blocks(self.groove_count)]
        mean = np.diff(np.concatenate(parts), axis=1) / np.diff(edge)
        return mean_over_grooves(mean.T, self.pitch, cell)


def ends_of(ratio: NDArray[np.float64]) -> tuple[float, float]:
    """Return the smallest ratio above 0, and the largest; 0, 0 when there is none."""
    is_open = ratio > 1e-9
    if not is_open.any():
        return 0.0, 0.0
    return float(ratio[is_open].min()), float(ratio.max())


def blocks(count: int, size: int = 64) -> list[tuple[int, int]]:
    """Return first and number of runs that `count` things are gone through in."""
    return [(first, min(size, count - first)) for first in range(0, count, size)]


def square_edges(side: float, cell: float) -> NDArray[np.float64]:
    """Return 0, cell, 2 cell, … and `side` [mm]: the last square is cut at the panel's edge."""
    return np.append(np.arange(0.0, side - 1e-6 * cell, cell), side)


def mean_over_grooves(value: NDArray[np.float64], pitch: float, cell: float) -> NDArray[np.float64]:
    """Return (rows, n) values of grooves as means over squares of side `cell` [mm], by area."""
    edge = square_edges(value.shape[1] * pitch, cell)
    total = np.concatenate([np.zeros((len(value), 1)), np.cumsum(value, axis=1)], axis=1)
    place = np.clip(edge / pitch, 0, value.shape[1])
    low = np.minimum(place.astype(int), value.shape[1] - 1)
    at = total[:, low] + (place - low) * (total[:, low + 1] - total[:, low])
    return np.diff(at, axis=1) / np.diff(place)
