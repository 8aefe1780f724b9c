"""A mask file that a maker sends back against the mask it should be, groove by groove.

The file may be moved as a whole, mirrored, complemented or drawn as merged polygons, and may have
lost its text: what counts is what is open over each groove.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError
from mpfcad.mask.aperture import Mask
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.check.fingerprint import fingerprint
from mpfcad.mask.check.read_gerber import read_gerber
from mpfcad.mask.check.read_layout import check_unit, layout_arrays, open_layout
from mpfcad.mask.check.tally import Tally
from mpfcad.mask.format.drawing import draw
from mpfcad.mask.format.flat import listed_tiles
from mpfcad.mask.layer import APERTURE, OUTLINE
from mpfcad.mask.phototool import Phototool
from mpfcad.mask.rule import GRID

if TYPE_CHECKING:
    import klayout.db as kdb

#: Formats that can come back.
RETURNED = ("gds", "oas", "gbr", "dxf")
#: Shapes that are looked at one by one, at most.
MOST_SHAPES = 20_000_000
#: Ratios of a groove that differ by less are the same: a nanometre of a slot in a long groove.
SAME_RATIO = 1e-9


@dataclass(frozen=True, eq=False)
class Comparison:
    """How a returned file differs; grooves counted from 0, left to right as designed.

    Attributes
    ----------
    moved
        (x, y) that the whole drawing is shifted by [mm]
    mirrored, complemented
        against what was ordered
    ratio, wanted
        (n,) float64, aperture ratio of each groove in the file, and as drawn
    count, wanted_count
        apertures
    different
        (k,) int64, grooves in which any aperture differs; None where the file's shapes are gathered
        otherwise, so that only ratios tell
    size
        of the panel in the file [mm]
    """

    moved: tuple[float, float]
    mirrored: bool
    complemented: bool
    ratio: NDArray[np.float64]
    wanted: NDArray[np.float64]
    count: int
    wanted_count: int
    different: NDArray[np.int64] | None
    size: tuple[float, float]

    @property
    def grooves(self) -> NDArray[np.int64]:
        """The grooves that differ."""
        off = np.abs(self.ratio - self.wanted) > SAME_RATIO
        if self.different is not None:
            off[self.different] = True
        return np.flatnonzero(off)

    @property
    def is_same(self) -> bool:
        """Whether the file is what was ordered."""
        return not (self.grooves.size or self.mirrored or self.complemented or any(self.moved))


def compare_mask(path: Path, mask: Mask, phototool: Phototool) -> Comparison:
    """Return how the file at `path` differs from a mask as it was handed over.

    Raises
    ------
    ExportError
        when the file cannot be read, or its panel has another size.
    """
    arrays, outline = _read(path)
    width, length = round(mask.width / GRID), round(mask.length / GRID)
    left, bottom = outline[0], outline[1]
    size = (outline[2] - left, outline[3] - bottom)
    if size != (width, length):
        raise ExportError(
            f"{path}: panel {size[0] * GRID:.6f} x {size[1] * GRID:.6f} mm: expected "
            f"{width * GRID:.6f} x {length * GRID:.6f}"
        )
    arrays = [_shifted(array, -left, -bottom) for array in arrays]
    edge = np.rint(np.arange(mask.groove_count + 1) * mask.pitch / GRID).astype(np.int64)
    drawn_edge = edge[-1] - edge[::-1] if phototool.mirror else edge
    tally = Tally(path, drawn_edge, np.array([0.0, length]), np.array([0.0, width]))
    for array in arrays:
        tally.add(array)
    tally.finish()
    found = tally.groove_area / (np.diff(drawn_edge).astype(float) * length)
    drawing = draw(mask, phototool, paints=True)
    wanted = mask.aperture_ratio * mask.pitch / (np.diff(edge) * GRID)
    there = wanted[::-1] if phototool.mirror else wanted
    closed = phototool.polarity == "closed" and path.suffix != ".gbr"
    turned = {
        (mirrored, complemented): np.abs(
            (1 - found if complemented != closed else found)[:: -1 if mirrored else 1] - there
        ).max()
        for mirrored in (False, True)
        for complemented in (False, True)
    }
    mirrored, complemented = min(turned, key=lambda key: (turned[key], key))
    if turned[mirrored, complemented] > 0.5 * turned[False, False]:
        mirrored = complemented = False
    ratio = (1 - found if complemented != closed else found)[:: -1 if mirrored else 1]
    different = None
    if not (mirrored or complemented or closed) and tally.count == mask.aperture_count:
        held = [*drawing.arrays, *listed_tiles(drawing)]
        different = np.flatnonzero(fingerprint(arrays, drawn_edge) != fingerprint(held, drawn_edge))
    if phototool.mirror:
        ratio = ratio[::-1]
        different = None if different is None else mask.groove_count - 1 - different[::-1]
    return Comparison(
        (left * GRID, bottom * GRID), mirrored, complemented, ratio, wanted, tally.count,
        mask.aperture_count, different, (size[0] * GRID, size[1] * GRID),
    )  # fmt: skip


def _read(path: Path) -> tuple[list[ApertureArray], tuple[int, int, int, int]]:
    """Return what stands on the aperture layer, and the panel's outline."""
    if path.suffix == ".gbr":
        found = read_gerber(path)
        return list(found.arrays()), found.outline
    layout = open_layout(path)
    if path.suffix == ".dxf":
        check_unit(path)
    layer = layout.find_layer(OUTLINE, 0)
    box = None if layer is None else layout.top_cell().bbox(layer)
    if box is None or box.empty():
        raise ExportError(f"{path}: layer {OUTLINE}/0: nothing: expected the panel's outline")
    outline = (box.left, box.bottom, box.right, box.top)
    try:
        return list(layout_arrays(path, layout, APERTURE)), outline
    except ExportError:
        return list(_boxes(path, layout)), outline


