"""A mask file read back by another library than wrote it: ratios, features, text, furniture.

The arrays are never flattened. Each groove's and each square's open area, the smallest aperture and
web, polarity, mirroring and furniture are found from the file alone and compared with what was
wanted; klayout then looks at sampled windows.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError
from mpfcad.film import groove_ranges
from mpfcad.mask.aperture import Mask, square_edges
from mpfcad.mask.array import ApertureArray
from mpfcad.mask.check.drc import WindowCheck, check_windows, sample_windows
from mpfcad.mask.check.fingerprint import different_grooves, fingerprint
from mpfcad.mask.check.found import FoundMask
from mpfcad.mask.check.read_gerber import read_gerber
from mpfcad.mask.check.read_layout import read_layout
from mpfcad.mask.check.read_oasis import read_oasis
from mpfcad.mask.check.read_svg import read_svg
from mpfcad.mask.check.read_tiff import read_tiff
from mpfcad.mask.check.tally import Tally
from mpfcad.mask.format.drawing import draw
from mpfcad.mask.format.flat import listed_tiles
from mpfcad.mask.phototool import Phototool, Polarity
from mpfcad.mask.rule import GRID
from mpfcad.mask.told import Told, untold
from mpfcad.units import mm

#: Side of the squares of the ratio map.
SQUARE = 1.0 * mm
READERS: dict[str, Callable[[Path], FoundMask]] = {
    "oas": read_oasis,
    "gds": read_layout,
    "dxf": read_layout,
    "gbr": read_gerber,
    "svg": read_svg,
}


@dataclass(frozen=True, eq=False)
class MaskCheck:
    """What a mask file holds, as read back; lengths in mm.

    Attributes
    ----------
    aperture_ratio
        (n,) float64, open area over area of each groove; neither mirrored nor inverted
    aperture_ratio_error_max
        largest distance from the wanted aperture ratio
    ratio_map
        (along, across) float64, open area over area of squares of 1 mm
    ratio_map_error_max
        largest distance from what the mask should have there
    aperture_count
        number of apertures; None where webs or pixels are drawn
    smallest_aperture, smallest_web
        narrowest opening, and narrowest stretch between openings; None where there is none, or
        where webs or pixels are drawn
    width, length
        of the panel
    unit
        database unit, or pixel [µm]
    snap_error
        how far an edge may be from where it should be
    fiducial_count
        crosses outside the outline; None where pixels are drawn
    text
        the lines of text
    windows
        what klayout found in sampled windows; None where pixels are drawn
    """

    aperture_ratio: NDArray[np.float64]
    aperture_ratio_error_max: float
    ratio_map: NDArray[np.float64]
    ratio_map_error_max: float
    aperture_count: int | None
    smallest_aperture: float | None
    smallest_web: float | None
    width: float
    length: float
    unit: float
    snap_error: float
    fiducial_count: int | None
    text: tuple[str, ...]
    windows: WindowCheck | None


def check_mask(
    path: Path, mask: Mask, phototool: Phototool | None = None, told: Told = untold
) -> MaskCheck:
    """Read a mask file and compare it with what was wanted of `mask`.

    `told` gets the share of a picture that is read, as it grows. Ratios, features and what is too
    narrow are measured; a gate judges them.

    Raises
    ------
    ExportError
        when the file holds something else than was written.
    """
    path = Path(path)
    phototool = phototool or Phototool()
    suffix = path.suffix.removeprefix(".")
    if not path.is_file() or suffix not in (*READERS, "tif"):
        raise ExportError(f"{path}: not a readable mask: no such file")
    if suffix == "tif":
        return _check_pixels(path, mask, phototool, told)
    return _check_arrays(path, mask, phototool, READERS[suffix](path))


def _check_arrays(path: Path, mask: Mask, phototool: Phototool, found: FoundMask) -> MaskCheck:
    width, length = round(mask.width / GRID), round(mask.length / GRID)
    if found.outline != (0, 0, width, length):
        raise ExportError(f"{path}: outline {found.outline}: expected {(0, 0, width, length)} (nm)")
    tally = Tally(
        path,
        _groove_edges(mask, phototool),
        *_squares(mask, phototool),
        is_slot=mask.rules.pattern == "slot",
        is_tiled=not mask.is_lattice,
    )
    for array in found.arrays():
        tally.add(array)
    is_open = found.drawn == "open"
    tally.finish()
    ratio, squares = _ratios(mask, tally.groove_area, tally.square_area, phototool, found.drawn)
    error = _ratio_error(mask, ratio)
    _check_apertures(path, mask, phototool, found)
    if is_open and tally.count != mask.aperture_count:
        raise ExportError(f"{path}: {tally.count} apertures: expected {mask.aperture_count}")
    _check_text(path, mask, phototool, found.text)
    _check_furniture(path, mask, phototool, found)
    if is_open:
        tally.measure()
    windows = check_windows(
        found, mask.rules, sample_windows(found.outline, _extremes(mask, phototool, ratio))
    )
    return MaskCheck(
        aperture_ratio=ratio,
        aperture_ratio_error_max=error,
        ratio_map=squares,
        ratio_map_error_max=float(np.abs(squares - mask.ratio_map(SQUARE)).max()),
        aperture_count=tally.count if is_open else None,
        smallest_aperture=_in_mm(tally.smallest_aperture),
        smallest_web=_in_mm(tally.smallest_web),
        width=width * GRID,
        length=length * GRID,
        unit=found.unit,
        snap_error=found.snap_error,
        fiducial_count=len(found.fiducials),
        text=found.text,
        windows=windows,
    )


def _check_apertures(path: Path, mask: Mask, phototool: Phototool, found: FoundMask) -> None:
    """Refuse a file in which any aperture is not the one that was written, groove named."""
    edge = _groove_edges(mask, phototool)
    drawing = draw(mask, phototool, paints=found.drawn != phototool.polarity)
    wanted = fingerprint(chain(drawing.arrays, listed_tiles(drawing)), edge)
    different = different_grooves(fingerprint(found.arrays(), edge), wanted)
    if different.size:
        if phototool.mirror:
            different = np.sort(mask.groove_count - 1 - different)
        raise ExportError(
            f"{path}: {groove_ranges(different)} (counted from 0): an aperture is not where, or "
            f"not as large as, it should be"
        )


def _check_pixels(path: Path, mask: Mask, phototool: Phototool, told: Told) -> MaskCheck:
    along, across = square_edges(mask.length, SQUARE), square_edges(mask.width, SQUARE)
    if phototool.mirror:
        across = mask.width - across[::-1]
    found = read_tiff(path, mask.width, mask.length, (along, across), told)
    tips = _groove_edges(mask, phototool) * (GRID / found.pixel)
    total = np.concatenate([[0.0], np.cumsum(found.column_area)])
    area = np.diff(np.interp(tips, np.arange(len(total)), total)) * (found.pixel / GRID) ** 2
    squares = found.square_area / found.square_pixels
    grid = np.outer(np.diff(along), np.diff(across)) / GRID**2
    ratio, squares = _ratios(mask, area, squares * grid, phototool, phototool.polarity)
    error = _ratio_error(mask, ratio)
    _check_text(path, mask, phototool, found.text)
    return MaskCheck(
        aperture_ratio=ratio,
        aperture_ratio_error_max=error,
        ratio_map=squares,
        ratio_map_error_max=float(np.abs(squares - mask.ratio_map(SQUARE)).max()),
        aperture_count=None,
        smallest_aperture=None,
        smallest_web=None,
        width=mask.width,
        length=mask.length,
        unit=found.pixel * 1000,
        snap_error=found.pixel / 2,
        fiducial_count=None,
        text=found.text,
        windows=None,
    )


def _groove_edges(mask: Mask, phototool: Phototool) -> NDArray[np.int64]:
    """Return the tips as they are in the file, left to right [grid steps]."""
    edge = np.rint(np.arange(mask.groove_count + 1) * mask.pitch / GRID).astype(np.int64)
    return edge[-1] - edge[::-1] if phototool.mirror else edge


def _squares(mask: Mask, phototool: Phototool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the edges of the squares along and across as they are in the file [grid steps]."""
    along = square_edges(mask.length, SQUARE) / GRID
    across = square_edges(mask.width, SQUARE) / GRID
    return along, across[-1] - across[::-1] if phototool.mirror else across


