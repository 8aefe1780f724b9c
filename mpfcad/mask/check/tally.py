"""Open area summed up from arrays as they are read: of grooves and squares; smallest features."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError
from mpfcad.mask.array import ApertureArray
from mpfcad.mask.pattern.column import Columns, column_area, measure_webs
from mpfcad.mask.rule import GRID

#: Columns whose squares are worked out at a time.
CHUNK = 2048


@dataclass(eq=False)
class Tally:
    """What the arrays of a file add up to; grid steps.

    Attributes
    ----------
    path
        of the file, for messages
    groove_edge
        (n + 1,) int64, tips
    along, across
        edges of the squares
    is_slot
        whether listed apertures are grooves' parts of slots across them: only their length counts
    is_tiled
        whether the mask is of tiles one groove wide, of a map of both directions
    groove_area
        (n,) float64, area of the apertures over each groove
    square_area
        (along, across) float64, area of the apertures in each square
    count
        number of apertures
    smallest_aperture, smallest_web
        None as long as there is none
    box
        left, bottom, right, top of all apertures
    """

    path: Path
    groove_edge: NDArray[np.int64]
    along: NDArray[np.float64]
    across: NDArray[np.float64]
    is_slot: bool = False
    is_tiled: bool = False
    count: int = 0
    smallest_aperture: int | None = None
    smallest_web: int | None = None
    box: tuple[int, int, int, int] | None = None
    _lattices: list[tuple[int, ...]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.groove_area = np.zeros(len(self.groove_edge) - 1)
        self._turned = np.zeros((len(self.across) - 1, len(self.along) - 1))

    @property
    def square_area(self) -> NDArray[np.float64]:
        """Area of the apertures in each square, (along, across)."""
        return self._turned.T

    def add(self, array: ApertureArray) -> None:
        """Add the apertures of an array."""
        place = array.place
        if place.offset is None:
            (x, y), (dx, _), (_, dy) = place.origin, place.column_step, place.row_step
            step = (dx, place.rows, dy if place.rows > 1 else 0)
            self._lattices.append((x, y, *array.size, place.columns, *step))
            return
        left = place.origin[0] + place.offset[:, 0]
        bottom = place.origin[1] + place.offset[:, 1]
        if left.min(initial=left[0]) == left.max(initial=left[0]):
            self._add_listed(int(left[0]), bottom, *array.size)
            return
        self._add_scattered(left, bottom, *array.size)

    def finish(self) -> None:
        """Add up the lattices.

        Raises
        ------
        ExportError
            when an aperture reaches beyond the panel, whose area is that of no groove.
        """
        columns = self._columns
        self.count += columns.aperture_count
        if not len(columns.left):
            self._refuse_outside()
            return
        ends = (columns.left.min(), columns.bottom.min(), columns.right.max(), columns.top.max())
        self._grow_box(*map(int, ends))
        self._refuse_outside()
        self.groove_area += column_area(columns, self.groove_edge)
        for first in range(0, len(columns.left), CHUNK):
            part = slice(first, first + CHUNK)
            self._share_out(
                columns.left[part], columns.right[part], _lengths(columns, part, self.along)
            )

    def measure(self) -> None:
        """Find the smallest features of the lattices, and refuse overlaps."""
        pitch = float(self.groove_edge[-1]) / len(self.groove_area)
        aperture, web = measure_webs(str(self.path), self._columns, pitch)
        if self.is_tiled and self.is_slot and aperture is not None:
            # Tiles that a file holds as lattices are grooves' parts of slots, as listed ones are.
            aperture = int(self._columns.height.min())
        self._note(aperture, web)

    @cached_property
    def _columns(self) -> Columns:
        return Columns.build(self._lattices)

    def _add_listed(self, left: int, bottom: NDArray[np.int64], width: int, height: int) -> None:
        """Add one column of apertures that are listed one by one."""
        bottom = np.sort(bottom)
        self.count += len(bottom)
        self._grow_box(left, int(bottom[0]), left + width, int(bottom[-1]) + height)
        gap = np.diff(bottom) - height
        if gap.min(initial=0) < 0:
            groove = int(np.searchsorted(self.groove_edge, left, side="right")) - 1
            raise ExportError(f"{self.path}: groove {groove} (counted from 0): apertures overlap")
        self._note(
            height if self.is_slot else min(width, height), int(gap.min()) if len(gap) else None
        )
        total = float(len(bottom) * width * height)
        first = np.searchsorted(self.groove_edge, left, side="right") - 1
        edge = np.clip(self.groove_edge[first : first + 2], left, left + width)
        if len(edge) == 2 and edge[1] - edge[0] == width:
            self.groove_area[first] += total
        else:
            inside = np.clip(self.groove_edge, left, left + width).astype(float)
            self.groove_area += np.diff(inside) / width * total
        done = np.searchsorted(bottom, self.along - height, side="right")
        begun = np.searchsorted(bottom, self.along, side="left")
        last = bottom[np.maximum(begun - 1, 0)]
        reach = done * height + np.where(begun > done, self.along - last, 0)
        self._share_out(np.array([left]), np.array([left + width]), np.diff(reach)[:, None])

    def _add_scattered(
        self, left: NDArray[np.int64], bottom: NDArray[np.int64], width: int, height: int
    ) -> None:
        """Add apertures that are listed one by one, across and along."""
        left, bottom = _sorted_columns(left, bottom)
        self.count += len(left)
        ends = (left[0], bottom.min(), left[-1] + width, bottom.max() + height)
        self._grow_box(*map(int, ends))
        gap = np.diff(bottom)[np.diff(left) == 0] - height
        beside = np.diff(left)
        overlap = np.flatnonzero((beside == 0) & (np.diff(bottom) < height))
        if overlap.size:
            at = left[overlap[0]]
            first = int(np.searchsorted(self.groove_edge, at, side="right")) - 1
            raise ExportError(f"{self.path}: groove {first} (counted from 0): apertures overlap")
        self._note(
            height if self.is_slot else min(width, height), int(gap.min()) if len(gap) else None
        )
        groove, over = _split(self.groove_edge, left, width)
        grooves = len(self.groove_area)
        self.groove_area += height * np.bincount(groove, width - over, minlength=grooves)
        cut = over > 0
        self.groove_area += height * np.bincount(groove[cut] + 1, over[cut], minlength=grooves)
        column, wide = _split(self.across, left, width)
        row, high = _split(self.along, bottom, height)
        rows, size = len(self.along) - 1, self._turned.size
        square = column * rows + row
        for aside, up, area in (
            (0, 0, (width - wide) * (height - high)),
            (0, 1, (width - wide) * high),
            (1, 0, wide * (height - high)),
            (1, 1, wide * high),
        ):
            some = area > 0
            if some.any():
                place = square[some] + aside * rows + up
                self._turned.ravel()[:] += np.bincount(place, area[some], minlength=size)

    def _share_out(
        self, left: NDArray[np.int64], right: NDArray[np.int64], length: NDArray[np.float64]
    ) -> None:
        """Add columns to the squares; `length` (squares along, columns) is what is open of each."""
        first = np.searchsorted(self.across, left, side="right") - 1
        last = np.searchsorted(self.across, right, side="left") - 1
        first, last = (np.clip(v, 0, len(self.across) - 2) for v in (first, last))
        for k in range(int((last - first).max()) + 1):
            square = np.minimum(first + k, last)
            wide = np.minimum(right, self.across[square + 1]) - np.maximum(
                left, self.across[square]
            )
            wide = np.where(first + k <= last, np.maximum(wide, 0), 0)
            np.add.at(self._turned, square, (length * wide).T)

    def _refuse_outside(self) -> None:
        """Refuse apertures that reach beyond the panel."""
        right, top = float(self.groove_edge[-1]), float(self.along[-1])
        box = self.box
        if box and (min(box) < 0 or box[2] > right or box[3] > top):
            left, low, far, high = (side * GRID for side in box)
            raise ExportError(
                f"{self.path}: apertures reach over x {left:.6f} … {far:.6f}, y {low:.6f} … "
                f"{high:.6f} mm: expected them on the panel, 0 … {right * GRID:.6f}, "
                f"0 … {top * GRID:.6f} mm"
            )

    def _note(self, aperture: int | None, web: int | None) -> None:
        for name, size in (("smallest_aperture", aperture), ("smallest_web", web)):
            before = getattr(self, name)
            if size is not None:
                setattr(self, name, size if before is None else min(before, size))

    def _grow_box(self, left: int, bottom: int, right: int, top: int) -> None:
        box = self.box or (left, bottom, right, top)
        self.box = (
            min(box[0], left), min(box[1], bottom), max(box[2], right), max(box[3], top)
        )  # fmt: skip


def _lengths(columns: Columns, part: slice, edge: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the open length of columns between edges along, (edges - 1, columns)."""
    step = np.where(columns.step[part] > 0, columns.step[part], 1)
    count, height = columns.count[part], columns.height[part]
    reach = edge[:, None] - columns.bottom[part]
    whole = np.clip(np.floor(reach / step), 0, count - 1)
    return np.diff(whole * height + np.clip(reach - whole * step, 0, height), axis=0)


def _split(
    edge: NDArray, low: NDArray[np.int64], size: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return between which edges each stretch begins, and how much of it lies beyond the next."""
    index = np.clip(np.searchsorted(edge, low, side="right") - 1, 0, len(edge) - 2)
    over = np.clip(low + size - edge[index + 1], 0, None)
    return index, np.where(index < len(edge) - 2, over, 0)


def _sorted_columns(
    x: NDArray[np.int64], y: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return places sorted by x, then y; both within ±2³¹."""
    half, word = 1 << 31, (1 << 32) - 1
    key = np.sort((x << 32) | (y + half))
    return key >> 32, (key & word) - half
