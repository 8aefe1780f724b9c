"""A ray's passage through a film of cells whose tops are triangles over x and y.

The ray walks from facet to facet as its place over the cell passes their edges, and meets the plane
that it passes through from the side it is on; where neighbouring cells differ, the step between
them is a wall. A ray that is inside or outside stays so until it meets a surface: no offset is
needed.
"""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.film.passage import (
    COSINE,
    INDEX,
    INDEX_BELOW,
    OFFSET,
    SINE,
    facet,
    into_film,
    out_of_film,
    underside,
)
from mpfcad.optics.film.passage import TILE as CELLS
from mpfcad.optics.library.passage import chosen_at
from mpfcad.optics.library.piece import HIGH, LENGTH, LOW, PITCH
from mpfcad.optics.library.top import BUCKETS
from mpfcad.optics.stokes.state import turn_light, turn_light_back

_MOST_STEPS = 10_000_000
#: Two cells whose tops differ by less [mm] at a place are one surface there.
_SAME = 1e-9


@kernel
def placed_cell_passage(cells, parameter, up, x, y, dx, dy, dz, light, rng):
    """Follow a ray through a film as it lies in the stack: (way, x, y, dx, dy, dz)."""
    up, x, y, dx, dy, dz = into_film(parameter, 0.0, up, x, y, dx, dy, dz)
    turn_light(light, parameter[COSINE], parameter[SINE], False)
    way, x, y, dx, dy, dz = cell_passage(cells, parameter, up, x, y, dx, dy, dz, light, rng)
    turn_light_back(light, parameter[COSINE], parameter[SINE], False)
    return out_of_film(parameter, 0.0, way, x, y, dx, dy, dz)


@kernel
def _height(cells, t, u, v):
    return cells.plane[t, 0] + cells.plane[t, 1] * u + cells.plane[t, 2] * v


@kernel
def _leave(cells, t, u, v, du, dv):
    """Return the edge by which a ray leaves facet t, and how far it is."""
    far, last = math.inf, 0
    for e in range(3 * t, 3 * t + 3):
        rate = cells.edge[e, 0] * du + cells.edge[e, 1] * dv
        if rate > 0.0:
            gap = cells.edge[e, 2] - cells.edge[e, 0] * u - cells.edge[e, 1] * v
            distance = max(0.0, gap / rate)
            if distance < far:
                far, last = distance, e
    return last, far


@kernel
def _over(cells, kind, size, u, v):
    """Return the facet of a cell over (u, v) [mm]: walked to, straight from the bucket's middle."""
    i = min(int(u / size[PITCH] * BUCKETS), BUCKETS - 1)
    k = min(int(v / size[LENGTH] * BUCKETS), BUCKETS - 1)
    t = cells.start[(kind * BUCKETS + i) * BUCKETS + k]
    p, q = (i + 0.5) / BUCKETS * size[PITCH], (k + 0.5) / BUCKETS * size[LENGTH]
    for _ in range(_MOST_STEPS):
        e, share = _leave(cells, t, p, q, u - p, v - q)
        if share >= 1.0 or cells.beyond[e] < 0:
            break
        p, q = p + share * (u - p), q + share * (v - q)
        t = cells.beyond[e]
    return t


@kernel
def cell_passage(cells, parameter, up, x, y, dx, dy, dz, light, rng):
    """Follow a ray until it leaves the film: (way, x, y, dx, dy, dz), as `film_passage`."""
    row = int(parameter[CELLS])
    index, below, offset = parameter[INDEX], parameter[INDEX_BELOW], parameter[OFFSET]
    size = cells.size[row]
    pitch, length, high, low = size[PITCH], size[LENGTH], size[HIGH], size[LOW]
    i, j = math.floor((x - offset) / pitch), math.floor(y / length)
    u, v = x - offset - i * pitch, y - j * length
    inside, z = False, high
    way = 0
    if up:
        z = 0.0
        inside, dx, dy, dz = underside(below, index, dx, dy, dz, light, rng)
        if not inside:
            return -1, x, y, dx, dy, dz
    t, kind = -1, 0
    for _ in range(_MOST_STEPS):
        if inside and z <= low:
            # Under all tops: straight to the floor, or up to them.
            if dz == 0.0:
                break
            flight = ((0.0 if dz < 0.0 else low) - z) / dz
            u, v = u + flight * dx, v + flight * dy
            if dz < 0.0:
                z = 0.0
                left, dx, dy, dz = underside(index, below, dx, dy, dz, light, rng)
                if left:
                    way = -1
                    break
                continue
            z = low
            t = -1
        if t < 0:
            a, b = math.floor(u / pitch), math.floor(v / length)
            i, j = i + a, j + b
            u, v = min(max(u - a * pitch, 0.0), pitch), min(max(v - b * length, 0.0), length)
            kind = chosen_at(cells, row, i, j)
            t = _over(cells, kind, size, u, v)
        above = z - _height(cells, t, u, v)
        rise_x, rise_y = cells.plane[t, 1], cells.plane[t, 2]
        rate = dz - rise_x * dx - rise_y * dy
        hit, flat_end = math.inf, math.inf
        if (rate > 0.0) == inside and rate != 0.0:
            hit = max(0.0, -above / rate)
        e, edge_end = _leave(cells, t, u, v, dx, dy)
        if inside and dz < 0.0:
            flat_end = max(0.0, (low - z) / dz)
        elif not inside and dz > 0.0:
            flat_end = max(0.0, (high - z) / dz)
        flight = min(hit, min(edge_end, flat_end))
        if flight == math.inf:
            break
        u, v, z = u + flight * dx, v + flight * dy, z + flight * dz
        if flight == hit:
            z = _height(cells, t, u, v)
            norm = 1.0 / math.sqrt(1.0 + rise_x * rise_x + rise_y * rise_y)
            inside, dx, dy, dz = facet(
                index, inside, -rise_x * norm, -rise_y * norm, norm, dx, dy, dz, light, rng
            )
        elif flight == flat_end:
            if not inside:
                way = 1
                break
            z = low
        elif cells.beyond[e] >= 0:
            t = cells.beyond[e]
        else:
            side = -1 - cells.beyond[e]
            forward = side % 2
            step = 2 * forward - 1
            a, b = (step, 0) if side < 2 else (0, step)
            # The same place by the neighbour's own axes.
            p = (1.0 - forward) * pitch if side < 2 else u
            q = v if side < 2 else (1.0 - forward) * length
            p, q = min(max(p, 0.0), pitch), min(max(q, 0.0), length)
            other = chosen_at(cells, row, i + a, j + b)
            n = _over(cells, other, size, p, q)
            top = _height(cells, n, p, q)
            if abs(z - top) > _SAME and (z < top) != inside:
                # A wall: its solid side is this one's when the ray is inside.
                was = inside
                toward = float(step) if inside else -float(step)
                nx, ny = (toward, 0.0) if side < 2 else (0.0, toward)
                inside, dx, dy, dz = facet(index, inside, nx, ny, 0.0, dx, dy, dz, light, rng)
                if inside == was:
                    continue
            i, j, u, v, kind, t = i + a, j + b, p, q, other, n
    return way, i * pitch + u + offset, j * length + v, dx, dy, dz
