"""Extruded films as a chain of segments in the cross-section, walked run by run.

Where the top is a polyline z(x) drawn along y, the next hit lies to one side of the segment just
left, so no tree is searched. The chain is cut into *runs* in which the slope only grows (a groove
is one). Along a run the height of the surface over the ray is convex: whether and where they meet
is found by narrowing down the run's segments. Where to look first tells a parabola through the run;
what is right is decided by the vertices alone: on which side of one the ray passes, by the same
expression for both segments that meet there. A ray cannot slip between them, and no offset is
needed.

`chain_walk` has the kernels.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.solid.mesh import FilmMesh

_CELLS_A_RUN = 4


class Chain(NamedTuple):
    """The cross-section of an extruded film tile.

    Attributes
    ----------
    segment
        (s, 8) float64: x, z [mm] of the left and of the right end, x ascending from 0 to the tile's
        width; dz/dx; z of the upward unit normal; dz/dx of the segments to the left and right
    run
        (r, 8) float64: x, z [mm] of the left and the right end; a, b, c of the parabola
        z = a + b u + c u², u [mm] from the left end; segments a millimetre
    range
        (r, 4) float64: first and last segment of each run; the segment (with fraction) that the
        even spacing gives at its left end; 0
    cell
        (c, 4) float64: first and last run that reach into each of c equal cells of the width; the
        x [mm] between them, or infinity where it is one run or more than two; 0
    run_of
        (s,) int64, the run of each segment
    """

    segment: NDArray[np.float64]
    run: NDArray[np.float64]
    range: NDArray[np.float64]
    cell: NDArray[np.float64]
    run_of: NDArray[np.int64]


def build_chain(mesh: FilmMesh) -> Chain | None:
    """Return the chain of a film mesh, or None where it is not one height drawn along y."""
    if not mesh.underside:
        return None
    vertex = mesh.vertex[mesh.used]
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
    return chain_of(x, z)


def chain_of(x: NDArray[np.float64], z: NDArray[np.float64]) -> Chain:
    """Return the chain over the vertices (x, z) of a tile, x ascending from 0."""
    dx, dz = np.diff(x), np.diff(z)
    slope = dz / dx
    edge = np.r_[0, np.flatnonzero(np.diff(slope) < 0) + 1, len(dx)]
    run_of = np.repeat(np.arange(len(edge) - 1), np.diff(edge))
    ends = [x[:-1], z[:-1], x[1:], z[1:]]
    sides = [np.r_[0.0, slope[:-1]], np.r_[slope[1:], 0.0]]
    segment = np.stack([*ends, slope, dx / np.hypot(dx, dz), *sides], axis=1)
    run, start = parabolas(x, z, edge[:-1], edge[1:])
    span = np.stack([edge[:-1], edge[1:] - 1, start, 0 * start], axis=1)
    return Chain(segment, run, span, cells(x[edge]), run_of.astype(np.int64))


def parabolas(x: NDArray, z: NDArray, begin: NDArray, end: NDArray) -> tuple[NDArray, NDArray]:
    """Return `Chain.run` (r, 8), and the number of the segment at each run's left end (r,).

    Runs go from vertex `begin` to vertex `end`. The parabola passes through the first, a middle and
    the last of a run's inner vertices, as the outermost segments are often longer, straight walls;
    its segments count evenly between them.
    """
    first, last = np.minimum(begin + 1, end), np.maximum(end - 1, begin)
    few = end - begin < 4
    first, last = np.where(few, begin, first), np.where(few, end, last)
    middle = (first + last) // 2
    u, v, w = (x[i] - x[begin] for i in (first, middle, last))
    with np.errstate(invalid="ignore", divide="ignore"):
        left, right = (z[middle] - z[first]) / (v - u), (z[last] - z[middle]) / (w - v)
        c = np.where(middle > first, (right - left) / (w - u), 0.0)
    b = (z[last] - z[first]) / (w - u) - c * (u + w)
    a = z[first] - (b + c * u) * u
    density = (last - first) / (w - u)
    row = [x[begin], z[begin], x[end], z[end], a, b, c, density]
    return np.stack(row, axis=1), first - density * u


def cells(edge: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `Chain.cell` for runs between given x; exact also where a place is rounded."""
    count = _CELLS_A_RUN * (len(edge) - 1)
    side = np.arange(count + 1) * (edge[-1] / count)
    near = edge[-1] * 1e-9
    first, last = (
        np.clip(np.searchsorted(edge, s, side="right") - 1, 0, len(edge) - 2)
        for s in (side[:-1] - near, side[1:] + near)
    )
    between = np.where(last == first + 1, edge[last], np.inf)
    return np.stack([first, last, between, 0.0 * side[:-1]], axis=1)


def _facets_span_one_segment(mesh: FilmMesh, x: NDArray[np.float64]) -> bool:
    """Return whether each top facet lies between two neighbouring vertices of the cross-section."""
    place = np.searchsorted(x, mesh.vertex[mesh.top][..., 0])
    return bool((place.max(axis=1) - place.min(axis=1) == 1).all())
