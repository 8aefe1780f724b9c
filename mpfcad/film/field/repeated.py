"""A map C(x, y) over one cell of LEDs, repeated over the panel: held once, however large that is.

Each groove of the cell has its curvatures at the middles of its pieces; between them C is linear
along the groove. On the panel the grooves of the cell are counted from a groove near an LED, so
that the panel's grooves are those of the cell bit for bit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.film.field.field import bracket
from mpfcad.sound import refuse_unsound


@dataclass(frozen=True, eq=False)
class CurvatureCell:
    """C over one cell at nodes, bilinear between them and across the cell's ends.

    Attributes
    ----------
    across, along
        (n,), (m,) float64, nodes in periods from the LED, increasing, 0…1
    curvature
        (m, n) float64 [1/mm], C through the tips
    """

    across: NDArray[np.float64]
    along: NDArray[np.float64]
    curvature: NDArray[np.float64]

    def at(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return C [1/mm] at all of u by all of v in periods, (n, m)."""
        rows = np.array([np.interp(u, self.across, row, period=1.0) for row in self.curvature])
        found = [np.interp(v, self.along, column, period=1.0) for column in rows.T]
        return np.array(found, np.float64)


@dataclass(frozen=True, eq=False)
class RepeatedField:
    """C over the panel, from its lower left corner, of one cell again and again.

    Attributes
    ----------
    cell
        (n, m) float64 [1/mm], C through the tips of each groove at the middle of each piece
    pitch, piece
        of the grooves, and of the pieces along them [mm]
    first
        groove of the panel that is the cell's first
    start
        y [mm] on the panel at which a cell begins
    groove_count, length
        grooves of the panel; its extent along them [mm]

    Examples
    --------
    >>> field = RepeatedField(np.array([[60.0, 62.0]]), 0.05, 0.5, 0, 0.0, 4, 2.0)
    >>> field.on_grooves([0.125])[0, :3]
    array([62., 60., 62.])
    """

    cell: NDArray[np.float64]
    pitch: float
    piece: float
    first: int
    start: float
    groove_count: int
    length: float

    def __post_init__(self) -> None:
        cell = np.array(self.cell, dtype=np.float64)
        cell.flags.writeable = False
        object.__setattr__(self, "cell", cell)
        refuse_unsound("field.curvature", cell, 0.0)

    @property
    def _pieces(self) -> NDArray[np.int64]:
        """Number of each piece along the panel from that at `start`, one over either end."""
        low = int(np.floor(-self.start / self.piece - 0.5))
        high = int(np.ceil((self.length - self.start) / self.piece - 0.5))
        return np.arange(low, high + 1)

    @property
    def across(self) -> NDArray[np.float64]:
        """Centres of the panel's grooves, (n,) float64 [mm]."""
        return np.arange(0.5, self.groove_count) * self.pitch

    @property
    def along(self) -> NDArray[np.float64]:
        """Middles of the pieces along the panel, (k,) float64 [mm], over both ends."""
        return np.asarray(self.start + (self._pieces + 0.5) * self.piece, np.float64)

    @property
    def curvature(self) -> NDArray[np.float64]:
        """Every curvature [1/mm] that there is: those of the cell, (m, n) float64."""
        return self.cell.T

    @property
    def content(self) -> tuple[NDArray[np.float64], ...]:
        """The positions on the panel [mm], and the cell's curvatures [1/mm]."""
        return self.across, self.along, self.curvature

    @property
    def stored(self) -> tuple[NDArray[np.float64], ...]:
        """What its file holds: the cell, positions [mm] from its LED."""
        n, m = self.cell.shape
        across, along = np.arange(0.5, n) * self.pitch, np.arange(0.5, m) * self.piece
        return across, along, self.curvature

    def on_grooves(self, position: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at the nodes along of grooves at `position` mm, (n, k)."""
        groove = np.floor(np.asarray(position, float) / self.pitch + 1e-9).astype(np.int64)
        row = self.cell[np.mod(groove - self.first, len(self.cell))]
        return np.ascontiguousarray(row[:, np.mod(self._pieces, self.cell.shape[1])])

    def extremes(self, position: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
        """Return the smallest and largest curvature [1/mm] of grooves at `position` mm, (n,)."""
        groove = np.floor(position / self.pitch + 1e-9).astype(np.int64)
        number = np.mod(groove - self.first, len(self.cell))
        return self.cell.min(axis=1)[number], self.cell.max(axis=1)[number]

    def at(self, across: ArrayLike, along: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at points [mm]; across, that of the groove."""
        x, y = np.broadcast_arrays(np.asarray(across, float), np.asarray(along, float))
        groove = np.floor(x / self.pitch + 1e-9).astype(np.int64)
        row = np.mod(groove - self.first, len(self.cell))
        index, weight = bracket(self.along, y)
        pieces, m = self._pieces, self.cell.shape[1]
        low = self.cell[row, np.mod(pieces[index], m)]
        high = self.cell[row, np.mod(pieces[index + 1], m)]
        return low + weight * (high - low)
