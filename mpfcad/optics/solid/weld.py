"""Corners of facets made vertices: equal ones are one, and where asked nearly equal ones too."""

import numpy as np
from numpy.typing import NDArray

Welded = tuple[NDArray[np.float64], NDArray[np.int64]]

#: Grid [mm] that coordinates of doubles are rounded to, so that sides meet: a picometre.
_GRID = 2.0**-30


def weld(corner: NDArray[np.float32]) -> Welded:
    """Return vertices (v, 3) float64 and facets (n, 3) int64 of float32 corners (n, 3, 3).

    Facets with two equal corners bound nothing and are left out: their neighbours join.
    """
    points = corner.reshape(-1, 3) + np.float32(0)  # -0 becomes 0
    # Two coordinates a whole number: sorted several times faster than records.
    bits = points.view(np.uint32)
    number = _numbered(_numbered(bits[:, 0], bits[:, 1]), bits[:, 2])
    return _without_collapsed(points, number)


def weld_doubles(corner: NDArray[np.float64]) -> Welded:
    """Return vertices and facets of float64 corners (n, 3, 3), rounded to 1e-9 mm."""
    points = np.round(corner.reshape(-1, 3) / _GRID) * _GRID + 0.0
    number = np.zeros(len(points), np.int64)
    for axis in range(3):
        rank = np.unique(points[:, axis], return_inverse=True)[1]
        pair = number * (int(rank.max()) + 1) + rank
        number = np.unique(pair, return_inverse=True)[1]
    return _without_collapsed(points, number)


def _without_collapsed(points: NDArray, number: NDArray[np.int64]) -> Welded:
    vertex = np.empty((number.max() + 1, 3))
    vertex[number] = points
    facet = number.reshape(-1, 3)
    collapsed = (facet == np.roll(facet, 1, axis=1)).any(axis=1)
    return vertex, facet[~collapsed]


def _numbered(high: NDArray[np.integer], low: NDArray[np.uint32]) -> NDArray[np.int64]:
    """Return the rank of each pair, (n,), in the order of `high`, then of `low`."""
    key = high.astype(np.uint64)
    key <<= np.uint64(32)
    key |= low
    order = np.argsort(key)
    key = key[order]
    rank = np.empty(len(key), np.int64)
    rank[order] = np.r_[0, np.cumsum(key[1:] != key[:-1])]
    return rank


def open_corners(facet: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return the vertices on edges that are not shared by two facets, once in each direction."""
    start, end = facet.ravel(), np.roll(facet, -1, axis=1).ravel()
    forward, backward = start * count + end, end * count + start
    lone = ~np.isin(forward, backward)
    return np.unique(np.concatenate([start[lone], end[lone]]))


def join_last_steps(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> tuple[Welded, int]:
    """Return the mesh with corners of open edges joined that differ in float32's last step.

    And how many were joined; each takes the coordinates that most facets have there.
    """
    loose = open_corners(facet, len(vertex))
    if len(loose) == 0:
        return (vertex, facet), 0
    from scipy.spatial import cKDTree

    step = np.spacing(np.abs(vertex).astype(np.float32)).astype(float)
    tree = cKDTree(vertex[loose])
    pairs = tree.query_pairs(float(step[loose].max()) * 1.01, p=np.inf, output_type="ndarray")
    one, other = loose[pairs[:, 0]], loose[pairs[:, 1]]
    near = np.abs(vertex[one] - vertex[other]) <= 1.01 * np.maximum(step[one], step[other])
    one, other = one[near.all(axis=1)], other[near.all(axis=1)]
    if len(one) == 0:
        return (vertex, facet), 0
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    link = coo_array((np.ones(len(one)), (one, other)), shape=(len(vertex),) * 2)
    count, group = connected_components(link, directed=False)
    used = np.bincount(facet.ravel(), minlength=len(vertex))
    touched = np.zeros(count, bool)
    touched[group[one]] = True
    joined = np.empty((count, 3))
    for k in range(3):
        joined[:, k] = _most_used(vertex[:, k], group, used, count)
        joined[touched, k] = _settled(joined[touched, k], vertex[:, k], used)
    changed = group[facet]
    collapsed = (changed == np.roll(changed, 1, axis=1)).any(axis=1)
    return (joined, changed[~collapsed]), len(vertex) - count


def _most_used(
    value: NDArray[np.float64], group: NDArray, used: NDArray[np.int64], count: int
) -> NDArray[np.float64]:
    """Return the value (count,) that most facets of each group of vertices have."""
    order = np.lexsort((value, group))
    g, v = group[order], value[order]
    start = np.flatnonzero(np.r_[True, (g[1:] != g[:-1]) | (v[1:] != v[:-1])])
    weight = np.add.reduceat(used[order], start)
    best = np.lexsort((v[start], -weight, g[start]))
    first = np.flatnonzero(np.r_[True, np.diff(g[start][best]) != 0])
    chosen = np.empty(count)
    chosen[g[start][best][first]] = v[start][best][first]
    return chosen


def _settled(
    value: NDArray[np.float64], every: NDArray[np.float64], used: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return values moved by a step of float32 where more facets of the mesh have that one.

    So opposite sides of a tile, and the corners of a plane, stay in line.
    """
    known, number = np.unique(every.astype(np.float32), return_inverse=True)
    weight = np.bincount(number, used)
    here = value.astype(np.float32)
    best, most = here.copy(), np.full(len(here), -1.0)
    for near in (
        here,
        np.nextafter(here, np.float32(-np.inf)),
        np.nextafter(here, np.float32(np.inf)),
    ):
        at = np.minimum(np.searchsorted(known, near), len(known) - 1)
        count = np.where(known[at] == near, weight[at], -1.0)
        best, most = np.where(count > most, near, best), np.maximum(count, most)
    return best.astype(float)
