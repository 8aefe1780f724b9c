"""A film tile as the kernels see it, and the next facet that a ray in it meets.

The accelerator is chosen from the mesh alone: where it is drawn along y, `chain` for one height
over a flat underside and `section` for any other cross-section; else `grid` where its facets are
small and even against the base (`grid.build`), else `bvh`.
"""

from typing import Any, NamedTuple

import numpy as np

from mpfcad.errors import TraceError
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.search.bvh.build import build_bvh
from mpfcad.optics.search.bvh.tree import Bvh, bvh_hit
from mpfcad.optics.search.chain import Chain, build_chain, chain_of
from mpfcad.optics.search.chain_walk import chain_hit
from mpfcad.optics.search.grid.build import build_grid
from mpfcad.optics.search.grid.cells import Grid, grid_hit
from mpfcad.optics.search.grid.section import (
    Section,
    drawn_segments,
    section_of,
)
from mpfcad.optics.search.grid.section_walk import section_hit
from mpfcad.optics.search.layers import NO_LAYERS, Layers
from mpfcad.optics.search.layers_build import layers_of
from mpfcad.optics.solid.mesh import FilmMesh

CHAIN, BVH, SECTION, GRID = range(4)
ACCELERATORS = ("chain", "bvh", "section", "grid")


class Tile(NamedTuple):
    """A film tile: its size, the z range of its facets, and its accelerators, one of them filled.

    `underside`: a flat one at z = 0, not among the facets, closes it; else light may come and leave
    there through air.
    """

    width: float
    length: float
    low: float
    high: float
    underside: bool
    accelerator: int
    chain: Chain
    bvh: Bvh
    section: Section
    grid: Grid
    layers: Layers


def _build_section(mesh: FilmMesh) -> tuple[Section, Layers] | None:
    """Return the section and its layers, or None where the mesh is not one drawn along y."""
    segment = drawn_segments(mesh)
    if segment is None:
        return None
    width = mesh.size[0]
    return section_of(segment, width), layers_of(segment, width, mesh.underside)


#: How each is built, in the order in which they are tried.
_BUILD = (
    ("chain", build_chain), ("section", _build_section), ("grid", build_grid), ("bvh", build_bvh),
)  # fmt: skip
_UNFIT = {
    "chain": "not extruded along y",
    "section": "not extruded along y",
    "grid": "too uneven in its facets' sizes",
}

_NO_CHAIN = chain_of(np.array([0.0, 1.0]), np.zeros(2))
_NO_BVH = Bvh(
    np.zeros((6, 8), np.float32),
    np.zeros((1, 8), np.int32),
    np.zeros((9, 8)),
    np.zeros((1, 8), np.int32),
    np.zeros((1, 3)),
)
_NO_SECTION = section_of(np.array([[0.0, 0.0, 1.0, 0.0]]), 1.0)
_NO_GRID = Grid(np.ones(2, np.int64), np.zeros((1, 4)), np.zeros((3, 4)), np.zeros(1, np.int64))
#: What a scene without film holds.
NO_TILE = Tile(
    1.0, 1.0, 0.0, 1.0, True, CHAIN, _NO_CHAIN, _NO_BVH, _NO_SECTION, _NO_GRID, NO_LAYERS
)


def build_tile(mesh: FilmMesh, accelerator: str | None = None) -> Tile:
    """Return the tile of a mesh with the accelerator asked for, or the one that the mesh allows.

    Raises
    ------
    TraceError
        when the accelerator asked for does not fit the mesh.
    """
    z = mesh.vertex[mesh.used, 2]
    made: dict[str, Any] = dict.fromkeys(ACCELERATORS)
    for name, build in _BUILD:
        if accelerator in (None, name):
            made[name] = build(mesh)
        if made[name] is not None:
            break
    else:
        raise TraceError(f"accelerator {accelerator}: the mesh is {_UNFIT[accelerator or name]}")
    width, length, _ = mesh.size
    section, layers = made["section"] or (_NO_SECTION, NO_LAYERS)
    return Tile(
        width, length, float(z.min()), float(z.max()), mesh.underside, ACCELERATORS.index(name),
        made["chain"] or _NO_CHAIN, made["bvh"] or _NO_BVH, section,
        made["grid"] or _NO_GRID, layers,
    )  # fmt: skip


@kernel
def next_facet(tile, x, y, z, dx, dy, dz, k, inside):
    """Return the next facet that a ray in a tile meets: (facet, x, y, z, nx, ny, nz, shifts x, y).

    The ray starts at (x, y, z) [mm] in the tile, on facet `k` or (-1) on none, in air or (inside)
    in the film. Facet -1: it leaves the heights of the facets without meeting one; -2: it was lost
    (a hole). n: outward unit normal; shifts [mm] lead back to the coordinates before.
    """
    if tile.accelerator == CHAIN:
        # A chain repeats along y without end, so y needs no tile of its own.
        k, distance, hit_x, hit_z, shift, nx, nz = chain_hit(
            tile.chain, tile.width, tile.low, tile.high, x, z, dx, dz, k, inside
        )
        if k < 0:
            return k, hit_x, y, hit_z, 0.0, 0.0, 1.0, shift, 0.0
        return k, hit_x, y + distance * dy, hit_z, nx, 0.0, nz, shift, 0.0
    if tile.accelerator == GRID:
        k, x, y, z, shift, shift_y, nx, ny, nz = grid_hit(
            tile.grid, (tile.width, tile.length), tile.low, tile.high, x, y, z, dx, dy, dz, inside
        )  # fmt: skip
        return k, x, y, z, nx, ny, nz, shift, shift_y
    if tile.accelerator == SECTION:
        k, distance, x, z, shift = section_hit(
            tile.section, tile.width, tile.low, tile.high, tile.underside, x, z, dx, dz, inside
        )
        y += distance * dy
        if k < 0:
            return k, x, y, z, 0.0, 0.0, 1.0, shift, 0.0
        facing = tile.section.facing[k]
        return k, x, y, z, facing[0], 0.0, facing[1], shift, 0.0
    # From inside there is only the flat underside to reach without a facet, and from it no air.
    astray = inside if dz > 0.0 or not tile.underside else not inside
    k, x, y, z, shift, shift_y = bvh_hit(
        tile.bvh, (tile.width, tile.length), tile.low, tile.high, x, y, z, dx, dy, dz, inside
    )
    if k < 0:
        return (-2 if astray else k), x, y, z, 0.0, 0.0, 1.0, shift, shift_y
    normal = tile.bvh.normal
    return k, x, y, z, normal[k, 0], normal[k, 1], normal[k, 2], shift, shift_y
