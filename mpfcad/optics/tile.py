"""A film tile as the kernels see it, and the next facet that a ray in it meets.

The accelerator is chosen from the mesh alone: `chain` where it is drawn along y, else `bvh`.
"""

from typing import NamedTuple

import numpy as np

from mpfcad.errors import TraceError
from mpfcad.optics.bvh import Bvh, build_bvh, bvh_hit
from mpfcad.optics.chain import Chain, build_chain, chain_of
from mpfcad.optics.chain_walk import chain_hit
from mpfcad.optics.kernel import kernel
from mpfcad.optics.mesh import FilmMesh

CHAIN, BVH = range(2)
ACCELERATORS = ("chain", "bvh")


class Tile(NamedTuple):
    """A film tile: its size, the z range of its top, and its accelerators, one of them filled."""

    width: float
    length: float
    low: float
    high: float
    accelerator: int
    chain: Chain
    bvh: Bvh


_NO_CHAIN = chain_of(np.array([0.0, 1.0]), np.zeros(2))
_NO_BVH = Bvh(
    np.zeros((6, 8)),
    np.zeros((1, 8), np.int64),
    np.zeros((9, 8)),
    np.zeros((1, 8), np.int64),
    np.zeros((1, 3)),
)
#: What a scene without film holds.
NO_TILE = Tile(1.0, 1.0, 0.0, 1.0, CHAIN, _NO_CHAIN, _NO_BVH)


def build_tile(mesh: FilmMesh, accelerator: str | None = None) -> Tile:
    """Return the tile of a mesh with the accelerator asked for, or the one that the mesh allows.

    Raises
    ------
    TraceError
        when the accelerator asked for does not fit the mesh.
    """
    z = mesh.vertex[np.unique(mesh.top), 2]
    chain = build_chain(mesh) if accelerator in (None, "chain") else None
    if chain is None and accelerator == "chain":
        raise TraceError("accelerator chain: the mesh is not extruded along y")
    bvh = build_bvh(mesh) if chain is None else _NO_BVH
    width, length, _ = mesh.size
    number = BVH if chain is None else CHAIN
    return Tile(width, length, float(z.min()), float(z.max()), number, chain or _NO_CHAIN, bvh)


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
            tile.chain, tile.width, tile.low, tile.high, x, z, dx, dz, k, inside
        )
        if k < 0:
            return k, hit_x, y, hit_z, 0.0, 0.0, 1.0, shift, 0.0
        return k, hit_x, y + distance * dy, hit_z, nx, 0.0, nz, shift, 0.0
    k, x, y, z, shift, shift_y = bvh_hit(
        tile.bvh, (tile.width, tile.length), tile.low, tile.high, x, y, z, dx, dy, dz, inside
    )
    if k < 0:
        return k, x, y, z, 0.0, 0.0, 1.0, shift, shift_y
    normal = tile.bvh.normal
    return k, x, y, z, normal[k, 0], normal[k, 1], normal[k, 2], shift, shift_y
