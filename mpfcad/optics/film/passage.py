"""A ray's passage through a film: Fresnel or total reflection at every facet it meets."""

import math

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.phase import scattering_cosine
from mpfcad.optics.base.sampling import turn, uniform
from mpfcad.optics.film.resin import collision_distance, segment_amid
from mpfcad.optics.search.tile import CHAIN, next_facet
from mpfcad.optics.search.tile_table import tile_of

#: The columns of a film in `Scene.parameter`; four of its resin, and the absorption of both.
INDEX, INDEX_BELOW, OFFSET, COSINE, SINE, FLIPPED, TILE = range(7)
SCATTERING, ASYMMETRY, PHASE, PRISM, ABSORPTION = range(7, 12)
#: Meetings after which a ray counts as lost.
MOST_HITS = 100_000


@kernel
def placed_film_passage(tiles, phase, parameter, up, x, y, dx, dy, dz, rng):
    """Follow a ray through a film as it lies in the stack: (way, x, y, dx, dy, dz, survival).

    `parameter` is that of the film's element.
    """
    width = tiles.size[int(parameter[TILE]), 0]
    up, x, y, dx, dy, dz = into_film(parameter, width, up, x, y, dx, dy, dz)
    way, x, y, dx, dy, dz, survival = film_passage(
        tiles, phase, parameter, up, x, y, dx, dy, dz, rng
    )
    way, x, y, dx, dy, dz = out_of_film(parameter, width, way, x, y, dx, dy, dz)
    return way, x, y, dx, dy, dz, survival


@kernel
def into_film(parameter, width, up, x, y, dx, dy, dz):
    """Turn a ray into the film's own axes: (up, x, y, dx, dy, dz).

    By the film's angle about z, and, where it lies upside down, about the middle of its tile.
    """
    cosine, sine = parameter[COSINE], parameter[SINE]
    if cosine != 1.0:
        x, y = cosine * x + sine * y, cosine * y - sine * x
        dx, dy = cosine * dx + sine * dy, cosine * dy - sine * dx
    if parameter[FLIPPED] != 0.0:
        x, dx, dz, up = 2.0 * parameter[OFFSET] + width - x, -dx, -dz, not up
    return up, x, y, dx, dy, dz


@kernel
def out_of_film(parameter, width, way, x, y, dx, dy, dz):
    """Turn a ray that leaves the film back into the stack's axes: (way, x, y, dx, dy, dz)."""
    cosine, sine = parameter[COSINE], parameter[SINE]
    if parameter[FLIPPED] != 0.0:
        x, dx, dz, way = 2.0 * parameter[OFFSET] + width - x, -dx, -dz, -way
    if cosine != 1.0:
        x, y = cosine * x - sine * y, cosine * y + sine * x
        dx, dy = cosine * dx - sine * dy, cosine * dy + sine * dx
    return way, x, y, dx, dy, dz


