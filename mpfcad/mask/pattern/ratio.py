"""The aperture ratio that every cell of a film needs, for some grooves at a time.

A cell is one groove wide and one period long. Curvature is bilinear between the nodes of a field;
its ratio is looked up in a table fine enough to be exact to 1e-7.
"""

from dataclasses import dataclass

import numba as nb
import numpy as np
from numpy.typing import NDArray

from mpfcad.film import FieldFilm, PanelFilm, Process
from mpfcad.film.field.field import bracket
from mpfcad.mask.aperture import blocks
from mpfcad.store.kernel import kept

#: Steps of the table from curvature 0 to that of an empty groove.
TABLE_STEPS = 1 << 14


@dataclass(frozen=True, eq=False)
class CellRatio:
    """Wanted aperture ratio of the cells of a film.

    Attributes
    ----------
    film
        the panel
    cell_count
        cells along each groove, which share its length evenly
    table
        (k,) float64, aperture ratio over curvature from 0 to `table_end`
    table_end
        curvature of an empty groove [1/mm]
    """

    film: FieldFilm
    cell_count: int
    table: NDArray[np.float64]
    table_end: float

    @classmethod
    def build(cls, film: PanelFilm, process: Process, cell_count: int) -> "CellRatio":
        """Return the ratios of `cell_count` cells along each groove of a film."""
        end = process.groove.curvature_empty
        curvature = np.linspace(0, end, TABLE_STEPS + 1)
        table = process.aperture_ratio_of_curvature(np.maximum(curvature, process.curvature_min))
        return cls(film.as_field(), cell_count, table, end)

    def rows(self, first: int, count: int) -> NDArray[np.float64]:
        """Return the ratio of the cells of `count` grooves from groove `first` on, (count, m)."""
        film, field = self.film, self.film.field
        centre = (np.arange(self.cell_count) + 0.5) * (film.length / self.cell_count)
        index, weight = bracket(field.along, centre)
        node = field.on_grooves(film.groove_position[first : first + count])
        out = np.empty((count, self.cell_count))
        _look_up(node, index, weight, self.table, TABLE_STEPS / self.table_end, out)
        return out

    def integral(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the ratio integrated along from 0 to each position [mm], (count, k)."""
        rows = self.rows(first, count)
        total = np.zeros((count, self.cell_count + 1))
        np.cumsum(rows, axis=1, out=total[:, 1:])
        cell = self.film.length / self.cell_count
        reach = np.clip(position / cell, 0, self.cell_count)
        low = np.minimum(reach.astype(np.int64), self.cell_count - 1)
        return (total[:, low] + (reach - low) * rows[:, low]) * cell

    def means(self) -> NDArray[np.float64]:
        """Return the mean ratio of each groove, (n,) float64."""
        return np.concatenate(
            [
                self.rows(first, count).mean(axis=1)
                for first, count in blocks(self.film.groove_count)
            ]
        )


@dataclass(frozen=True, eq=False)
class PieceRatio:
    """Wanted aperture ratio of pieces that are printed with one ratio, or not; lengths in mm.

    Attributes
    ----------
    printed
        (n, k) bool, which pieces of each groove are
    ratio
        of those
    piece, start, length
        of a piece; y at which the first begins; of the panel
    """

    printed: NDArray[np.bool_]
    ratio: float
    piece: float
    start: float
    length: float

    def integral(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the ratio integrated along from 0 to each position [mm], (count, k)."""
        rows = self.printed[first : first + count]
        pieces = rows.shape[1]
        total = np.zeros((count, pieces + 1))
        np.cumsum(rows, axis=1, out=total[:, 1:])
        reach = np.clip((position - self.start) / self.piece, 0, pieces)
        low = np.minimum(reach.astype(np.int64), pieces - 1)
        return (total[:, low] + (reach - low) * rows[:, low]) * (self.piece * self.ratio)

    def means(self) -> NDArray[np.float64]:
        """Return the mean ratio of each groove, (n,) float64."""
        return self.printed.sum(axis=1) * (self.piece * self.ratio / self.length)


@kept
@nb.njit(nogil=True)
def _look_up(node, index, weight, table, scale, out):
    last = len(table) - 2
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            low, high = node[i, index[j]], node[i, index[j] + 1]
            place = (low + weight[j] * (high - low)) * scale
            k = min(max(int(place), 0), last)
            out[i, j] = table[k] + (place - k) * (table[k + 1] - table[k])
