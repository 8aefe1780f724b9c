"""The tiles of a mask: m cells of one groove, their apertures all alike.

With ratio a, k of m cells open and cell area A, an aperture has the area a · A · m/k, so that the
tile's ratio is a whatever k is. Slots and dots are in every cell, k = m; of blue noise k is the
least for which the dot is not above its nominal side.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.array import ApertureArray, Placement, Tile
from mpfcad.mask.noise import rank_columns


@dataclass(frozen=True)
class TileShape:
    """What all tiles of a mask have in common; grid steps.

    Attributes
    ----------
    cells
        in a tile, m
    cell_steps
        length of a cell on the grid
    width
        of a groove on the grid, of each phase
    pitch, period
        of grooves and cells before they are rounded to the grid
    dot
        largest side of a blue-noise dot; None when every cell has an aperture
    is_slot
        whether apertures are as wide as the groove; else they are square
    """

    cells: int
    cell_steps: int
    width: tuple[int, ...]
    pitch: float
    period: float
    dot: float | None
    is_slot: bool

    @cached_property
    def order(self) -> NDArray[np.int64]:
        """Order in which the cells of each phase get their dots, (phases, m)."""
        return rank_columns(len(self.width), self.cells)

    def open_cells(self, phase: int, ratio: float) -> NDArray[np.int64]:
        """Return which cells have an aperture, (k,) int64."""
        if self.dot is None:
            return np.arange(self.cells)
        area = ratio * self.pitch * self.period * self.cells
        number = max(1, min(self.cells, int(np.ceil(area / self.dot**2 - 1e-9))))
        return np.sort(self.order[phase, :number])

    def aperture(self, phase: int, ratio: float) -> tuple[int, int]:
        """Return width and length of the apertures; 0 for none."""
        length = ratio * self.period * self.cells / len(self.open_cells(phase, ratio))
        if self.is_slot:
            return self.width[phase], round(length)
        side = round(np.sqrt(length * self.pitch))
        return side, side

    def draw(self, phase: int, level: int, ratio: float) -> Tile:
        """Return the tile of a level with the given ratio."""
        cell = self.open_cells(phase, ratio)
        across, along = self.aperture(phase, ratio)
        left, bottom = (self.width[phase] - across) // 2, (self.cell_steps - along) // 2
        if self.dot is None:
            place = Placement((left, bottom), rows=self.cells, row_step=(0, self.cell_steps))
        else:
            offset = np.stack([np.zeros_like(cell), cell * self.cell_steps], axis=1)
            place = Placement((left, bottom), offset=offset)
        size = (self.width[phase], self.cells * self.cell_steps)
        return Tile(f"P{phase}L{level}", size, (ApertureArray((across, along), place),))


def draw_tiles(
    shape: TileShape, keys: Iterable[tuple[int, int]], level_ratio: NDArray[np.float64]
) -> dict[tuple[int, int], Tile]:
    """Return the tile of every (phase, level) that has an aperture."""
    return {
        (phase, level): shape.draw(phase, level, float(level_ratio[level]))
        for phase, level in sorted(keys)
        if min(shape.aperture(phase, float(level_ratio[level]))) > 0
    }
