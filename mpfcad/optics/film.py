"""A ray's passage through a film: Fresnel or total reflection at every facet it meets."""

import math

from mpfcad.optics.fresnel import fresnel
from mpfcad.optics.kernel import kernel
from mpfcad.optics.sampling import uniform
from mpfcad.optics.tile import next_facet

_MOST_HITS = 100_000


@kernel
def film_passage(tile, index, index_below, offset, up, x, y, dx, dy, dz, rng):
    """Follow a ray through the film until it leaves it: (way, x, y, dx, dy, dz).

    `up`: it comes from below, in a medium of `index_below`; else from the air above. `way` is 1
    when it leaves upward, -1 downward, 0 when it was lost (a hole in the mesh).
    """
    base_x = math.floor((x - offset) / tile.width) * tile.width + offset
    base_y = math.floor(y / tile.length) * tile.length
    x = min(max(x - base_x, 0.0), tile.width)
    y = min(max(y - base_y, 0.0), tile.length)
    z = tile.high
    inside = False
    k = -1
    if up:
        entered, dx, dy, dz = _underside(index_below, index, dx, dy, dz, rng)
        if not entered:
            return -1, x + base_x, y + base_y, dx, dy, dz
        inside = True
        z = 0.0
    for _ in range(_MOST_HITS):
        k, x, y, z, nx, ny, nz, shift_x, shift_y = next_facet(tile, x, y, z, dx, dy, dz, k, inside)
        base_x += shift_x
        base_y += shift_y
        if k == -2:
            return 0, x + base_x, y + base_y, dx, dy, dz
        if k >= 0:
            inside, dx, dy, dz = _facet(index, inside, nx, ny, nz, dx, dy, dz, rng)
            continue
        if not inside:
            flight = max(0.0, (tile.high - z) / dz)
            return 1, x + flight * dx + base_x, y + flight * dy + base_y, dx, dy, dz
        flight = z / -dz
        x += flight * dx
        y += flight * dy
        z = 0.0
        turn = math.floor(x / tile.width) * tile.width
        x = min(max(x - turn, 0.0), tile.width)
        base_x += turn
        left, dx, dy, dz = _underside(index, index_below, dx, dy, dz, rng)
        if left:
            return -1, x + base_x, y + base_y, dx, dy, dz
    return 0, x + base_x, y + base_y, dx, dy, dz


@kernel
def _underside(index_in, index_out, dx, dy, dz, rng):
    """Pass or reflect a ray at the flat underside: (passed, dx, dy, dz)."""
    ratio = index_in / index_out
    reflectance, cos_out = fresnel(abs(dz), ratio)
    if uniform(rng) < reflectance:
        return False, dx, dy, -dz
    return True, ratio * dx, ratio * dy, math.copysign(cos_out, dz)


@kernel
def _facet(index, inside, nx, ny, nz, dx, dy, dz, rng):
    """Pass or reflect a ray at a facet of outward normal n: (inside, dx, dy, dz)."""
    approach = dx * nx + dy * ny + dz * nz
    cos_in = min(1.0, abs(approach))
    ratio = index if inside else 1.0 / index
    reflectance, cos_out = fresnel(cos_in, ratio)
    if uniform(rng) < reflectance:
        return (
            inside,
            dx - 2.0 * approach * nx,
            dy - 2.0 * approach * ny,
            dz - 2.0 * approach * nz,
        )
    bend = math.copysign(cos_out, approach) - ratio * approach
    return not inside, ratio * dx + bend * nx, ratio * dy + bend * ny, ratio * dz + bend * nz
