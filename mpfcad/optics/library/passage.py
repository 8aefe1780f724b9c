"""A ray's passage through a film that is a library of groove pieces on a grid.

A piece's top is a height over x, so a ray inside it walks from chord to chord, and meets the one
that it passes through from the side it is on; where pieces differ, the step between them is a wall
across y. A ray that is inside or outside stays so until it meets a surface: no offset is needed.
"""

import math

from numba import int64

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
from mpfcad.optics.film.passage import TILE as LIBRARY
from mpfcad.optics.library.piece import HIGH, LENGTH, LOW, PITCH
from mpfcad.optics.stokes.state import turn_light, turn_light_back

_MOST_STEPS = 10_000_000
#: Two pieces whose tops differ by less [mm] at a place are one surface there.
_SAME = 1e-9


@kernel
def placed_library_passage(library, parameter, up, x, y, dx, dy, dz, light, rng):
    """Follow a ray through a film as it lies in the stack: (way, x, y, dx, dy, dz)."""
    up, x, y, dx, dy, dz = into_film(parameter, 0.0, up, x, y, dx, dy, dz)
    turn_light(light, parameter[COSINE], parameter[SINE], False)
    way, x, y, dx, dy, dz = library_passage(library, parameter, up, x, y, dx, dy, dz, light, rng)
    turn_light_back(light, parameter[COSINE], parameter[SINE], False)
    return out_of_film(parameter, 0.0, way, x, y, dx, dy, dz)


@kernel
def chosen_at(table, row, i, j):
    """Return the number of the piece or cell at place (i, j), which may be any whole numbers."""
    first, across, along = table.place[row]
    return int64(table.chosen[first + (i % across) * along + j % along])


@kernel
def _chord(library, piece, u):
    """Return the number of the chord of a piece over u, 0 … pitch."""
    low, high = library.first[piece], library.first[piece + 1] - 2
    while low < high:
        middle = (low + high + 1) // 2
        if library.x[middle] <= u:
            low = middle
        else:
            high = middle - 1
    return low


@kernel
def _slope(library, k):
    return (library.z[k + 1] - library.z[k]) / (library.x[k + 1] - library.x[k])


@kernel
def library_passage(library, parameter, up, x, y, dx, dy, dz, light, rng):
    """Follow a ray until it leaves the film: (way, x, y, dx, dy, dz), as `film_passage`."""
    row = int(parameter[LIBRARY])
    index, below, offset = parameter[INDEX], parameter[INDEX_BELOW], parameter[OFFSET]
    size = library.size[row]
    pitch, length, high, low = size[PITCH], size[LENGTH], size[HIGH], size[LOW]
    x -= offset
    inside = False
    z = high
    if up:
        z = 0.0
        entered, dx, dy, dz = underside(below, index, dx, dy, dz, light, rng)
        if not entered:
            return -1, x + offset, y, dx, dy, dz
        inside = True
    i, j, k = 0, 0, -1
    u, piece = 0.0, 0
    for _ in range(_MOST_STEPS):
        if inside and z <= low:
            # Under all grooves: straight to the floor, or up to them.
            if dz == 0.0:
                break
            flight = ((0.0 if dz < 0.0 else low) - z) / dz
            x, y = x + flight * dx, y + flight * dy
            if dz < 0.0:
                z = 0.0
                left, dx, dy, dz = underside(index, below, dx, dy, dz, light, rng)
                if left:
                    return -1, x + offset, y, dx, dy, dz
                continue
            z = low
            k = -1
        if k < 0:
            i, j = math.floor(x / pitch), math.floor(y / length)
            piece = chosen_at(library, row, i, j)
            u = min(max(x - i * pitch, 0.0), pitch)
            k = _chord(library, piece, u)
        slope = _slope(library, k)
        above = z - (library.z[k] + slope * (u - library.x[k]))
        rate = dz - slope * dx
        hit, chord_end, piece_end, flat_end = math.inf, math.inf, math.inf, math.inf
        if (rate > 0.0) == inside and rate != 0.0:
            hit = max(0.0, -above / rate)
        if dx != 0.0:
            chord_end = max(0.0, (library.x[k + 1 if dx > 0.0 else k] - u) / dx)
        if dy != 0.0:
            piece_end = max(0.0, ((j + (1 if dy > 0.0 else 0)) * length - y) / dy)
        if inside and dz < 0.0:
            flat_end = max(0.0, (low - z) / dz)
        elif not inside and dz > 0.0:
            flat_end = max(0.0, (high - z) / dz)
        flight = min(min(hit, chord_end), min(piece_end, flat_end))
        if flight == math.inf:
            break
        x, y, z, u = x + flight * dx, y + flight * dy, z + flight * dz, u + flight * dx
        if flight == hit:
            z = library.z[k] + slope * (u - library.x[k])
            norm = 1.0 / math.sqrt(1.0 + slope * slope)
            inside, dx, dy, dz = facet(
                index, inside, -slope * norm, 0.0, norm, dx, dy, dz, light, rng
            )
        elif flight == flat_end:
            if not inside:
                return 1, x + offset, y, dx, dy, dz
            z = low
        elif flight == piece_end:
            step = 1 if dy > 0.0 else -1
            y = (j + (1 if dy > 0.0 else 0)) * length
            other = chosen_at(library, row, i, j + step)
            if other != piece:
                n = _chord(library, other, u)
                top = library.z[n] + _slope(library, n) * (u - library.x[n])
                if abs(z - top) > _SAME and (z < top) != inside:
                    # A wall: its solid side is this one's when the ray is inside.
                    normal = 1.0 if (step > 0) == inside else -1.0
                    was = inside
                    inside, dx, dy, dz = facet(
                        index, inside, 0.0, normal, 0.0, dx, dy, dz, light, rng
                    )
                    if inside == was:
                        continue
                piece, k = other, n
            j += step
        else:
            k += 1 if dx > 0.0 else -1
            u = library.x[k if dx > 0.0 else k + 1]
            over = k == library.first[piece + 1] - 1
            if over or k < library.first[piece]:
                i += 1 if over else -1
                piece = chosen_at(library, row, i, j)
                k = library.first[piece] if over else library.first[piece + 1] - 2
                u = 0.0 if over else pitch
    return 0, x + offset, y, dx, dy, dz
