"""A drawing as GDSII with gdstk: one cell for each shape, arrays of references to it."""

import datetime
import errno
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.format.drawing import TOP, Drawing
from mpfcad.mask.layer import APERTURE, COUPON, OUTLINE, TEXT
from mpfcad.mask.rule import GRID
from mpfcad.units import um

if TYPE_CHECKING:
    import gdstk

#: GDSII counts the rows and columns of an array with 15 bits.
LARGEST_ARRAY = 32_767
#: GDSII stores when a file was made; this instant stands for "not told".
TIMESTAMP = datetime.datetime(2000, 1, 1)
_UM = GRID / um
#: Kind of the last record.
END_OF_LIBRARY = 4


def write_gdsii(drawing: Drawing, path: Path) -> None:
    """Write `drawing` to `path`."""
    _Library(drawing).library.write_gds(path, timestamp=TIMESTAMP)
    _check_whole(path)


def _check_whole(path: Path) -> None:
    """Refuse a file that a full disk cut short, which gdstk does not tell."""
    data, place, kind = path.read_bytes(), 0, 0
    while place + 4 <= len(data):
        size, kind = int.from_bytes(data[place : place + 2]), data[place + 2]
        place += max(size, 4)
    if place != len(data) or kind != END_OF_LIBRARY:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class _Library:
    """The cells of a drawing."""

    def __init__(self, drawing: Drawing) -> None:
        import gdstk

        self.library = gdstk.Library(TOP, unit=um * 1e-3, precision=GRID * 1e-3)
        self.shapes: dict[object, gdstk.Cell] = {}
        top = self.library.new_cell(TOP)
        top.add(gdstk.rectangle((0, 0), _um(drawing.width, drawing.length), layer=OUTLINE))
        for layer, points in drawing.polygons:
            top.add(gdstk.Polygon(points * _UM, layer=layer))
        for label in drawing.labels:
            top.add(gdstk.Label(label.text, _um(*label.position), anchor="sw", layer=TEXT))
        for array in drawing.arrays:
            self._place(top, self._shape(array, APERTURE), array.place)
        for array in drawing.coupon:
            self._place(top, self._shape(array, COUPON), array.place)
        cells = {}
        for tile in drawing.tile_cells():
            cells[tile.name] = self.library.new_cell(tile.name)
            for array in tile.arrays:
                self._place(cells[tile.name], self._shape(array, APERTURE), array.place)
        for placed in drawing.tiles:
            self._place(top, cells[placed.tile.name], placed.place)

    def _shape(self, array: ApertureArray, layer: int) -> "gdstk.Cell":
        """Return the cell that holds an array's shape."""
        import gdstk

        shape = array.shape
        key = (layer, shape if isinstance(shape, tuple) else shape.tobytes())
        if key not in self.shapes:
            if isinstance(shape, tuple):
                name = f"L{layer}R{shape[0]}X{shape[1]}"
                drawn = gdstk.rectangle((0, 0), _um(*shape), layer=layer)
            else:
                name = f"L{layer}P{len(self.shapes)}"
                drawn = gdstk.Polygon(shape * _UM, layer=layer)
            self.shapes[key] = self.library.new_cell(name)
            self.shapes[key].add(drawn)
        return self.shapes[key]

    def _place(self, into: "gdstk.Cell", cell: "gdstk.Cell", place: Placement) -> None:
        import gdstk

        if place.offset is not None:
            for x, y in place.positions():
                into.add(gdstk.Reference(cell, _um(x, y)))
            return
        for part in split_lattice(place):
            reference = gdstk.Reference(cell, _um(*part.origin))
            if part.count > 1:
                # A step of 0 would have no direction; one column has no step.
                steps = (np.array(s) * _UM for s in (part.column_step, part.row_step))
                columns, rows = (s if s.any() else d for s, d in zip(steps, _UNIT, strict=True))
                reference.repetition = gdstk.Repetition(
                    columns=part.columns, rows=part.rows, v1=tuple(columns), v2=tuple(rows)
                )
            into.add(reference)


_UNIT = (np.array((1.0, 0.0)), np.array((0.0, 1.0)))


def split_lattice(place: Placement) -> Iterator[Placement]:
    """Yield lattices of at most 32,767 columns and rows that make up one lattice."""
    for i in range(0, place.columns, LARGEST_ARRAY):
        for j in range(0, place.rows, LARGEST_ARRAY):
            x, y = (
                place.origin[k] + i * place.column_step[k] + j * place.row_step[k] for k in (0, 1)
            )
            columns = min(LARGEST_ARRAY, place.columns - i)
            rows = min(LARGEST_ARRAY, place.rows - j)
            yield Placement((x, y), columns, rows, place.column_step, place.row_step)


def _um(x: int, y: int) -> tuple[float, float]:
    """Return grid steps as µm, the unit of the file."""
    return float(x) * _UM, float(y) * _UM