def _boxes(path: Path, layout: "kdb.Layout") -> Iterator[ApertureArray]:
    """Yield the aperture layer's shapes one by one, polygons cut into rectangles."""
    import klayout.db as kdb

    layer = layout.find_layer(APERTURE, 0)
    if layer is None:
        return
    region = kdb.Region(layout.top_cell().begin_shapes_rec(layer))
    if region.count() > MOST_SHAPES:
        raise ExportError(f"{path}: over {MOST_SHAPES} shapes: expected arrays of references")
    for polygon in region.merged().decompose_trapezoids_to_region().each():
        if not polygon.is_box():
            raise ExportError(f"{path}: an aperture with slanted edges: expected rectangles")
        box: Any = polygon.bbox()
        yield ApertureArray((box.width(), box.height()), Placement((box.left, box.bottom)))


def _shifted(array: ApertureArray, dx: int, dy: int) -> ApertureArray:
    place = array.place
    if not (dx or dy):
        return array
    origin = (place.origin[0] + dx, place.origin[1] + dy)
    steps = (place.column_step, place.row_step)
    moved = Placement(origin, place.columns, place.rows, *steps, place.offset)
    return ApertureArray(array.shape, moved)


def _told_apart(value: float, other: float) -> tuple[str, str]:
    """Return two numbers of so many digits, six or more, that they differ as printed."""
    digits = next(d for d in (6, 8, 10, 12) if f"{value:.{d}f}" != f"{other:.{d}f}")
    return f"{value:.{digits}f}", f"{other:.{digits}f}"


def comparison_lines(found: Comparison, most: int = 20) -> list[str]:
    """Return a comparison as lines of text."""
    lines = []
    if any(found.moved):
        lines.append("moved as a whole by {:.6f}, {:.6f} mm".format(*found.moved))
    if found.mirrored:
        lines.append("mirrored against what was ordered")
    if found.complemented:
        lines.append("open and closed are exchanged")
    if found.count != found.wanted_count:
        lines.append(f"drawn as {found.count} shapes instead of {found.wanted_count} apertures")
    grooves = found.grooves
    for groove in grooves[:most]:
        ratio, wanted = found.ratio[groove], found.wanted[groove]
        if abs(ratio - wanted) > SAME_RATIO:
            seen, right = _told_apart(ratio, wanted)
            lines.append(f"groove {groove}: aperture ratio {seen}: expected {right}")
        else:
            lines.append(
                f"groove {groove}: an aperture lies elsewhere, or is of another shape: expected "
                f"it as ordered, of the same aperture ratio, {wanted:.6f}"
            )
    if grooves.size > most:
        lines.append(f"… {grooves.size} grooves differ in all, of {len(found.ratio)}")
    if found.is_same:
        lines.append(f"the same in all {len(found.ratio)} grooves")
    return lines
