"""Extruded films as a chain of segments in the cross-section: a ray walks from segment to segment.

Where the top is a polyline z(x) drawn along y, the next hit lies on the segment's neighbours, so no
tree is searched. Whether the ray passes above or below a vertex is decided once a vertex, by the
same expression for both segments that meet there: a ray cannot slip between them, and no offset is
needed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.kernel import kernel
from mpfcad.optics.mesh import FilmMesh


class Chain(NamedTuple):
    """The cross-section of an extruded film tile.

    Attributes
    ----------
    x, z
        (s+1,) float64 [mm], vertices from x = 0 to the tile's width, x ascending
    normal_x, normal_z
        (s,) float64, unit normals of the segments, upward
    first
        (c,) int64, the segment at the left edge of each of c equal cells of the width
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    normal_x: NDArray[np.float64]
    normal_z: NDArray[np.float64]
    first: NDArray[np.int64]


def build_chain(mesh: FilmMesh) -> Chain | None:
    """Return the chain of a film mesh, or None where it is not one drawn along y."""
    vertex = mesh.vertex[np.unique(mesh.top)]
    length = mesh.size[1]
    if not np.isin(vertex[:, 1], (0.0, length)).all():
        return None
    ends = [vertex[vertex[:, 1] == y][:, (0, 2)] for y in (0.0, length)]
    ends = [end[np.argsort(end[:, 0], kind="stable")] for end in ends]
    if ends[0].shape != ends[1].shape or (ends[0] != ends[1]).any():
        return None
    x, z = ends[0].T.copy()
    if (np.diff(x) <= 0).any() or not _facets_span_one_segment(mesh, x):
        return None
    dx, dz = np.diff(x), np.diff(z)
    norm = np.hypot(dx, dz)
    cells = np.arange(4 * len(dx)) * (mesh.size[0] / (4 * len(dx)))
    first = np.clip(np.searchsorted(x, cells, side="right") - 1, 0, len(dx) - 1)
    return Chain(x, z, -dz / norm, dx / norm, first.astype(np.int64))


def _facets_span_one_segment(mesh: FilmMesh, x: NDArray[np.float64]) -> bool:
    """Return whether each top facet lies between two neighbouring vertices of the cross-section."""
    place = np.searchsorted(x, mesh.vertex[mesh.top][..., 0])
    return bool((place.max(axis=1) - place.min(axis=1) == 1).all())


@kernel
def _segment_at(chain, width, x):
    """Return the segment over x in [0, width)."""
    cell = min(len(chain.first) - 1, max(0, int(x / width * len(chain.first))))
    k = chain.first[cell]
    while k > 0 and x < chain.x[k]:
        k -= 1
    while k < len(chain.normal_x) - 1 and x >= chain.x[k + 1]:
        k += 1
    return k


@kernel
def chain_hit(chain, width, low, high, x, z, dx, dz, k, inside):
    """Return the next segment that a ray meets: (segment or -1, distance, x, z, shift).

    The ray starts at (x, z) [mm], inside or outside the film, with x in [0, width]; `k` is the
    segment it starts on, or -1 when it starts below the lowest (inside) or above the highest point
    (outside); low, high: lowest and highest z of the top. `shift` [mm] is what to add to x to be in
    the same coordinates as before; segment -1: it leaves the zone of the top without a hit.
    """
    shift = 0.0
    count = len(chain.normal_x)
    side = 1.0 if inside else -1.0
    right = dx > 0.0
    sign = 1.0 if right else -1.0
    speed = abs(dx)
    level = low if inside else high
    if k < 0:
        # Free flight up to the zone, then the segment found there is tested first.
        start = max(0.0, (level - z) / dz)
        entry = x + start * dx
        turns = math.floor(entry / width)
        shift = turns * width
        x -= shift
        entry = min(max(entry - shift, 0.0), width)
        k = _segment_at(chain, width, entry)
        if speed == 0.0:
            return _meet(chain, k, x, z, dx, dz, shift)
    elif speed == 0.0:
        return -1, 0.0, x, z, shift
    else:
        k, x, shift = _neighbour(k, right, count, width, x, shift)
    for _ in range(64 * count + 64):
        v = k + 1 if right else k
        ahead = (chain.x[v] - x) * sign
        rise = (chain.z[v] - z) * speed
        if (rise - ahead * dz) * side <= 0.0:
            return _meet(chain, k, x, z, dx, dz, shift)
        # Past the vertex: out of the zone already?
        if inside:
            if dz < 0.0 and ahead * dz < (low - z) * speed:
                return -1, 0.0, x, z, shift
        elif dz > 0.0 and ahead * dz > (high - z) * speed:
            return -1, 0.0, x, z, shift
        k, x, shift = _neighbour(k, right, count, width, x, shift)
    return -2, 0.0, x, z, shift


@kernel
def _neighbour(k, right, count, width, x, shift):
    """Return the next segment, with the ray's origin moved to the tile it lies in."""
    if right:
        if k == count - 1:
            return 0, x - width, shift + width
        return k + 1, x, shift
    if k == 0:
        return count - 1, x + width, shift - width
    return k - 1, x, shift


@kernel
def _meet(chain, k, x, z, dx, dz, shift):
    """Return the hit on segment k, its point put onto the segment."""
    nx, nz = chain.normal_x[k], chain.normal_z[k]
    x0, z0 = chain.x[k], chain.z[k]
    x1, z1 = chain.x[k + 1], chain.z[k + 1]
    approach = dx * nx + dz * nz
    distance = 0.0
    if approach != 0.0:
        distance = max(0.0, ((x0 - x) * nx + (z0 - z) * nz) / approach)
    hit_x = min(max(x + distance * dx, x0), x1)
    hit_z = z0 + (z1 - z0) * ((hit_x - x0) / (x1 - x0))
    return k, distance, hit_x, hit_z, shift