@kernel
def film_passage(tiles, phase, parameter, up, x, y, dx, dy, dz, rng):
    """Follow a ray through the film until it leaves it: (way, x, y, dx, dy, dz, survival).

    `up`: it comes from below, in a medium of the index below; else from the air above. `way` is
    1 when it leaves upward, -1 downward, 0 when it was lost (a hole in the mesh). `survival` is the
    share of its weight that the film has not absorbed, exp(-absorption · path inside).
    """
    tile = tile_of(tiles, int(parameter[TILE]))
    index, index_below, offset = parameter[INDEX], parameter[INDEX_BELOW], parameter[OFFSET]
    scatters, amid = parameter[SCATTERING] > 0.0, False
    absorption, travelled = parameter[ABSORPTION], 0.0
    base_x = math.floor((x - offset) / tile.width) * tile.width + offset
    base_y = math.floor(y / tile.length) * tile.length
    x = min(max(x - base_x, 0.0), tile.width)
    y = min(max(y - base_y, 0.0), tile.length)
    z = tile.high
    inside = False
    k = -1
    if up:
        z = 0.0
    if up and tile.underside:
        entered, dx, dy, dz = underside(index_below, index, dx, dy, dz, rng)
        if not entered:
            return -1, x + base_x, y + base_y, dx, dy, dz, 1.0
        inside = True
    for _ in range(MOST_HITS):
        x0, y0, z0 = x, y, z
        if amid and tile.accelerator == CHAIN:
            k, x, y, z, nx, ny, nz, shift_x, shift_y = segment_amid(tile, x, y, z, dx, dy, dz)
        else:
            k, x, y, z, nx, ny, nz, shift_x, shift_y = next_facet(
                tile, x, y, z, dx, dy, dz, k, inside
            )
        amid = False
        reach = 0.0
        if inside and k != -2 and (scatters or absorption > 0.0):
            reach = z0 / -dz if dz < 0.0 else 0.0
            if k >= 0:
                reach = (x + shift_x - x0) * dx + (y + shift_y - y0) * dy + (z - z0) * dz
        if scatters and inside and k != -2:
            prism = tile_of(tiles, int(parameter[PRISM]))
            flown = collision_distance(prism, parameter[SCATTERING], x0, z0, dx, dz, reach, rng)
            if flown < reach:
                x, y, z = x0 + flown * dx, y0 + flown * dy, z0 + flown * dz
                cosine = scattering_cosine(
                    phase, int(parameter[PHASE]), parameter[ASYMMETRY], uniform(rng)
                )
                dx, dy, dz = turn(dx, dy, dz, cosine, 2.0 * math.pi * uniform(rng))
                k, amid = -1, True
                travelled += flown
                continue
        travelled += reach
        base_x += shift_x
        base_y += shift_y
        if k == -2:
            return 0, x + base_x, y + base_y, dx, dy, dz, 1.0
        if k >= 0:
            inside, dx, dy, dz = facet(index, inside, nx, ny, nz, dx, dy, dz, rng)
            continue
        if not inside:
            flight = max(0.0, ((tile.high if dz > 0.0 else 0.0) - z) / dz)
            way = 1 if dz > 0.0 else -1
            x, y = x + flight * dx + base_x, y + flight * dy + base_y
            return way, x, y, dx, dy, dz, math.exp(-absorption * travelled)
        flight = z / -dz
        x += flight * dx
        y += flight * dy
        z = 0.0
        tiles_on = math.floor(x / tile.width) * tile.width
        x = min(max(x - tiles_on, 0.0), tile.width)
        base_x += tiles_on
        left, dx, dy, dz = underside(index, index_below, dx, dy, dz, rng)
        if left:
            survival = math.exp(-absorption * travelled)
            return -1, x + base_x, y + base_y, dx, dy, dz, survival
    return 0, x + base_x, y + base_y, dx, dy, dz, 1.0


@kernel
def underside(index_in, index_out, dx, dy, dz, rng):
    """Pass or reflect a ray at the flat underside: (passed, dx, dy, dz)."""
    ratio = index_in / index_out
    reflectance, cos_out = fresnel(abs(dz), ratio)
    if uniform(rng) < reflectance:
        return False, dx, dy, -dz
    return True, ratio * dx, ratio * dy, math.copysign(cos_out, dz)


@kernel
def unit(dx, dy, dz):
    """Return a direction, or eight, of a length that is 1 to rounding, as 1 to its own (Newton).

    Else the rounding of thousands of total reflections would add up, and with it the distances that
    are measured along the direction would be wrong.
    """
    factor = 1.5 - 0.5 * (dx * dx + dy * dy + dz * dz)
    return factor * dx, factor * dy, factor * dz


@kernel
def facet(index, inside, nx, ny, nz, dx, dy, dz, rng):
    """Pass or reflect a ray at a facet of outward normal n: (inside, dx, dy, dz)."""
    approach = dx * nx + dy * ny + dz * nz
    cos_in = min(1.0, abs(approach))
    ratio = index if inside else 1.0 / index
    reflectance, cos_out = fresnel(cos_in, ratio)
    mirrored = uniform(rng) < reflectance
    bend = -2.0 * approach if mirrored else math.copysign(cos_out, approach) - ratio * approach
    scale = 1.0 if mirrored else ratio
    dx, dy, dz = unit(scale * dx + bend * nx, scale * dy + bend * ny, scale * dz + bend * nz)
    return inside == mirrored, dx, dy, dz
