"""What a reader hands over of a mask file, whatever its format; grid steps."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.errors import ExportError
from mpfcad.mask.array import ApertureArray
from mpfcad.mask.format.flat import columns_of
from mpfcad.mask.phototool import Polarity

if TYPE_CHECKING:
    import klayout.db as kdb

#: Left, bottom, right, top.
Box = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class FoundMask:
    """What a mask file holds.

    Attributes
    ----------
    outline
        of the panel
    unit
        database unit, or what takes its place [µm]
    text
        the lines of text
    fiducials
        bounding boxes of the crosses
    coupon
        apertures of the step wedge
    drawn
        what `arrays` are: what is open, or what is closed
    arrays
        gives the apertures, one array after the other
    window
        gives the apertures that touch a box, each whole
    snap_error
        how far an edge of the file may be from the grid it was drawn on
    """

    outline: Box
    unit: float
    text: tuple[str, ...]
    fiducials: tuple[Box, ...]
    coupon: tuple[ApertureArray, ...]
    drawn: Polarity
    arrays: Callable[[], Iterator[ApertureArray]]
    window: Callable[[Box], "kdb.Region"]
    snap_error: float = 0.0


def read_polarity(path: Path, text: tuple[str, ...]) -> Polarity:
    """Return the polarity that the file's text states.

    Raises
    ------
    ExportError
        when it states none.
    """
    for polarity in ("open", "closed"):
        if any(line.startswith(f"drawn = {polarity};") for line in text):
            return polarity
    raise ExportError(f"{path}: text: states no polarity: expected 'drawn = open' or 'closed'")


def region_of(arrays: Iterator[ApertureArray], box: Box) -> "kdb.Region":
    """Return the rectangles that touch a box, each whole."""
    import klayout.db as kdb

    region = kdb.Region()
    for array in columns_of(arrays):
        (x, y), (width, length) = array.place.origin, array.size
        x, y = x + array.box[0], y + array.box[1]
        if x > box[2] or x + width < box[0]:
            continue
        step = array.place.row_step[1] or 1
        first = max(0, -(-(box[1] - y - length) // step))
        last = min(array.place.rows - 1, (box[3] - y) // step)
        for k in range(first, last + 1):
            region.insert(kdb.Box(x, y + k * step, x + width, y + k * step + length))
    return region
