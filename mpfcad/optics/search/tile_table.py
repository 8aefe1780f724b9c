"""Any number of film tiles as one set of flat arrays, so that kernels are compiled once for all.

The arrays of each accelerator lie one after another, with the place of each tile's part; a kernel
takes a tile out as views of them.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes_array import aligned
from mpfcad.optics.search.bvh.tree import Bvh
from mpfcad.optics.search.chain import Chain
from mpfcad.optics.search.grid.cells import Grid
from mpfcad.optics.search.grid.section import Section
from mpfcad.optics.search.layers import Layers
from mpfcad.optics.search.tile import NO_TILE, Tile


class TileTable(NamedTuple):
    """Tiles, one after another.

    Attributes
    ----------
    size
        (t, 5) float64 [mm], width, length, low and high of each, and whether it has an underside
    accelerator
        (t,) int64, of each
    chain, bvh, section, grid, layers
        their accelerators' arrays, joined
    chain_at, bvh_at, section_at, grid_at, layers_at
        (t+1, fields) int64, where the part of each tile begins in each of those arrays
    """

    size: NDArray[np.float64]
    accelerator: NDArray[np.int64]
    chain: Chain
    bvh: Bvh
    section: Section
    grid: Grid
    layers: Layers
    chain_at: NDArray[np.int64]
    bvh_at: NDArray[np.int64]
    section_at: NDArray[np.int64]
    grid_at: NDArray[np.int64]
    layers_at: NDArray[np.int64]


def build_tile_table(tiles: Sequence[Tile]) -> TileTable:
    """Return the table of some tiles; of none, one that is never looked at."""
    tiles = tiles or [NO_TILE]
    size = np.array([(t.width, t.length, t.low, t.high, t.underside) for t in tiles], float)
    accelerator = np.array([t.accelerator for t in tiles], np.int64)
    chain, chain_at = _joined([t.chain for t in tiles])
    bvh, bvh_at = _joined([t.bvh for t in tiles])
    section, section_at = _joined([t.section for t in tiles])
    grid, grid_at = _joined([t.grid for t in tiles])
    layers, layers_at = _joined([t.layers for t in tiles])
    at = chain_at, bvh_at, section_at, grid_at, layers_at
    return TileTable(size, accelerator, chain, bvh, section, grid, layers, *at)


def _joined(parts: Sequence[Any]) -> tuple[Any, NDArray[np.int64]]:
    """Return accelerators of one kind with their arrays joined, and where each part begins."""
    counts = np.array([[len(array) for array in part] for part in parts])
    at = np.concatenate([np.zeros((1, counts.shape[1]), np.int64), np.cumsum(counts, axis=0)])
    arrays = []
    for same in zip(*parts, strict=True):
        joined = aligned((sum(map(len, same)), *same[0].shape[1:]), same[0].dtype)
        arrays.append(np.concatenate(same, out=joined))
    return type(parts[0])(*arrays), at


@kernel
def tile_of(table, t):
    """Return tile number `t` of a table, its arrays as views."""
    c, d = table.chain_at[t], table.chain_at[t + 1]
    chain = Chain(
        table.chain.segment[c[0] : d[0]],
        table.chain.run[c[1] : d[1]],
        table.chain.range[c[2] : d[2]],
        table.chain.cell[c[3] : d[3]],
        table.chain.run_of[c[4] : d[4]],
    )
    c, d = table.bvh_at[t], table.bvh_at[t + 1]
    bvh = Bvh(
        table.bvh.box[c[0] : d[0]],
        table.bvh.child[c[1] : d[1]],
        table.bvh.corner[c[2] : d[2]],
        table.bvh.facet[c[3] : d[3]],
        table.bvh.normal[c[4] : d[4]],
    )
    c, d = table.section_at[t], table.section_at[t + 1]
    section = Section(
        table.section.cell[c[0] : d[0]],
        table.section.line[c[1] : d[1]],
        table.section.facing[c[2] : d[2]],
        table.section.shape[c[3] : d[3]],
    )
    c, d = table.grid_at[t], table.grid_at[t + 1]
    grid = Grid(
        table.grid.count[c[0] : d[0]],
        table.grid.cell[c[1] : d[1]],
        table.grid.corner[c[2] : d[2]],
        table.grid.facet[c[3] : d[3]],
    )
    c, d = table.layers_at[t], table.layers_at[t + 1]
    layers = Layers(
        table.layers.segment[c[0] : d[0]],
        table.layers.part[c[1] : d[1]],
        table.layers.range[c[2] : d[2]],
        table.layers.aside[c[3] : d[3]],
        table.layers.cell[c[4] : d[4]],
        table.layers.strip[c[5] : d[5]],
        table.layers.lean[c[6] : d[6]],
    )
    size, accelerator = table.size[t], table.accelerator[t]
    underside = size[4] != 0.0
    return Tile(
        size[0], size[1], size[2], size[3], underside, accelerator, chain, bvh, section, grid,
        layers,
    )  # fmt: skip
