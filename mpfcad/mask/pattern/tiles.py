"""Masks made of tiles: one groove wide, some cells long, one tile for each level of the ratio.

* 1-D maps with blue noise: each groove has its own ratio, and one tile repeated along it;
* 2-D maps: the ratio, averaged over the tile's length, is rounded to one of 255 levels.

`mpfcad.mask.tile` draws them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.aperture import Mask, blocks
from mpfcad.mask.array import ApertureArray, Placement, Tile, TileArray
from mpfcad.mask.pattern.ratio import CellRatio, PieceRatio
from mpfcad.mask.rule import GRID

#: Ratios of a 2-D map are rounded to this many levels, besides 0.
LEVELS = 255


@dataclass(frozen=True, eq=False)
class LevelMask(Mask):
    """A mask of tiles.

    Attributes
    ----------
    ratio
        what each cell needs
    level
        (n, t) or (n, 1) int, level of each tile along each groove, or of all of them; 0 is closed
    phase
        (n,) int, which of a level's tiles each groove takes
    tiles
        the tile of each (phase, level) in use
    left
        (n,) int64, left edge of each groove [grid steps]
    bottom
        lower edge of the first tile [grid steps]
    tile_cells, tile_count, cell_steps
        cells in a tile, tiles along a groove, length of a cell [grid steps]
    """

    ratio: CellRatio | PieceRatio
    level: NDArray[np.integer]
    phase: NDArray[np.int64]
    tiles: dict[tuple[int, int], Tile]
    left: NDArray[np.int64]
    bottom: int
    tile_cells: int
    tile_count: int
    cell_steps: int

    @property
    def period(self) -> float:
        """Length of the cells along the grooves as made [mm]."""
        return self.cell_steps * GRID

    @property
    def smallest_features(self) -> tuple[float | None, float | None]:
        """Smallest aperture as drawn, None without any; the web that the rules leave [mm]."""
        sizes = [min(a.size) for t in self.tile_arrays for a in t.tile.arrays]
        return (min(sizes) * GRID if sizes else None), self.rules.web_limit

    @property
    def tile_steps(self) -> int:
        """Length of a tile [grid steps]."""
        return self.tile_cells * self.cell_steps

    @property
    def arrays(self) -> tuple[ApertureArray, ...]:
        """Nothing: all apertures are in tiles."""
        return ()

    @property
    def tile_arrays(self) -> Iterator[TileArray]:
        """The places of each tile, made as one goes; offsets are sorted across, then along."""
        if self.level.shape[1] == 1:
            yield from self._repeated()
            return
        levels = int(self.level.max()) + 1
        key = (self.phase[:, None] * levels + self.level).astype(np.uint16).ravel()
        order = np.argsort(key, kind="stable").astype(np.int32)
        start = np.concatenate([[0], np.cumsum(np.bincount(key))])
        for number in np.flatnonzero(np.diff(start)):
            phase, level = divmod(int(number), levels)
            if level == 0:
                continue
            groove, row = np.divmod(order[start[number] : start[number + 1]], self.tile_count)
            offset = np.stack([self.left[groove], row * np.int64(self.tile_steps)], axis=1)
            yield TileArray(self.tiles[phase, level], Placement((0, self.bottom), offset=offset))

    def _repeated(self) -> Iterator[TileArray]:
        for i in np.flatnonzero(self.level[:, 0]):
            place = Placement(
                (int(self.left[i]), self.bottom),
                rows=self.tile_count,
                row_step=(0, self.tile_steps),
            )
            yield TileArray(self.tiles[int(self.phase[i]), int(self.level[i, 0])], place)

    @cached_property
    def _tables(self) -> "_Tables":
        shape = (int(self.phase.max()) + 1, int(self.level.max()) + 1)
        return _Tables.build(self.tiles, shape, self.tile_cells, self.cell_steps)

    @property
    def _repeats(self) -> int:
        return self.tile_count // self.level.shape[1]

    def _tile_numbers(self, first: int, count: int) -> NDArray[np.int64]:
        """Return the number in the tables of each tile, (count, t) or (count, 1)."""
        part = slice(first, first + count)
        return self._tables.number[self.phase[part, None], self.level[part]]

    @property
    def aperture_count(self) -> int:
        """Number of apertures in all."""
        dots = self._tables.below[:, -1]
        counts = (dots[self._tile_numbers(*part)].sum() for part in blocks(self.groove_count))
        return int(sum(counts)) * self._repeats

    @property
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""
        area = self._tables.area
        sums = [area[self._tile_numbers(*p)].sum(axis=1) for p in blocks(self.groove_count)]
        return np.concatenate(sums) * self._repeats * GRID**2 / (self.pitch * self.length)

    @cached_property
    def wanted_ratio(self) -> NDArray[np.float64]:
        """Mean of the aperture ratio that each groove's cells need, (n,) float64."""
        return self.ratio.means()

    def open_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the ratio as drawn, integrated along from 0 to each position [mm]."""
        tables = self._tables
        reach = np.clip(position / GRID - self.bottom, 0, self.tile_count * self.tile_steps)
        tile = np.minimum((reach // self.tile_steps).astype(np.int64), self.tile_count - 1)
        inside = reach - tile * self.tile_steps
        cell = np.minimum((inside // self.cell_steps).astype(np.int64), self.tile_cells - 1)
        number = np.broadcast_to(self._tile_numbers(first, count), (count, self.tile_count))
        total = np.zeros((count, self.tile_count + 1))
        np.cumsum(tables.area[number], axis=1, out=total[:, 1:])
        here = number[:, tile]
        below, above = tables.below[here, cell], tables.below[here, cell + 1]
        along = tables.size[here, 1]
        rest = np.clip(inside - cell * self.cell_steps - tables.bottom[here], 0, along)
        part = (below * along + (above - below) * rest) * tables.size[here, 0]
        return (total[:, tile] + part) * (GRID**2 / self.pitch)

    def wanted_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the wanted ratio, integrated like `open_length`."""
        return self.ratio.integral(first, count, position)


