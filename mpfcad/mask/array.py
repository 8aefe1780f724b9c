"""Apertures without flattening: one shape many times over, and tiles of such arrays.

Everything is in whole grid steps (1 nm). A rectangle's reference point is its lower left corner, a
polygon's its own (0, 0). A `Placement` says where the reference points are: on a lattice, or at
offsets that are listed one by one. A `Tile` is a named group of arrays that is placed as a whole.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Placement:
    """Where something stands, many times over; grid steps.

    Attributes
    ----------
    origin
        (x, y) of the first
    columns, rows
        number of places along `column_step` and along `row_step`; the lattice
    column_step, row_step
        (x, y) from one column, from one row, to the next
    offset
        (m, 2) int64 from `origin`, one a place, instead of a lattice (which is then 1 × 1)
    """

    origin: tuple[int, int]
    columns: int = 1
    rows: int = 1
    column_step: tuple[int, int] = (0, 0)
    row_step: tuple[int, int] = (0, 0)
    offset: NDArray[np.int64] | None = None

    @property
    def count(self) -> int:
        """Number of places."""
        return self.columns * self.rows if self.offset is None else len(self.offset)

    def positions(self) -> NDArray[np.int64]:
        """Return all places, (count, 2) int64: flattens, so only for windows and tests."""
        if self.offset is not None:
            return np.asarray(self.origin) + self.offset
        column = np.arange(self.columns)[:, None, None] * np.asarray(self.column_step)
        row = np.arange(self.rows)[None, :, None] * np.asarray(self.row_step)
        return (np.asarray(self.origin) + column + row).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class ApertureArray:
    """One shape at every place of a placement; grid steps.

    Attributes
    ----------
    shape
        (width across, length along) of a rectangle, or the (k, 2) int64 vertices of a polygon
    place
        where its reference points are
    """

    shape: tuple[int, int] | NDArray[np.int64]
    place: Placement

    @property
    def is_rectangle(self) -> bool:
        """Whether the shape is an upright rectangle."""
        return isinstance(self.shape, tuple)

    @cached_property
    def box(self) -> tuple[int, int, int, int]:
        """Left, bottom, right, top of the shape seen from its reference point."""
        if isinstance(self.shape, tuple):
            return 0, 0, *self.shape
        low, high = self.shape.min(axis=0), self.shape.max(axis=0)
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])

    @property
    def size(self) -> tuple[int, int]:
        """Width and length of the shape's bounding box."""
        left, bottom, right, top = self.box
        return right - left, top - bottom

    @property
    def shape_area(self) -> float:
        """Area of one shape [grid steps²]."""
        if isinstance(self.shape, tuple):
            return float(self.shape[0] * self.shape[1])
        x, y = self.shape.astype(float).T
        return abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))) / 2

    @property
    def count(self) -> int:
        """Number of apertures."""
        return self.place.count

    @property
    def area(self) -> float:
        """Open area of all of them [grid steps²]; exact below 2⁵³."""
        return self.shape_area * self.count


@dataclass(frozen=True, eq=False)
class Tile:
    """A named group of arrays, placed as a whole; its reference point is its lower left corner.

    Attributes
    ----------
    name
        of the cell in a file
    size
        (across, along) of what it covers, apertures or not [grid steps]
    arrays
        what is in it
    """

    name: str
    size: tuple[int, int]
    arrays: tuple[ApertureArray, ...]

    @property
    def count(self) -> int:
        """Number of apertures in one tile."""
        return sum(array.count for array in self.arrays)

    @property
    def area(self) -> float:
        """Open area of one tile [grid steps²]."""
        return sum(array.area for array in self.arrays)


@dataclass(frozen=True, eq=False)
class TileArray:
    """One tile at every place of a placement."""

    tile: Tile
    place: Placement

    @property
    def count(self) -> int:
        """Number of apertures in all."""
        return self.tile.count * self.place.count

    @property
    def area(self) -> float:
        """Open area in all [grid steps²]."""
        return self.tile.area * self.place.count
