"""The points of a piece's height map."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.file.height import HeightGrid, build_height_grid
from mpfcad.film import CellFilm, FieldPiece, PrismFilm
from mpfcad.job import CadTable
from mpfcad.pipeline.plan.made import Drawn
from mpfcad.units import um

#: Formats of `cad.height`.
HEIGHT_FORMATS = ("tif", "dat")
#: Points over a groove or a cell, and the points' distance along grooves, unless the job says.
POINTS_PER_PITCH, DISTANCE_ALONG = 20, 50 * um


def build_grid(film: Drawn, table: CadTable) -> HeightGrid:
    """Return where the heights of a piece are taken."""
    if isinstance(film, CellFilm | FieldPiece):
        size, height = film.size, film.height
    else:
        assert isinstance(film, PrismFilm)  # others are refused by their formats
        size, height = (film.width, film.length), _extruded(film)
    across = table.inside("sample_across_um") or film.groove.pitch / POINTS_PER_PITCH
    along = table.inside("sample_along_um")
    if along is None:
        along = across if isinstance(film, CellFilm) else DISTANCE_ALONG
    return build_height_grid(size, (across, along), height)


def _extruded(film: PrismFilm):
    """Return the height [mm] of a film of one curvature a groove over (x, y) [mm]."""

    def height(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return film.height(x) + 0 * y

    return height
