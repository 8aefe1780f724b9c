"""A drawing as Gerber RS-274X, in mm on the 1 nm grid; its X2 attributes stand in comments.

One rectangular aperture a size, flashed; neighbours of the same lattice share one step-and-repeat
block. A flash is named by its centre, so an odd size stands half a grid step to the left. What is
closed is painted first and opened with clear polarity.
"""

from collections.abc import Iterable
from itertools import groupby
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.array import ApertureArray
from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.format.flat import flat_tiles
from mpfcad.mask.layer import APERTURE, COUPON, LAYERS, OUTLINE
from mpfcad.mask.rule import GRID

#: Width of the line that runs around the panel, outside of it [grid steps].
OUTLINE_WIDTH = 100_000
FIRST_CODE = 10


def write_gerber(drawing: Drawing, path: Path) -> None:
    """Write `drawing` to `path`."""
    with path.open("w", encoding="ascii", newline="\n") as file:
        for line in drawing.lines:
            file.write(f"G04 {line}*\n")
        file.write("G04 #@! TF.FileFunction,Other,Screen mask*\nG04 #@! TF.Part,Single*\n")
        file.write("%FSLAX46Y46*%\n%MOMM*%\n%LPD*%\nG01*\n")
        artist = _Artist(file)
        artist.outline(drawing.width, drawing.length)
        for layer, points in drawing.polygons:
            artist.polygon(layer, points)
        artist.flash(COUPON, drawing.coupon)
        if drawing.phototool.polarity == "closed":
            size = np.array([drawing.width, drawing.length])
            box = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * size
            artist.polygon(APERTURE, box)
            file.write("%LPC*%\n")
        artist.flash(APERTURE, drawing.arrays)
        artist.flash(APERTURE, flat_tiles(drawing))
        file.write("M02*\n")


class _Artist:
    """Writes commands, and remembers layer and aperture."""

    def __init__(self, file: TextIO) -> None:
        self.file = file
        self.layer = 0
        self.codes: dict[object, int] = {}
        self.code = 0

    def outline(self, width: int, length: int) -> None:
        self._layer(OUTLINE)
        self._use(f"C,{_mm(OUTLINE_WIDTH)}")
        d = OUTLINE_WIDTH // 2
        corners = ((-d, -d), (width + d, -d), (width + d, length + d), (-d, length + d), (-d, -d))
        for i, corner in enumerate(corners):
            self._point(corner, 1 if i else 2)

    def polygon(self, layer: int, points: NDArray[np.int64]) -> None:
        self._layer(layer)
        self.file.write("G36*\n")
        for i, point in enumerate((*points, points[0])):
            self._point(point, 1 if i else 2)
        self.file.write("G37*\n")

    def flash(self, layer: int, arrays: Iterable[ApertureArray]) -> None:
        self._layer(layer)
        for lattice, group in groupby(arrays, key=_lattice):
            if lattice != (1, 1, 0, 0):
                columns, rows, x, y = lattice
                self.file.write(f"%SRX{columns}Y{rows}I{_mm(x)}J{_mm(y)}*%\n")
            for array in group:
                self._flash_one(array, flatten=lattice == (1, 1, 0, 0))
            if lattice != (1, 1, 0, 0):
                self.file.write("%SR*%\n")

    def _flash_one(self, array: ApertureArray, *, flatten: bool) -> None:
        places = array.place.positions() if flatten else (array.place.origin,)
        if not isinstance(array.shape, tuple):
            for at in places:
                self.polygon(self.layer, array.shape + np.asarray(at))
            return
        width, length = array.shape
        self._use(f"R,{_mm(width)}X{_mm(length)}")
        for x, y in places:
            self._point((int(x) + width // 2, int(y) + length // 2), 3)

    def _layer(self, layer: int) -> None:
        if layer != self.layer:
            self.file.write(f"G04 #@! TA.AperFunction,Other,{LAYERS[layer]}*\n")
            self.layer, self.code = layer, 0

    def _use(self, shape: str) -> None:
        key = (self.layer, shape)
        if key not in self.codes:
            self.codes[key] = FIRST_CODE + len(self.codes)
            self.file.write(f"%ADD{self.codes[key]}{shape}*%\n")
        if self.code != self.codes[key]:
            self.code = self.codes[key]
            self.file.write(f"D{self.code}*\n")

    def _point(self, point: Iterable[int], operation: int) -> None:
        x, y = point
        self.file.write(f"X{int(x)}Y{int(y)}D0{operation}*\n")


def _lattice(array: ApertureArray) -> tuple[int, int, int, int]:
    """Return columns, rows and their steps; 1, 1, 0, 0 for what no step-and-repeat can do."""
    place = array.place
    (ax, ay), (bx, by) = place.column_step, place.row_step
    oblique = (place.columns > 1 and ay) or (place.rows > 1 and bx)
    if place.offset is not None or oblique or place.count == 1:
        return 1, 1, 0, 0
    return place.columns, place.rows, ax if place.columns > 1 else 0, by if place.rows > 1 else 0


def _mm(value: int) -> str:
    """Return a length in mm, as many decimals as the grid has."""
    return f"{value * GRID:.6f}"
