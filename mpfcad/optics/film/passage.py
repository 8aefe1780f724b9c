"""A ray's passage through a film: Fresnel or total reflection at every facet it meets."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.phase import scattering_cosine
from mpfcad.optics.base.sampling import turn, uniform
from mpfcad.optics.film.interface import interface
from mpfcad.optics.film.resin import collision_distance, is_resin, segment_amid
from mpfcad.optics.search.tile import CHAIN, next_facet
from mpfcad.optics.search.tile_table import tile_of
from mpfcad.optics.stokes.interface import meet_interface
from mpfcad.optics.stokes.state import depolarise, turn_light, turn_light_back

#: The columns of a film in `Scene.parameter`: of its prisms, then of its resin. `RESIN_INDEX` is 0
#: where the resin is of the prisms' index and absorption.
INDEX, INDEX_BELOW, OFFSET, COSINE, SINE, FLIPPED, TILE, ABSORPTION = range(8)
SCATTERING, ASYMMETRY, PHASE, PRISM, RESIN_INDEX, RESIN_ABSORPTION, THINNEST = range(8, 15)
ROUGHNESS = 15
#: Not 0: paths within are measured although nothing absorbs, for light of other bands.
MEASURED = 16
#: Meetings after which a ray counts as lost. Along grooves whose curvature varies some light is
#: guided for 100,000 of them, over 30 m, and leaves in the end.
MOST_HITS = 1_000_000


@kernel
def placed_film_passage(tiles, phase, parameter, up, x, y, dx, dy, dz, light, rng):
    """Follow a ray through a film as it lies: (way, x, y, dx, dy, dz, travelled, soaked).

    `parameter` is that of the film's element; `light` the state of polarised light, or None.
    """
    width = tiles.size[int(parameter[TILE]), 0]
    turn_light(light, parameter[COSINE], parameter[SINE], parameter[FLIPPED] != 0.0)
    up, x, y, dx, dy, dz = into_film(parameter, width, up, x, y, dx, dy, dz)
    way, x, y, dx, dy, dz, travelled, soaked = film_passage(
        tiles, phase, parameter, up, x, y, dx, dy, dz, light, rng
    )
    turn_light_back(light, parameter[COSINE], parameter[SINE], parameter[FLIPPED] != 0.0)
    way, x, y, dx, dy, dz = out_of_film(parameter, width, way, x, y, dx, dy, dz)
    return way, x, y, dx, dy, dz, travelled, soaked


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
def film_passage(tiles, phase, parameter, up, x, y, dx, dy, dz, light, rng):
    """Follow a ray until it leaves the film: (way, x, y, dx, dy, dz, travelled, soaked).

    `up`: it comes from below, in a medium of the index below; else from the air above. `way` is
    1 when it leaves upward, -1 downward, 0 when it was lost (a hole in the mesh). `travelled` and
    `soaked` [mm] are its paths in prisms and in a resin of another material, which absorb by them
    (`soak`); 0 where nothing absorbs.
    """
    tile = tile_of(tiles, int(parameter[TILE]))
    index, index_below, offset = parameter[INDEX], parameter[INDEX_BELOW], parameter[OFFSET]
    scatters, amid = parameter[SCATTERING] > 0.0, False
    absorbs, travelled = parameter[ABSORPTION] > 0.0 or parameter[MEASURED] != 0.0, 0.0
    # Of a resin of another material: whether the ray is in it, and how far it has flown there.
    resin_index, in_resin, soaked = parameter[RESIN_INDEX], False, 0.0
    filled = resin_index > 0.0
    base_x = math.floor((x - offset) / tile.width) * tile.width + offset
    base_y = math.floor(y / tile.length) * tile.length
    x = min(max(x - base_x, 0.0), tile.width)
    y = min(max(y - base_y, 0.0), tile.length)
    z = tile.high
    inside = False
    k = -1
    # Where a ray meets the prisms' surface under the resin, and its normal.
    at_x, at_y, at_z, mx, mz = x, y, z, 0.0, 1.0
    if up:
        z = 0.0
    if up and tile.underside:
        entered, dx, dy, dz = underside(index_below, index, dx, dy, dz, light, rng)
        if not entered:
            return -1, x + base_x, y + base_y, dx, dy, dz, 0.0, 0.0
        inside = True
    for _ in range(MOST_HITS):
        x0, y0, z0 = x, y, z
        if amid and tile.accelerator == CHAIN:
            k, x, y, z, nx, ny, nz, shift_x, shift_y = segment_amid(tile, x, y, z, dx, dy, dz, True)
        else:
            k, x, y, z, nx, ny, nz, shift_x, shift_y = next_facet(
                tile, x, y, z, dx, dy, dz, k, inside
            )
        amid, meets, flown, reach = False, False, math.inf, 0.0
        if inside and k != -2 and (scatters or filled or absorbs):
            reach, steep = (z0 / -dz if dz < 0.0 else 0.0), 1.0
            if k >= 0:
                reach = (x + shift_x - x0) * dx + (y + shift_y - y0) * dy + (z - z0) * dz
                steep = abs(dx * nx + dy * ny + dz * nz)
            if scatters or filled:
                reach, flown, meets, at_x, at_y, at_z, mx, mz = through_resin(
                    tiles, parameter, x0, y0, z0, dx, dy, dz, in_resin, reach, steep, rng
                )
        step = min(flown, reach)
        if in_resin:
            soaked += step
        else:
            travelled += step
        if flown < reach:
            x, y, z = x0 + flown * dx, y0 + flown * dy, z0 + flown * dz
            cosine = scattering_cosine(
                phase, int(parameter[PHASE]), parameter[ASYMMETRY], uniform(rng)
            )
            dx, dy, dz = turn(dx, dy, dz, cosine, 2.0 * math.pi * uniform(rng))
            depolarise(light)
            k, amid = -1, True
            continue
        behind, beyond = index, 1.0
        if meets:
            x, y, z, nx, ny, nz = at_x, at_y, at_z, mx, 0.0, mz
            behind, beyond = (resin_index, index) if in_resin else (index, resin_index)
        else:
            base_x += shift_x
            base_y += shift_y
            if k == -2:
                return 0, x + base_x, y + base_y, dx, dy, dz, 0.0, 0.0
        if k >= 0 and not meets and filled:
            prism = tile_of(tiles, int(parameter[PRISM]))
            in_resin = is_resin(prism, x, z, parameter[THINNEST])
            behind = resin_index if in_resin else index
        if meets or k >= 0:
            rough = 0.0 if in_resin and not meets else parameter[ROUGHNESS]
            ratio = behind / beyond if inside else beyond / behind
            mirrored, dx, dy, dz = interface(ratio, rough, nx, ny, nz, dx, dy, dz, light, rng)
            if meets:
                in_resin = in_resin == mirrored
                k, amid = -1, True
            else:
                inside = inside == mirrored
            continue
        if not inside:
            flight = max(0.0, ((tile.high if dz > 0.0 else 0.0) - z) / dz)
            way = 1 if dz > 0.0 else -1
            x, y = x + flight * dx + base_x, y + flight * dy + base_y
            return way, x, y, dx, dy, dz, travelled, soaked
        flight = z / -dz
        x += flight * dx
        y += flight * dy
        z = 0.0
        tiles_on = math.floor(x / tile.width) * tile.width
        x = min(max(x - tiles_on, 0.0), tile.width)
        base_x += tiles_on
        in_resin = False
        left, dx, dy, dz = underside(index, index_below, dx, dy, dz, light, rng)
        if left:
            return -1, x + base_x, y + base_y, dx, dy, dz, travelled, soaked
    return 0, x + base_x, y + base_y, dx, dy, dz, 0.0, 0.0


@kernel
def underside(index_in, index_out, dx, dy, dz, light, rng):
    """Pass or reflect a ray at the flat underside: (passed, dx, dy, dz)."""
    ratio = index_in / index_out
    mirrored, cos_out = meet_interface(abs(dz), ratio, 0.0, 0.0, 1.0, dx, dy, dz, light, rng)
    if mirrored:
        return False, dx, dy, -dz
    return True, ratio * dx, ratio * dy, math.copysign(cos_out, dz)


@kernel
def through_resin(tiles, parameter, x, y, z, dx, dy, dz, in_resin, reach, steep, rng):
    """Return what a ray within the film meets first: (reach, flown, meets, x, y, z, nx, nz).

    `reach` [mm]: to the film's surface, at which its direction has a cosine of `steep`, or, if it
    `meets` it, to the prisms' surface under the resin at (x, y, z) with the upward normal n.
    `flown`: to where the resin scatters it, or infinity.
    """
    prism = tile_of(tiles, int(parameter[PRISM]))
    scattering = parameter[SCATTERING]
    if parameter[RESIN_INDEX] == 0.0:
        flown = collision_distance(prism, scattering, x, z, dx, dz, reach, rng)
        return reach, flown, False, x, y, z, 0.0, 1.0
    met, to_x, to_y, to_z, nx, nz = prism_ahead(prism, x, y, z, dx, dy, dz, in_resin)
    # At a bare wall film and prism have the same surface, and no resin lies between.
    meets = (reach - met) * steep > parameter[THINNEST]
    reach = met if meets else reach
    flown = math.inf
    if in_resin and scattering > 0.0:
        flown = -math.log(1.0 - uniform(rng)) / scattering
    return reach, flown, meets, to_x, to_y, to_z, nx, nz


@kernel
def prism_ahead(prism, x, y, z, dx, dy, dz, in_resin):
    """Return where a ray within the film meets the prisms' surface: (distance, x, y, z, nx, nz).

    It comes out of a prism, or (`in_resin`) out of the resin over them; the distance [mm] is
    infinite where it does not meet it. n: upward unit normal.
    """
    k, to_x, to_y, to_z, nx, _, nz, shift, _ = segment_amid(
        prism, x, y, z, dx, dy, dz, not in_resin
    )
    to_x += shift
    distance = (to_x - x) * dx + (to_y - y) * dy + (to_z - z) * dz
    # A ray that has just left the surface does not meet the same segment from its far side.
    if k < 0 or (dx * nx + dz * nz > 0.0) == in_resin:
        distance = math.inf
    return distance, to_x, to_y, to_z, nx, nz


@kernel
def facet(index, inside, nx, ny, nz, dx, dy, dz, light, rng):
    """Pass or reflect a ray at a smooth facet of outward normal n: (inside, dx, dy, dz)."""
    ratio = index if inside else 1.0 / index
    mirrored, dx, dy, dz = interface(ratio, 0.0, nx, ny, nz, dx, dy, dz, light, rng)
    return inside == mirrored, dx, dy, dz