@dataclass(frozen=True, eq=False)
class _Tables:
    """All tiles of a mask as arrays; tile 0 is the closed one.

    `number` (phases, levels) says which tile; `size` (k, 2), `bottom` (k,) and `area` (k,) are in
    grid steps; `below` (k, m+1) is how many apertures lie before each cell.
    """

    number: NDArray[np.int64]
    size: NDArray[np.int64]
    bottom: NDArray[np.int64]
    area: NDArray[np.float64]
    below: NDArray[np.int64]

    @classmethod
    def build(
        cls, tiles: dict[tuple[int, int], Tile], shape: tuple[int, int], cells: int, steps: int
    ) -> "_Tables":
        number = np.zeros(shape, dtype=np.int64)
        size = np.zeros((len(tiles) + 1, 2), dtype=np.int64)
        bottom, area = np.zeros(len(size), dtype=np.int64), np.zeros(len(size))
        below = np.zeros((len(size), cells + 1), dtype=np.int64)
        for i, (key, tile) in enumerate(tiles.items(), 1):
            (array,) = tile.arrays
            number[key], size[i], area[i] = i, array.size, tile.area
            bottom[i] = array.place.origin[1]
            below[i, 1 + (array.place.positions()[:, 1] // steps)] = 1
        return cls(number, size, bottom, area, np.cumsum(below, axis=1))


def quantise(ratio: CellRatio, tile_cells: int) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return the level of every tile, (n, t) uint8, and each level's ratio, the first 0.

    Levels stand evenly from the smallest to the largest ratio above 0.
    """
    n, tile_count = ratio.film.groove_count, ratio.cell_count // tile_cells
    mean = np.empty((n, tile_count), dtype=np.float32)
    for first, count in blocks(n):
        rows = ratio.rows(first, count).reshape(count, tile_count, tile_cells)
        mean[first : first + count] = rows.mean(axis=2)
    is_open = mean > 0
    low, high = mean[is_open].min(initial=1), mean.max()
    step = max((high - low) / (LEVELS - 1), 1e-9)
    level = np.zeros(mean.shape, dtype=np.uint8)
    for first, count in blocks(n):
        part = slice(first, first + count)
        level[part] = np.where(is_open[part], np.rint((mean[part] - low) / step) + 1, 0)
    return level, np.append(0.0, low + np.arange(LEVELS) * float(step))
