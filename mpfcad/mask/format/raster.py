"""Apertures as rows of pixels: columns of equal rectangles drawn into packed bits, compiled.

Both edges of an aperture across are rounded to pixels; its length is what is left of its area, and
what rounding takes from one aperture the next ones along the groove get (error diffusion), so the
ratio of each groove stays right whatever the pixel is.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numba as nb
import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.mask.array import ApertureArray
from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.rule import GRID
from mpfcad.store.kernel import kept
from mpfcad.units import mm

INCH = 25.4 * mm
#: Separates the dither of neighbouring grooves: the golden ratio's fraction.
GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Raster:
    """Where pixels are: `pixel` grid steps wide; (left, top) of the first one [grid steps]."""

    pixel: float
    left: float
    top: float
    width: int
    height: int

    @classmethod
    def build(cls, drawing: Drawing) -> "Raster":
        """Return the raster of a drawing, on which the panel's corner (0, 0) is a pixel's."""
        pixel = INCH / drawing.phototool.dpi / GRID
        box = np.array(drawing.bounds()) / pixel
        low, high = np.floor(box[:2] - 1e-9), np.ceil(box[2:] + 1e-9)
        width, height = (int(n) for n in high - low)
        return cls(pixel, float(low[0] * pixel), float(high[1] * pixel), width, height)

    def column(self, x: float) -> int:
        """Return the pixel edge next to x."""
        return round((x - self.left) / self.pixel)

    def row(self, y: float) -> int:
        """Return the pixel edge next to y, counted from the top."""
        return round((self.top - y) / self.pixel)


@dataclass(frozen=True, eq=False)
class Spans:
    """Columns of equal apertures in pixels; rows are counted from the bottom; all (m,).

    Attributes
    ----------
    left, right, count
        int64: columns of pixels, and number of apertures
    start, step, share, phase
        float64: the first one's foot, their distance and mean length, the dither's start
    """

    left: NDArray[np.int64]
    right: NDArray[np.int64]
    count: NDArray[np.int64]
    start: NDArray[np.float64]
    step: NDArray[np.float64]
    share: NDArray[np.float64]
    phase: NDArray[np.float64]

    @classmethod
    def build(cls, arrays: Iterable[ApertureArray], raster: Raster) -> "Spans":
        """Return the spans of arrays: a lattice is one a column, listed places one each.

        Raises
        ------
        InputError
            for apertures that are no rectangles.
        """
        parts = [_table(array) for array in arrays]
        table = np.concatenate(parts) if parts else np.zeros((0, 6), np.int64)
        x, y, width, length, count, step = table.T
        left = np.rint((x - raster.left) / raster.pixel).astype(np.int64)
        right = np.rint((x + width - raster.left) / raster.pixel).astype(np.int64)
        right = np.maximum(right, left + 1)
        foot = raster.top - raster.height * raster.pixel
        area = width.astype(float) * length / raster.pixel**2
        return cls(
            left, right, np.ascontiguousarray(count), (y - foot) / raster.pixel,
            step / raster.pixel, np.asarray(area / (right - left), np.float64),
            np.arange(float(len(table))) * GOLDEN % 1.0,
        )  # fmt: skip

    def draw(self, bits: NDArray[np.uint8], bottom: int, on: bool) -> None:
        """Set (or clear) the pixels of all spans in a strip of packed rows, the top row first.

        `bits` is (rows, bytes) uint8, of the rows from `bottom` on.
        """
        _draw(
            bits, self.left, self.right, self.count, self.start, self.step, self.share,
            self.phase, bottom, on,
        )  # fmt: skip


def _table(array: ApertureArray) -> NDArray[np.int64]:
    """Return x, y, width, length, count and step of the columns of an array, (k, 6) int64."""
    if not isinstance(array.shape, tuple):
        raise InputError("mask format tif: expected rectangles, not polygons")
    place, (width, length) = array.place, array.shape
    if place.offset is None and place.row_step[0] == 0:
        number = np.arange(place.columns)
        x = place.origin[0] + number * place.column_step[0]
        y = place.origin[1] + number * place.column_step[1]
        count, step = place.rows, place.row_step[1] if place.rows > 1 else 0
    else:
        x, y = place.positions().T
        count, step = 1, 0
    rest = np.broadcast_to(np.array([width, length, count, step]), (len(x), 4))
    return np.column_stack([x, y, rest]).astype(np.int64)


@kept
@nb.njit(nogil=True)
def _draw(
    bits: Any,
    left: Any,
    right: Any,
    count: Any,
    start: Any,
    step: Any,
    share: Any,
    phase: Any,
    bottom: Any,
    on: Any,
) -> None:
    height = bits.shape[0]
    for i in range(len(left)):
        first, last = 0, count[i]
        if step[i] > 0:
            first = max(0, int((bottom - start[i] - share[i]) / step[i]) - 1)
            last = min(last, int((bottom + height - start[i]) / step[i]) + 2)
        head, tail = left[i] >> 3, (right[i] - 1) >> 3
        head_mask = np.uint8(0xFF >> (left[i] & 7))
        tail_mask = np.uint8((0xFF << (7 - ((right[i] - 1) & 7))) & 0xFF)
        for k in range(first, last):
            low = np.floor(k * share[i] + phase[i])
            size = int(np.floor((k + 1) * share[i] + phase[i]) - low)
            # The middle of each stays where it is.
            foot = int(np.rint(start[i] + k * step[i] + (share[i] - size) / 2)) - bottom
            for y in range(max(foot, 0), min(foot + size, height)):
                row = height - 1 - y
                for byte in range(head, tail + 1):
                    mask = np.uint8(0xFF)
                    if byte == head:
                        mask &= head_mask
                    if byte == tail:
                        mask &= tail_mask
                    if on:
                        bits[row, byte] |= mask
                    else:
                        bits[row, byte] &= ~mask
