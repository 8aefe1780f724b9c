"""A mask as it is drawn: polarity and mirroring done, furniture around it, ready for any format."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mpfcad.errors import InputError
from mpfcad.mask.aperture import Mask
from mpfcad.mask.array import ApertureArray, Placement, Tile, TileArray
from mpfcad.mask.format.furniture import (
    Label,
    Polygon,
    draw_coupon,
    draw_fiducials,
    draw_lines,
    wedge_ratios,
)
from mpfcad.mask.phototool import Phototool
from mpfcad.mask.rule import GRID

#: The top cell.
TOP = "MASK"


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a writer draws; grid steps, (0, 0) at the panel's lower left corner.

    Attributes
    ----------
    mask, phototool
        what it is drawn from; `mask` is neither mirrored nor inverted
    polygons
        furniture: layer and vertices
    coupon
        apertures of the step wedge
    labels
        text elements
    inverted
        whether `arrays` hold what is closed; a format that paints inverts by itself
    """

    mask: Mask
    phototool: Phototool
    polygons: tuple[Polygon, ...]
    coupon: tuple[ApertureArray, ...]
    labels: tuple[Label, ...]
    inverted: bool

    @property
    def width(self) -> int:
        """Of the panel."""
        return round(self.mask.width / GRID)

    @property
    def length(self) -> int:
        """Of the panel."""
        return round(self.mask.length / GRID)

    def bounds(self) -> tuple[int, int, int, int]:
        """Return left, bottom, right, top of everything that is drawn."""
        box = np.array([0, 0, self.width, self.length])
        corners = [points for _, points in self.polygons]
        for array in self.coupon:
            place, (left, bottom, right, top) = array.place, array.box
            last = (place.rows - 1) * place.row_step[1]
            spans = [(left, bottom), (right, top + last)]
            corners.append(np.array(place.origin) + np.array(spans))
        for points in corners:
            box[:2] = np.minimum(box[:2], points.min(axis=0))
            box[2:] = np.maximum(box[2:], points.max(axis=0))
        left, bottom, right, top = (int(value) for value in box)
        return left, bottom, right, top

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """The lines of text: what it is, how to look at it, and what the order says."""
        name = f"{self.mask.name} sha256:{self.mask.content_hash}"
        return (name, self.phototool.statement, *self.phototool.notes)

    @property
    def arrays(self) -> Iterator[ApertureArray]:
        """The arrays of the aperture layer, one after the other."""
        arrays, closed = self.mask.arrays, self.mask.closed_arrays
        if self.inverted and closed is not None:  # `draw` refuses others
            arrays = closed
        if self.phototool.mirror:
            return (mirror_array(array, self.width) for array in arrays)
        return iter(arrays)

    @property
    def tiles(self) -> Iterator[TileArray]:
        """The tiles of the aperture layer."""
        for array in self.mask.tile_arrays:
            if self.phototool.mirror:
                width = array.tile.size[0]
                place = mirror_place(array.place, self.width - width)
                yield TileArray(self._mirrored[array.tile.name], place)
            else:
                yield array

    def tile_cells(self) -> tuple[Tile, ...]:
        """Return every tile once."""
        return tuple({array.tile.name: array.tile for array in self.tiles}.values())

    @cached_property
    def _mirrored(self) -> dict[str, Tile]:
        tiles = {array.tile.name: array.tile for array in self.mask.tile_arrays}
        return {
            name: replace(tile, arrays=tuple(mirror_array(a, tile.size[0]) for a in tile.arrays))
            for name, tile in tiles.items()
        }


def draw(mask: Mask, phototool: Phototool, *, paints: bool = False) -> Drawing:
    """Return the drawing of a mask; `paints`: the format can draw open on closed.

    Raises
    ------
    InputError
        when what is closed cannot be drawn in a format that does not paint.
    """
    width, length = round(mask.width / GRID), round(mask.length / GRID)
    inverted = phototool.polarity == "closed" and not paints
    if inverted and mask.closed_arrays is None:
        raise InputError(
            f"{mask.name}: mask.polarity: closed: expected for patterns with one array a groove, "
            f"or in formats gbr, svg, tif"
        )
    drawing = Drawing(mask, phototool, (), (), (), inverted)
    polygons: list[Polygon] = []
    coupon: list[ApertureArray] = []
    if "fiducial" in phototool.furniture:
        polygons += draw_fiducials(width, length)
    letters, labels = draw_lines(drawing.lines)  # the text elements are never left out
    if "text" in phototool.furniture:
        polygons += letters
    if "coupon" in phototool.furniture:
        coupon, frame = draw_coupon(mask.rules, length, phototool.polarity, wedge_ratios(mask))
        polygons += frame
    if phototool.mirror:
        polygons = [(layer, points * (-1, 1) + (width, 0)) for layer, points in polygons]
        coupon = [mirror_array(array, width) for array in coupon]
        labels = [Label(label.text, (width - label.position[0], label.position[1]))
                  for label in labels]  # fmt: skip
    return replace(drawing, polygons=tuple(polygons), coupon=tuple(coupon), labels=tuple(labels))


def mirror_place(place: Placement, width: int) -> Placement:
    """Return a placement mirrored: x becomes width - x; steps across stay positive."""
    if place.offset is not None:
        origin = (width - place.origin[0], place.origin[1])
        return Placement(origin, offset=place.offset * (-1, 1))
    x, y = width - place.origin[0], place.origin[1]
    steps = []
    lattice = ((place.columns, place.column_step), (place.rows, place.row_step))
    for count, (dx, dy) in lattice:
        if dx > 0:  # start at the other end
            x, y = x - (count - 1) * dx, y + (count - 1) * dy
            dy = -dy
        steps.append((abs(dx), dy))
    return Placement((x, y), place.columns, place.rows, steps[0], steps[1])


def mirror_array(array: ApertureArray, width: int) -> ApertureArray:
    """Return an array mirrored: x becomes width - x."""
    if isinstance(array.shape, tuple):
        return ApertureArray(array.shape, mirror_place(array.place, width - array.shape[0]))
    return ApertureArray(array.shape * np.array([-1, 1]), mirror_place(array.place, width))