def _ratios(
    mask: Mask,
    groove_area: NDArray[np.float64],
    square_area: NDArray[np.float64],
    phototool: Phototool,
    drawn: Polarity,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return open over whole area a groove and a square, neither mirrored nor inverted."""
    along, across = _squares(mask, phototool)
    ratio = groove_area * GRID**2 / (mask.pitch * mask.length)
    squares = square_area / np.outer(np.diff(along), np.diff(across))
    if drawn == "closed":
        ratio, squares = 1 - ratio, 1 - squares
    if phototool.mirror:
        ratio, squares = ratio[::-1], squares[:, ::-1]
    return ratio, squares


def _extremes(mask: Mask, phototool: Phototool, ratio: NDArray[np.float64]) -> tuple[int, ...]:
    """Return x of the grooves with the smallest and the largest ratio [grid steps]."""
    grooves = np.array([np.argmin(ratio), np.argmax(ratio)])
    if phototool.mirror:
        grooves = mask.groove_count - 1 - grooves
    return tuple(round(float(g + 0.5) * mask.pitch / GRID) for g in grooves)


def _ratio_error(mask: Mask, ratio: NDArray[np.float64]) -> float:
    """Return the largest error of a groove's ratio; a gate judges it."""
    return float(np.abs(ratio - mask.wanted_ratio).max())


def _check_text(path: Path, mask: Mask, phototool: Phototool, text: tuple[str, ...]) -> None:
    """Refuse a text without name and hash, or with another polarity, view or emulsion side."""
    if f"{mask.name} sha256:{mask.content_hash}" not in text:
        raise ExportError(f"{path}: text: expected {mask.name!r} with hash {mask.content_hash}")
    for line in (phototool.statement, *phototool.notes):
        if line not in text:
            raise ExportError(f"{path}: text: expected {line!r}")


def _check_furniture(path: Path, mask: Mask, phototool: Phototool, found: FoundMask) -> None:
    """Refuse a wrong number of fiducials, one inside the panel, and another coupon."""
    wanted = 4 if "fiducial" in phototool.furniture else 0
    if len(found.fiducials) != wanted:
        raise ExportError(f"{path}: {len(found.fiducials)} fiducials: expected {wanted}")
    left, bottom, right, top = found.outline
    for box in found.fiducials:
        if box[2] > left and box[0] < right and box[3] > bottom and box[1] < top:
            raise ExportError(f"{path}: a fiducial inside the panel")
    if _patches(found.coupon) != _patches(draw(mask, phototool, paints=True).coupon):
        raise ExportError(f"{path}: coupon: expected the step wedge")


def _patches(coupon: tuple[ApertureArray, ...]) -> list[tuple[int, ...]]:
    """Return the patches of a wedge: place, size, number and distance of their slots."""
    return sorted(
        (*array.place.origin, *array.size, array.place.rows, max(1, array.place.rows) > 1
         and array.place.row_step[1])
        for array in coupon
    )  # fmt: skip


def _in_mm(steps: int | None) -> float | None:
    return None if steps is None else steps * GRID
