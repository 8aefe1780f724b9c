"""Builds the uniform grid over a film's top, where that suits its facets."""

import math

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.search.grid.cells import Grid
from mpfcad.optics.search.grid.walk import MARGIN
from mpfcad.optics.search.seam import facet_normals, with_seam
from mpfcad.optics.solid.mesh import FilmMesh

#: Facets a cell that are tried, and what suits: how often a facet is listed, and the longest list.
_FACETS = (1.0, 2.0, 4.0, 8.0)
_MOST_TIMES, _LONGEST = 4, 32


def build_grid(mesh: FilmMesh) -> Grid | None:
    """Return the grid over the top facets of a film mesh.

    None where facets are of too different sizes for one: where they would be listed more than four
    times on average, or more than 32 in some cell, at any size of the cells. Then most cells hold
    nothing, or many. Nor is there one where no flat underside closes the film.
    """
    if not mesh.underside:
        return None
    corner, number = with_seam(mesh.vertex[mesh.top], *mesh.size[:2])
    low, high = corner.min(axis=1), corner.max(axis=1)
    best, cheapest = None, math.inf
    for facets in _FACETS:
        count = _cells(mesh, len(mesh.top) / facets)
        first, last = _span(low, high, mesh, count)
        times = (last - first + 1).prod(axis=1)
        listed = times.sum()
        # A path of some length visits so many cells, and each costs about as much as one facet.
        cost = (1 + listed / count.prod()) * math.hypot(*(count / mesh.size[:2]))
        if listed <= _MOST_TIMES * len(corner) and cost < cheapest:
            best, cheapest = (count, first, last, times), cost
    if best is None:
        return None
    count, first, last, times = best
    cell, facet = _lists(count, first, last, times)
    many = np.bincount(cell, minlength=count.prod())
    if many.max() > _LONGEST:
        return None
    begin = np.cumsum(many) - many
    z = np.stack([np.full(len(many), np.inf), np.full(len(many), -np.inf)], axis=1)
    held = np.flatnonzero(many)
    # The z range is wider than the rounding of what is compared with it.
    margin = 1e-9 * max(mesh.size)
    z[held, 0] = np.minimum.reduceat(low[facet, 2], begin[held]) - margin
    z[held, 1] = np.maximum.reduceat(high[facet, 2], begin[held]) + margin
    rows = np.concatenate([corner.reshape(-1, 9), facet_normals(corner)], axis=1)
    return Grid(
        count, np.column_stack([z, begin, many]).astype(float),
        rows[facet].reshape(-1, 4), number[facet],
    )  # fmt: skip


def _cells(mesh: FilmMesh, wanted: float) -> NDArray[np.int64]:
    """Return how many cells along x and y, nearly square, make about as many as wanted."""
    width, length, _ = mesh.size
    side = math.sqrt(width * length / wanted)
    return np.array([max(1, round(width / side)), max(1, round(length / side))])


def _span(
    low: NDArray[np.float64], high: NDArray[np.float64], mesh: FilmMesh, count: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first and last cells along x and y in which each facet is listed, (t, 2) each."""
    scale = count / mesh.size[:2]
    low, high = low[:, :2] * scale, high[:, :2] * scale
    middle = (low + high) / 2
    first = np.floor(np.minimum(low + MARGIN, middle))
    last = np.floor(np.maximum(high - MARGIN, middle))
    top = count - 1
    return np.clip(first, 0, top).astype(np.int64), np.clip(last, 0, top).astype(np.int64)


def _lists(
    count: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64],
    times: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:  # fmt: skip
    """Return (cell, facet) of all places of the lists, cell after cell."""
    facet = np.repeat(np.arange(len(times)), times)
    turn = np.arange(len(facet)) - np.repeat(np.cumsum(times) - times, times)
    rows = (last - first)[facet, 1] + 1
    cell = (first[facet, 0] + turn // rows) * count[1] + first[facet, 1] + turn % rows
    order = np.argsort(cell, kind="stable")
    return cell[order], facet[order]
