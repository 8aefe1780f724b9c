"""A drawing as a tiled 1-bit BigTIFF with tifffile, made and written strip after strip of tiles.

A pixel is black where it is drawn (`raster` says how). Only a strip of tiles stands in memory,
whatever the resolution; its tiles are compressed on two threads, in order.
"""

import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.format.flat import flat_tiles
from mpfcad.mask.format.raster import Raster, Spans
from mpfcad.mask.rule import GRID
from mpfcad.mask.told import Told, untold

#: Side of a tile, and its height where a strip of them would not fit the memory [pixels].
TILE, LOW_TILE, LARGEST_STRIP = 2048, 256, 1_000_000_000
DEFLATE, WHITE_IS_ZERO = 8, 0
#: Deflate's level: rows repeat so much that a higher one saves little and takes twice as long.
LEVEL, THREADS = 3, 2


def strip_bytes(width: int) -> int:
    """Return the memory that a strip of tiles of a picture so many pixels wide takes."""
    return width * (TILE if width * TILE <= LARGEST_STRIP else LOW_TILE) // 8


def write_tiff(drawing: Drawing, path: Path, told: Told = untold) -> None:
    """Write `drawing` to `path`; `told` gets the share that is written, strip by strip.

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
            strips.tiles(told),
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
    """Strips of tiles from the top down; a strip is (rows, bytes) of packed pixels."""

    def __init__(self, drawing: Drawing, raster: Raster, height: int) -> None:
        self.raster, self.height = raster, height
        closed = drawing.phototool.polarity == "closed"
        self.spans = Spans.build(chain(drawing.arrays, flat_tiles(drawing)), raster)
        self.coupon = Spans.build(drawing.coupon, raster)
        self.panel = None
        if closed:
            columns = (raster.column(0), raster.column(drawing.width))
            self.panel = (*columns, raster.row(drawing.length), raster.row(0))
        self.polygons = []
        for _, points in drawing.polygons:
            pixels = (points - (raster.left, raster.top)) * (1, -1) / raster.pixel
            self.polygons.append((pixels, pixels.min(axis=0), pixels.max(axis=0)))

    def tiles(self, told: Told) -> Iterator[bytes]:
        """Yield the compressed tiles, row by row; `told` gets the share that is done."""
        across = -(-self.raster.width // TILE)
        with ThreadPoolExecutor(THREADS) as pool:
            for top in range(0, self.raster.height, self.height):
                strip = np.zeros((self.height, across * TILE // 8), np.uint8)
                self._draw(strip, top)
                lefts = range(0, across * TILE, TILE)
                yield from pool.map(lambda left: self._tile(strip, left, top), lefts)  # noqa: B023
                told(min(1.0, (top + self.height) / self.raster.height))

    def _tile(self, strip: NDArray[np.uint8], left: int, top: int) -> bytes:
        tile = np.ascontiguousarray(strip[:, left // 8 : (left + TILE) // 8])
        self._add_polygons(tile, left, top)
        return zlib.compress(tile.tobytes(), LEVEL)

    def _draw(self, strip: NDArray[np.uint8], top: int) -> None:
        bottom = self.raster.height - top - self.height
        self.coupon.draw(strip, bottom, True)
        if self.panel is not None:
            left, right, first, last = self.panel
            rows = slice(max(0, first - top), max(0, last - top))
            columns = np.zeros(strip.shape[1] * 8, np.bool_)
            columns[left:right] = True
            strip[rows] |= np.packbits(columns)
        self.spans.draw(strip, bottom, self.panel is None)

    def _add_polygons(self, tile: NDArray[np.uint8], left: int, top: int) -> None:
        """Add furniture to a tile."""
        from PIL import Image, ImageDraw

        size = (TILE, len(tile))
        low, high = np.array((left, top)), np.array((left, top)) + size
        found = [
            p for p, first, last in self.polygons if (first < high).all() and (last > low).all()
        ]
        if found:
            picture = Image.new("1", size)
            pencil = ImageDraw.Draw(picture)
            for points in found:
                pencil.polygon([tuple(p) for p in points - low - 0.5], fill=1)
            tile |= np.packbits(np.asarray(picture), axis=1)
