"""Extruded films as a chain of segments in the cross-section, walked run by run.

Where the top is a polyline z(x) drawn along y, the next hit lies to one side of the segment just
left, so no tree is searched. The chain is cut into *runs* in which the slope only grows (a groove
is one). Along a run the height of the surface over the ray is convex: whether and where they meet
is found by bisection over the run's vertices. On which side of a vertex the ray passes is decided
by one expression for both segments that meet there: a ray cannot slip between them, and no offset
is needed.

The kernel takes one ray or eight (`lanes`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import any_of, floor, magnitude, select, whole
from mpfcad.optics.lanes_array import gather, gather_row
from mpfcad.optics.mesh import FilmMesh


class Chain(NamedTuple):
    """The cross-section of an extruded film tile.

    Attributes
    ----------
    vertex
        (s+1, 4) float64: x, z [mm] from x = 0 to the tile's width, x ascending; dz/dx of the
        segments to the right and to the left
    segment
        (s, 4) float64: x [mm] of the right end, unit normal x and z, upward; 0
    run
        (r+1,) int64, the vertices at which runs begin, and the last vertex
    run_of
        (s,) int64, the run of each segment
    first
        (c,) int64, the run at the left edge of each of c equal cells of the width
    """

    vertex: NDArray[np.float64]
    segment: NDArray[np.float64]
    run: NDArray[np.int64]
    run_of: NDArray[np.int64]
    first: NDArray[np.int64]


def build_chain(mesh: FilmMesh) -> Chain | None:
    """Return the chain of a film mesh, or None where it is not one height drawn along y."""
    if not mesh.underside:
        return None
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
    return chain_of(x, z)


def chain_of(x: NDArray[np.float64], z: NDArray[np.float64]) -> Chain:
    """Return the chain over the vertices (x, z) of a tile, x ascending from 0."""
    dx, dz = np.diff(x), np.diff(z)
    norm, slope = np.hypot(dx, dz), dz / dx
    run = np.r_[0, np.flatnonzero(np.diff(slope) < 0) + 1, len(dx)].astype(np.int64)
    run_of = np.repeat(np.arange(len(run) - 1), np.diff(run))
    cells = np.arange(2 * len(run)) * (x[-1] / (2 * len(run)))
    first = np.clip(np.searchsorted(x[run], cells, side="right") - 1, 0, len(run) - 2)
    vertex = np.stack([x, z, np.r_[slope, 0.0], np.r_[0.0, slope]], axis=1)
    segment = np.stack([x[1:], -dz / norm, dx / norm, np.zeros_like(dx)], axis=1)
    return Chain(vertex, segment, run, run_of, first)


def _facets_span_one_segment(mesh: FilmMesh, x: NDArray[np.float64]) -> bool:
    """Return whether each top facet lies between two neighbouring vertices of the cross-section."""
    place = np.searchsorted(x, mesh.vertex[mesh.top][..., 0])
    return bool((place.max(axis=1) - place.min(axis=1) == 1).all())


@kernel
def _x(chain, v):
    """Return x of a vertex."""
    return gather_row(chain.vertex, v)[0]


@kernel
def _run_at(chain, width, x, wanted):
    """Return the run over x in [0, width], where wanted."""
    last = len(chain.run) - 2
    cells = len(chain.first)
    place = x * (cells / width)
    cell = whole(select(place < cells - 1.0, select(place > 0.0, place, 0.0), cells - 1.0))
    run = gather(chain.first, cell)
    while True:
        back = wanted & (run > 0) & (x < _x(chain, gather(chain.run, run)))
        ahead = wanted & (run < last) & (x >= _x(chain, gather(chain.run, run + 1)))
        if not any_of(back | ahead):
            return run
        run = select(back, run - 1, select(ahead, run + 1, run))


@kernel
def chain_hit(chain, width, low, high, x, z, dx, dz, k, inside, active):
    """Return the next segment that a ray meets: (segment or -1, distance, x, z, shift, normal).

    The ray starts at (x, z) [mm], inside or outside the film, with x in [0, width]; `k` is the
    segment it starts on, or -1 when it starts below the lowest (inside) or above the highest point
    (outside); low, high: lowest and highest z of the top. `shift` [mm] is what to add to x to be in
    the same coordinates as before; segment -1: it leaves the zone of the top without a hit, -2: it
    was lost. One ray, or eight of which the `active` count.
    """
    right = dx > 0.0
    forward = select(right, 1, -1)
    sign = select(right, 1.0, -1.0)
    side = select(inside, 1.0, -1.0)
    speed = magnitude(dx)
    level = select(inside, low, high)
    new = k < 0
    # Free flight up (or down) to the zone, for those that start beyond it.
    flight = (level - z) / dz
    entry = x + select(new & (flight > 0.0), flight, 0.0) * dx
    shift = select(new, floor(entry / width) * width, 0.0)
    x = x - shift
    run = select(new, 0, gather(chain.run_of, select(new, 0, k)))
    at = select(right, k + 1, k)
    if any_of(new & active):
        entry = entry - shift
        entry = select(entry > 0.0, select(entry < width, entry, width), 0.0)
        run = select(new, _run_at(chain, width, entry, new & active), run)
        at = select(new, gather(chain.run, select(right, run, run + 1)), at)
    # Surface over ray is convex and 0 at the start: from inside, the run's rest is not met again.
    skip = (new ^ True) & inside
    at = select(skip, gather(chain.run, select(right, run + 1, run)), at)
    walking = active & (new | (speed > 0.0))
    k = select(active & (walking ^ True), -1, select(active, -2, k))
    for _ in range(64 * len(chain.run) + 64):
        end = gather(chain.run, select(right, run + 1, run))
        # The first vertex past the ray, or (inside) past the run's least height over the ray.
        near = select(right, 0, 0)
        far = select(right, end - at, at - end)
        while True:
            between = walking & (far - near > 1)
            if not any_of(between):
                break
            middle = (near + far) >> 1
            v = select(right, at + middle, at - middle)
            vx, vz, after, before = gather_row(chain.vertex, v)
            gap = ((vz - z) * speed - (vx - x) * sign * dz) * side
            steeper = select(right, after, -before) * speed >= dz
            past = (gap <= 0.0) | (inside & steeper)
            far = select(between & past, middle, far)
            near = select(between & (past ^ True), middle, near)
        v = select(right, at + far, at - far)
        vx, vz, _, _ = gather_row(chain.vertex, v)
        gap = ((vz - z) * speed - (vx - x) * sign * dz) * side
        met = walking & (far > 0) & (gap <= 0.0)
        k = select(met, select(right, v - 1, v), k)
        # Past the run's end: out of the zone already?
        ahead = (_x(chain, end) - x) * sign * dz - (level - z) * speed
        gone = walking & (met ^ True) & (dz * side < 0.0) & (ahead * side < 0.0)
        k = select(gone, -1, k)
        walking = walking & ((met | gone) ^ True)
        if not any_of(walking):
            break
        run = select(walking, run + forward, run)
        beyond = run == len(chain.run) - 1
        under = run < 0
        run = select(beyond, 0, select(under, len(chain.run) - 2, run))
        turn = select(beyond, width, select(under, -width, 0.0))
        x = x - turn
        shift = shift + turn
        at = gather(chain.run, select(right, run, run + 1))
    return _meet(chain, k, x, z, dx, dz, shift)


@kernel
def _meet(chain, k, x, z, dx, dz, shift):
    """Return the hit on segment k, its point put onto the segment."""
    hit = k >= 0
    segment = select(hit, k, 0)
    x0, z0, slope, _ = gather_row(chain.vertex, segment)
    x1, nx, nz, _ = gather_row(chain.segment, segment)
    distance = ((x0 - x) * nx + (z0 - z) * nz) / (dx * nx + dz * nz)
    distance = select(hit & (distance > 0.0), distance, 0.0)
    hit_x = x + distance * dx
    hit_x = select(hit_x > x0, select(hit_x < x1, hit_x, x1), x0)
    hit_z = z0 + slope * (hit_x - x0)
    return k, distance, select(hit, hit_x, x), select(hit, hit_z, z), shift, nx, nz
