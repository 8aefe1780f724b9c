"""A film tile as the kernels see it, and the next facet that a ray in it meets.

The accelerator is chosen from the mesh alone: `chain` where it is drawn along y, else `grid` where
its facets are small and even against the base (`grid_build`), else `bvh`.
"""

from typing import NamedTuple

import numpy as np

from mpfcad.errors import TraceError
from mpfcad.optics.bvh import Bvh, build_bvh, bvh_hit
from mpfcad.optics.chain import Chain, build_chain, chain_hit, chain_of
from mpfcad.optics.grid import Grid, grid_hit
from mpfcad.optics.grid_build import build_grid
from mpfcad.optics.kernel import kernel
from mpfcad.optics.mesh import FilmMesh

CHAIN, BVH, GRID = range(3)
ACCELERATORS = ("chain", "bvh", "grid")


class Tile(NamedTuple):
    """A film tile: its size, the z range of its top, and its accelerators, one of them filled."""

    width: float
    length: float
    low: float
    high: float
    accelerator: int
    chain: Chain
    bvh: Bvh
    grid: Grid


_NO_CHAIN = chain_of(np.array([0.0, 1.0]), np.zeros(2))
_NO_BVH = Bvh(
    np.zeros((6, 8)),
    np.zeros((1, 8), np.int64),
    np.zeros((9, 8)),
    np.zeros((1, 8), np.int64),
    np.zeros((1, 3)),
)
_NO_GRID = Grid(np.ones(2, np.int64), np.zeros((1, 4)), np.zeros((3, 4)), np.zeros(1, np.int64))
#: What a scene without film holds.
NO_TILE = Tile(1.0, 1.0, 0.0, 1.0, CHAIN, _NO_CHAIN, _NO_BVH, _NO_GRID)


def build_tile(mesh: FilmMesh, accelerator: str | None = None) -> Tile:
    """Return the tile of a mesh with the accelerator asked for, or the one that the mesh allows.

    Raises
    ------
    TraceError
        when the accelerator asked for does not fit the mesh.
    """
    z = mesh.vertex[np.unique(mesh.top), 2]
    size = (*mesh.size[:2], float(z.min()), float(z.max()))
    if accelerator in (None, "chain"):
        chain = build_chain(mesh)
        if chain is not None:
            return Tile(*size, CHAIN, chain, _NO_BVH, _NO_GRID)
        if accelerator == "chain":
            raise TraceError("accelerator chain: the mesh is not extruded along y")
    if accelerator in (None, "grid"):
        grid = build_grid(mesh)
        if grid is not None:
            return Tile(*size, GRID, _NO_CHAIN, _NO_BVH, grid)
        if accelerator == "grid":
            raise TraceError("accelerator grid: the mesh's facets are too uneven in size")
    return Tile(*size, BVH, _NO_CHAIN, build_bvh(mesh), _NO_GRID)


@kernel
def next_facet(tile, x, y, z, dx, dy, dz, k, inside):
    """Return the next facet that a ray in a tile meets: (facet, x, y, z, nx, ny, nz, shifts x, y).

    The ray starts at (x, y, z) [mm] in the tile, on facet `k` or (-1) on none, in air over the top
    or (inside) in the film. Facet -1: it leaves the zone of the top without meeting one; -2: it was
    lost (a hole). n: outward unit normal; shifts [mm] lead back to the coordinates before.
    """
    if tile.accelerator == CHAIN:
        # A chain repeats along y without end, so y needs no tile of its own.
        k, distance, hit_x, hit_z, shift, nx, nz = chain_hit(
            tile.chain, tile.width, tile.low, tile.high, x, z, dx, dz, k, inside, True
        )
        if k < 0:
            return k, hit_x, y, hit_z, 0.0, 0.0, 1.0, shift, 0.0
        return k, hit_x, y + distance * dy, hit_z, nx, 0.0, nz, shift, 0.0
    if tile.accelerator == GRID:
        k, x, y, z, shift, shift_y, nx, ny, nz = grid_hit(
            tile.grid, (tile.width, tile.length), tile.low, tile.high, x, y, z, dx, dy, dz, inside
        )  # fmt: skip
        return k, x, y, z, nx, ny, nz, shift, shift_y
    k, x, y, z, shift, shift_y = bvh_hit(
        tile.bvh, (tile.width, tile.length), tile.low, tile.high, x, y, z, dx, dy, dz, inside
    )
    if k < 0:
        return k, x, y, z, 0.0, 0.0, 1.0, shift, shift_y
    normal = tile.bvh.normal
    return k, x, y, z, normal[k, 0], normal[k, 1], normal[k, 2], shift, shift_y
