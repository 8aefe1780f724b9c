"""The apertures of a mask file as data that a page draws at any scale, from panel to aperture."""

import json
import zlib
from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from mpfcad.mask.array import ApertureArray
from mpfcad.mask.check.check import READERS
from mpfcad.mask.check.found import Box, FoundMask
from mpfcad.mask.rule import GRID
from mpfcad.units import mm

#: Arrays that a page holds: a panel of one array a groove has as many as grooves.
MOST_ARRAYS = 100_000
#: Of a mask with more, a square in the middle.
WINDOW = 5.0 * mm
MOST_BYTES = 2_000_000


@dataclass(frozen=True)
class MaskZoom:
    """A mask for the page's own viewer.

    Attributes
    ----------
    name
        of the file
    is_whole
        whether it is the whole panel, or a window in its middle
    size
        of what is shown, across and along the grooves [mm]
    content
        JSON of outline, polarity and apertures, safe between the tags of a script
    """

    name: str
    is_whole: bool
    size: tuple[float, float]
    content: Markup


def mask_zoom(path: Path, pitch: float) -> MaskZoom | None:
    """Return the apertures of a mask file; None of pixels, and of a window that is too full.

    `pitch` [mm] is that of the grooves, whose tips are drawn.
    """
    reader = READERS.get(path.suffix.removeprefix("."))
    if reader is None:
        return None
    found = reader(path)
    table, box = _whole(found), found.outline
    is_whole = table is not None
    if table is None:
        box = _middle(found.outline)
        table = _window(found, box)
    packed = b64encode(zlib.compress(_packed(table), 9)).decode("ascii")
    if len(packed) > MOST_BYTES:
        return None
    content = {
        "outline": box,
        "pitch": round(pitch / GRID),
        "drawn": found.drawn,
        "count": len(table),
        "packed": packed,
    }
    size = ((box[2] - box[0]) * GRID, (box[3] - box[1]) * GRID)
    return MaskZoom(path.name, is_whole, size, Markup(json.dumps(content)))


def _whole(found: FoundMask) -> NDArray[np.int64] | None:
    """Return every array of the file, (n, 8) int64; None where there are too many."""
    rows: list[tuple[int, ...]] = []
    for array in found.arrays():
        if not isinstance(array.shape, tuple):
            return None
        offset = array.place.offset
        if len(rows) + (1 if offset is None else len(offset)) > MOST_ARRAYS:
            return None
        rows += _rows(array, array.shape)
    return np.array(rows, np.int64).reshape(-1, 8)


def _rows(array: ApertureArray, size: tuple[int, int]) -> list[tuple[int, ...]]:
    """Return left, bottom, width, length, columns, rows and their steps [nm] of an array."""
    place = array.place
    if place.offset is not None:
        return [(int(x), int(y), *size, 1, 1, 0, 0) for x, y in place.positions()]
    steps = place.column_step[0], place.row_step[1]
    return [(*place.origin, *size, place.columns, place.rows, *steps)]


def _middle(outline: Box) -> Box:
    """Return a square in the middle of a panel, cut at its edges."""
    half = round(WINDOW / GRID / 2)
    x, y = (outline[0] + outline[2]) // 2, (outline[1] + outline[3]) // 2
    return (
        max(x - half, outline[0]), max(y - half, outline[1]),
        min(x + half, outline[2]), min(y + half, outline[3]),
    )  # fmt: skip


def _window(found: FoundMask, box: Box) -> NDArray[np.int64]:
    """Return the apertures that touch a box, one row each, in a fixed order."""
    shapes = [shape.bbox() for shape in found.window(box).each()]
    rows = [(s.left, s.bottom, s.width(), s.height(), 1, 1, 0, 0) for s in shapes]
    return np.array(sorted(rows), np.int64).reshape(-1, 8)


def _packed(table: NDArray[np.int64]) -> bytes:
    """Return a table column by column, each as differences of neighbours: they repeat."""
    step = np.diff(table, axis=0, prepend=np.zeros((1, 8), np.int64))
    return np.ascontiguousarray(step.T).astype("<i4").tobytes()
