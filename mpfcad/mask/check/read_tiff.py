"""The 1-bit BigTIFF read again, tile after tile, with nothing but struct and zlib."""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError
from mpfcad.mask.check.count_pixels import count_tile
from mpfcad.mask.told import Told, untold
from mpfcad.units import mm

INCH = 25.4 * mm
#: TIFF tags, and the sizes and codes of the field types that are read.
WIDTH, HEIGHT, BITS, COMPRESSION, PHOTOMETRIC, DESCRIPTION = 256, 257, 258, 259, 262, 270
X_RESOLUTION, UNIT, TILE_WIDTH, TILE_HEIGHT, OFFSETS, SIZES = 282, 296, 322, 323, 324, 325
_TYPES = {2: (1, "c"), 3: (2, "H"), 4: (4, "I"), 5: (8, "II"), 16: (8, "Q")}
_STANDARD = {BITS: (1,), UNIT: (2,)}
DEFLATE, WHITE_IS_ZERO, PER_INCH = (8, 32946), 0, 2


@dataclass(frozen=True, eq=False)
class FoundPixels:
    """What a TIFF holds; the panel's pixels are summed up as they come.

    Attributes
    ----------
    text
        the lines of the image description
    pixel
        side of a pixel [mm]
    column_area
        (w,) int64, black pixels in each column of the panel, left to right
    square_area
        (along, across) int64, black pixels in each square, whose edges are rounded to pixels
    square_pixels
        (along, across) int64, all pixels in them
    """

    text: tuple[str, ...]
    pixel: float
    column_area: NDArray[np.int64]
    square_area: NDArray[np.int64]
    square_pixels: NDArray[np.int64]


def read_tiff(
    path: Path,
    width: float,
    length: float,
    edges: tuple[NDArray[np.float64], NDArray[np.float64]],
    told: Told = untold,
) -> FoundPixels:
    """Return what a TIFF holds of a panel of width × length; `edges` of squares along, across [mm].

    `told` gets the share that is read, as it grows.

    Raises
    ------
    ExportError
        when it is no such TIFF, or too small for the panel.
    """
    try:
        data = np.memmap(path, np.uint8, "r")
        tags, description = _read_tags(data)
        text = tuple(description.split("\n"))
        numerator, denominator = tags[X_RESOLUTION][:2]
    except (OSError, KeyError, struct.error, ValueError, IndexError) as error:
        raise ExportError(f"{path}: not a readable mask: {error!r}") from None
    wanted = {BITS: (1,), PHOTOMETRIC: (WHITE_IS_ZERO,), UNIT: (PER_INCH,)}
    for tag, value in wanted.items():
        # A field that is left out has its standard value: one bit, per inch.
        if tags.get(tag, _STANDARD.get(tag)) != value:
            raise ExportError(f"{path}: TIFF tag {tag}: {tags.get(tag)}: expected {value}")
    if tags[COMPRESSION][0] not in DEFLATE:
        raise ExportError(f"{path}: TIFF compression {tags[COMPRESSION][0]}: expected deflate")
    pixel = INCH * denominator / numerator
    corner = _corner(path, text)
    top = tags[HEIGHT][0] - corner[1] - round(length / pixel)
    box = (corner[0], top, round(width / pixel), round(length / pixel))
    if top < 0 or box[0] + box[2] > tags[WIDTH][0]:
        raise ExportError(f"{path}: the panel does not lie within the picture")
    return FoundPixels(text, pixel, *_sum_up(path, data, tags, box, edges, pixel, told))


def _corner(path: Path, text: tuple[str, ...]) -> tuple[int, int]:
    """Return the panel's corner as the description states it."""
    for line in text:
        words = line.split()
        if line.startswith("panel from pixel "):
            return int(words[3]), int(words[7])
    raise ExportError(f"{path}: description: expected the panel's place")


def _read_tags(data: NDArray[np.uint8]) -> tuple[dict[int, tuple[int, ...]], str]:
    """Return the tags of the first picture that are numbers, and its description."""
    head = data[:16].tobytes()
    if head[:8] != b"II+\x00\x08\x00\x00\x00":
        raise ValueError("no little-endian BigTIFF")
    (start,) = struct.unpack_from("<Q", head, 8)
    (count,) = struct.unpack("<Q", data[start : start + 8].tobytes())
    tags: dict[int, tuple[int, ...]] = {}
    text: dict[int, str] = {}
    for i in range(count):
        entry = data[start + 8 + 20 * i : start + 28 + 20 * i].tobytes()
        tag, kind, number = struct.unpack_from("<HHQ", entry)
        if kind not in _TYPES:
            continue
        size, code = _TYPES[kind]
        raw = entry[12:]
        if size * number > 8:
            (place,) = struct.unpack("<Q", raw)
            raw = data[place : place + size * number].tobytes()
        if kind == 2:
            text[tag] = raw[:number].rstrip(b"\x00").decode("ascii")
        else:
            tags[tag] = struct.unpack_from(f"<{number * len(code)}{code[0]}", raw)
    return tags, text[DESCRIPTION]


def _sum_up(
    path: Path,
    data: NDArray[np.uint8],
    tags: dict[int, tuple[int, ...]],
    box: tuple[int, int, int, int],
    edges: tuple[NDArray[np.float64], NDArray[np.float64]],
    pixel: float,
    told: Told,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return black pixels a column, black pixels and all pixels a square."""
    left, top, width, height = box
    cuts = [np.minimum(np.rint(edge / pixel).astype(int), n)
            for edge, n in zip(edges, (height, width), strict=True)]  # fmt: skip
    square = [np.searchsorted(cut, np.arange(n), side="right") - 1
              for cut, n in zip(cuts, (height, width), strict=True)]  # fmt: skip
    column_area = np.zeros(width, np.int64)
    square_area = np.zeros((len(cuts[0]) - 1, len(cuts[1]) - 1), np.int64)
    for x, y, tile in _tiles(path, data, tags):
        if x == 0:
            told(min(1.0, y / tags[HEIGHT][0]))
        x0, x1 = max(x, left), min(x + tile.shape[1] * 8, left + width)
        y0, y1 = max(y, top), min(y + tile.shape[0], top + height)
        if x0 >= x1 or y0 >= y1:
            continue
        up = square[0][height - 1 - np.arange(y0 - top, y1 - top)]
        across = square[1][x0 - left : x1 - left]
        count_tile(
            tile, x0 - x, y0 - y, y1 - y0, x1 - x0, up, across, column_area[x0 - left : x1 - left],
            square_area,
        )  # fmt: skip
    return column_area, square_area, np.outer(np.diff(cuts[0]), np.diff(cuts[1]))


def _tiles(
    path: Path, data: NDArray[np.uint8], tags: dict[int, tuple[int, ...]]
) -> Iterator[tuple[int, int, NDArray[np.uint8]]]:
    """Yield left, top and the packed pixels of each tile."""
    width, height = tags[TILE_WIDTH][0], tags[TILE_HEIGHT][0]
    across = -(-tags[WIDTH][0] // width)
    for i, (offset, size) in enumerate(zip(tags[OFFSETS], tags[SIZES], strict=True)):
        try:
            bits = zlib.decompress(data[offset : offset + size].tobytes())
            pixels = np.frombuffer(bits, np.uint8).reshape(height, width // 8)
        except (zlib.error, ValueError):
            raise ExportError(f"{path}: tile {i}: damaged") from None
        yield i % across * width, i // across * height, pixels
