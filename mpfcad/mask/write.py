"""A mask to an OASIS or GDSII file with gdstk, its arrays kept symbolic, the same bytes each time.

One cell for each distinct rectangle and one array of references to it for each groove. Layers: 1/0
aperture, 2/0 outline of the panel, 10/0 four fiducials, 11/0 text.
"""

import datetime
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.errors import InputError
from mpfcad.mask.aperture import Mask
from mpfcad.mask.rule import GRID
from mpfcad.units import um

if TYPE_CHECKING:
    import gdstk

APERTURE, OUTLINE, FIDUCIAL, TEXT = 1, 2, 10, 11
#: GDSII counts the rows and columns of an array with 15 bits.
LARGEST_ARRAY = 32_767
#: GDSII stores when a file was made; this instant stands for "not told".
TIMESTAMP = datetime.datetime(2000, 1, 1)

# Furniture [µm], outside the panel by these distances.
FIDUCIAL_OFFSET, FIDUCIAL_SIZE, FIDUCIAL_LINE = 10_000.0, 4_000.0, 200.0
TEXT_OFFSET, TEXT_SIZE = 20_000.0, 3_000.0


def write_mask(mask: Mask, path: Path) -> None:
    """Write the mask to `path`; its suffix, .oas or .gds, says in which format.

    Raises
    ------
    InputError
        for another suffix.
    """
    path = Path(path)
    if path.suffix not in (".oas", ".gds"):
        raise InputError(f"{path}: mask format {path.suffix!r}: allowed .oas or .gds")
    library = draw_mask(mask)
    part = path.with_name(f".{path.name}.part")
    try:
        if path.suffix == ".oas":
            library.write_oas(part, validation="crc32")
        else:
            library.write_gds(part, timestamp=TIMESTAMP)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def mask_text(mask: Mask) -> tuple[str, str]:
    """Return the two lines of text on a mask: what it is, and how to look at it."""
    return (
        f"{mask.name} sha256:{mask.content_hash}",
        "drawn = open; seen from the squeegee side, emulsion on the far side, to the film",
    )


def draw_mask(mask: Mask) -> "gdstk.Library":
    """Return the mask as a gdstk library with the top cell MASK."""
    import gdstk

    library = gdstk.Library("MASK", unit=1e-6, precision=1e-9)
    top = library.new_cell("MASK")
    width, length = mask.groove_count * mask.pitch / um, mask.length / um
    top.add(gdstk.rectangle((0, 0), (_snap(width), _snap(length)), layer=OUTLINE))
    _add_furniture(library, top, mask, width, length)
    cells: dict[tuple[int, int], Any] = {}
    for i in np.flatnonzero(mask.is_open):
        size = (int(mask.across[i]), int(mask.along[i]))
        if size not in cells:
            cells[size] = library.new_cell(f"A{size[0]}X{size[1]}")
            cells[size].add(gdstk.rectangle((0, 0), _to_um(*size), layer=APERTURE))
        for first, count in array_chunks(mask.period_count):
            bottom = int(mask.bottom[i]) + first * mask.period_steps
            top.add(
                gdstk.Reference(
                    cells[size],
                    _to_um(int(mask.left[i]), bottom),
                    columns=1,
                    rows=count,
                    spacing=_to_um(size[0], mask.period_steps),
                )
            )
    return library


def array_chunks(count: int) -> Iterator[tuple[int, int]]:
    """Yield first row and number of rows of the arrays that `count` rows are split into."""
    for first in range(0, count, LARGEST_ARRAY):
        yield first, min(LARGEST_ARRAY, count - first)


def _to_um(x: int, y: int) -> tuple[float, float]:
    """Return grid steps as µm, the unit of the file."""
    return x * (GRID / um), y * (GRID / um)


def _snap(length: float) -> float:
    """Return a length [µm] on the grid."""
    return round(length * um / GRID) * (GRID / um)


def _add_furniture(
    library: "gdstk.Library", top: "gdstk.Cell", mask: Mask, width: float, length: float
) -> None:
    """Add crosses off the four corners and the text, drawn and as labels below; lengths in µm."""
    import gdstk

    cross = library.new_cell("FIDUCIAL")
    cross.add(gdstk.cross((0, 0), FIDUCIAL_SIZE, FIDUCIAL_LINE, layer=FIDUCIAL))
    for x in (-FIDUCIAL_OFFSET, _snap(width) + FIDUCIAL_OFFSET):
        for y in (-FIDUCIAL_OFFSET, _snap(length) + FIDUCIAL_OFFSET):
            top.add(gdstk.Reference(cross, (x, y)))
    lines = mask_text(mask)
    for i, line in enumerate(lines):
        foot = -TEXT_OFFSET - 1.5 * i * TEXT_SIZE
        top.add(*gdstk.text(line, TEXT_SIZE, (0.0, foot), layer=TEXT))
        below = foot - 1.5 * len(lines) * TEXT_SIZE
        top.add(gdstk.Label(line, (0.0, below), anchor="sw", layer=TEXT))
