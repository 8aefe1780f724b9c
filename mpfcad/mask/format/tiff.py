"""A drawing as a tiled 1-bit BigTIFF with tifffile, made and written strip after strip of tiles.

A pixel is black where it is drawn. Both edges of an aperture across are rounded to pixels; its
length is what is left of its area, and what rounding takes from one aperture the next ones along
the groove get (error diffusion), so the ratio of each groove stays right whatever the pixel is.
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.mask.array import ApertureArray
from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.format.flat import flat_columns
from mpfcad.mask.rule import GRID
from mpfcad.units import mm

INCH = 25.4 * mm
#: Side of a tile, and its height where a strip of them would not fit the memory [pixels].
TILE, LOW_TILE, LARGEST_STRIP = 2048, 256, 256_000_000
#: Separates the dither of neighbouring grooves: the golden ratio's fraction.
GOLDEN = 0.6180339887498949
DEFLATE, WHITE_IS_ZERO = 8, 0


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


def write_tiff(drawing: Drawing, path: Path) -> None:
    """Write `drawing` to `path`.

    Raises
    ------
    InputError
        for apertures that are no rectangles.
    """
    import tifffile

    raster = Raster.build(drawing)
    tile_height = TILE if raster.width * TILE <= LARGEST_STRIP else LOW_TILE
    strips = _Strips(drawing, raster, tile_height)
    with tifffile.TiffWriter(path, bigtiff=True, byteorder="<") as file:
        file.write(
            strips.tiles(),
            shape=(raster.height, raster.width),
            dtype=bool,
            photometric=WHITE_IS_ZERO,
            tile=(tile_height, TILE),
            compression=DEFLATE,
            resolution=(drawing.phototool.dpi, drawing.phototool.dpi),
            resolutionunit="INCH",
            description=_describe(drawing, raster),
            software="mpfcad",
            metadata=None,
        )


def _describe(drawing: Drawing, raster: Raster) -> str:
    """Return the image description: text, and where the panel's corner is."""
    place = (raster.column(0), raster.height - raster.row(0))
    return "\n".join(
        (
            *drawing.lines,
            f"pixel {raster.pixel * GRID * 1000:.6g} um; edges snapped by up to half a pixel",
            f"panel from pixel {place[0]} of the left, {place[1]} of the bottom; "
            f"{drawing.width * GRID:.6f} x {drawing.length * GRID:.6f} mm",
        )
    )


class _Strips:
    """Strips of tiles from the top down; a strip is (columns, rows) of pixels."""

    def __init__(self, drawing: Drawing, raster: Raster, height: int) -> None:
        self.raster, self.height = raster, height
        closed = drawing.phototool.polarity == "closed"
        self.spans = [_Span.build(a, raster, i) for i, a in enumerate(flat_columns(drawing))]
        self.coupon = [_Span.build(a, raster, i) for i, a in enumerate(drawing.coupon)]
        self.panel = None
        if closed:
            columns = (raster.column(0), raster.column(drawing.width))
            self.panel = (*columns, raster.row(drawing.length), raster.row(0))
        self.polygons = []
        for _, points in drawing.polygons:
            pixels = (points - (raster.left, raster.top)) * (1, -1) / raster.pixel
            self.polygons.append((pixels, pixels.min(axis=0), pixels.max(axis=0)))

    def tiles(self) -> Iterator[bytes]:
        """Yield the compressed tiles, row by row."""
        across = -(-self.raster.width // TILE)
        for top in range(0, self.raster.height, self.height):
            strip = np.zeros((across * TILE, self.height), dtype=np.bool_)
            self._draw(strip, top)
            for left in range(0, across * TILE, TILE):
                tile = np.ascontiguousarray(strip[left : left + TILE].T)
                self._add_polygons(tile, left, top)
                yield zlib.compress(np.packbits(tile, axis=1).tobytes(), 6)

    def _draw(self, strip: NDArray[np.bool_], top: int) -> None:
        if self.panel is not None:
            left, right, first, last = self.panel
            strip[left:right, max(0, first - top) : max(0, last - top)] = True
        bottom = self.raster.height - top - self.height
        for spans, value in ((self.coupon, True), (self.spans, self.panel is None)):
            for span in spans:
                rows = span.rows_in(bottom, self.height)
                if rows is not None:
                    part = strip[span.left : span.right]
                    part[:, rows[::-1]] = value

    def _add_polygons(self, tile: NDArray[np.bool_], left: int, top: int) -> None:
        """Add furniture to a tile."""
        from PIL import Image, ImageDraw

        low, high = np.array((left, top)), np.array((left, top)) + tile.shape[::-1]
        found = [
            p for p, first, last in self.polygons if (first < high).all() and (last > low).all()
        ]
        if found:
            picture = Image.new("1", tile.shape[::-1])
            pencil = ImageDraw.Draw(picture)
            for points in found:
                pencil.polygon([tuple(p) for p in points - low - 0.5], fill=1)
            tile |= np.asarray(picture)


@dataclass(frozen=True)
class _Span:
    """One column of equal apertures in pixels; rows are counted from the bottom.

    `start`, `step` and `share` are the first one's foot, their distance and their mean length.
    """

    left: int
    right: int
    start: float
    step: float
    share: float
    count: int
    phase: float

    @classmethod
    def build(cls, array: ApertureArray, raster: Raster, index: int) -> "_Span":
        if not array.is_rectangle:
            raise InputError("mask format tif: allowed rectangles, not polygons")
        (x, y), place = array.place.origin, array.place
        left = raster.column(x)
        right = max(left + 1, raster.column(x + array.shape[0]))
        foot = raster.top - raster.height * raster.pixel
        return cls(
            left,
            right,
            (y - foot) / raster.pixel,
            place.row_step[1] / raster.pixel,
            array.shape[0] * array.shape[1] / raster.pixel**2 / (right - left),
            place.rows,
            index * GOLDEN % 1.0,
        )

    def rows_in(self, bottom: int, height: int) -> NDArray[np.bool_] | None:
        """Return which of the rows from `bottom` on are open; None when none is."""
        if self.step:
            first = max(0, int((bottom - self.start - self.share) / self.step) - 1)
            last = min(self.count, int((bottom + height - self.start) / self.step) + 2)
        else:
            first, last = 0, 1
        if first >= last:
            return None
        k = np.arange(first, last + 1)
        sums = np.floor(k * self.share + self.phase).astype(np.int64)
        size = np.diff(sums)
        # The middle of each stays where it is.
        foot = np.rint(self.start + k[:-1] * self.step + (self.share - size) / 2).astype(np.int64)
        low = np.clip(foot - bottom, 0, height)
        high = np.clip(foot + size - bottom, 0, height)
        edge = np.zeros(height + 1, dtype=np.int64)
        np.add.at(edge, low, 1)
        np.subtract.at(edge, high, 1)
        return np.cumsum(edge[:-1]) > 0
