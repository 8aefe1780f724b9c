"""Passages of many rays through an extruded film of any cross-section, eight at a time.

The same physics as `film.film_passage`, ray by ray the same bits. Rays walk over the section's
cells a segment a step, all lanes at once; when some have arrived, those pass or reflect there and
start on their next way. A ray that has left the film makes room for the next of the queue.
"""

import math

from numba import uint64

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import (
    LANES,
    bits,
    copy_sign,
    count_of,
    floor,
    magnitude,
    select,
    spread,
    whole,
)
from mpfcad.optics.base.lanes_array import gather_row, load, local_floats, local_wholes, store
from mpfcad.optics.base.sampling import (
    BLOCK,
    HAS_SPARE,
    KEY0,
    KEY1,
    PATH0,
    PATH1,
    SPARE,
    STREAM,
)
from mpfcad.optics.base.sampling_lanes import next_two, take
from mpfcad.optics.film.passage import MOST_HITS, unit
from mpfcad.optics.search.grid.section_walk import (
    choose_section,
    is_astray,
    no_section_walk,
    section_end,
    section_slack,
    start_section,
    walk_section,
)

# Columns of a ray's place and first rows of the lanes' scratch.
X, Y, Z, DX, DY, DZ = range(6)
# Further rows.
_BASE_X, _BASE_Y = 6, 7
_FRESH, _ENTERS, _HITS, _DRAW, _SPARE, _HAS, _PATH0, _PATH1, _RAY = range(9)
_NUMBERS, _WHOLES = 8 * LANES, 9 * LANES
_EMPTY = -1
#: So many rays wait for each other before they are passed on.
_TOGETHER = 4


@kernel
def section_passages(tile, index, index_below, offset, rays, place, up, way, rng):
    """Follow rays through a film until they leave it, as `chain_lanes.film_passages` does."""
    if len(rays) == 0:
        return
    section, width, low, high = tile.section, tile.width, tile.low, tile.high
    slack = section_slack(width, high)
    key0, key1 = rng[rays[0], KEY0], rng[rays[0], KEY1]
    stream = spread(rng[rays[0], STREAM])
    numbers, wholes = local_floats(_NUMBERS), local_wholes(_WHOLES)
    following = 0
    for lane in range(LANES):
        following = _take(tile, offset, rays, following, place, up, rng, lane, numbers, wholes)
    none = load(numbers, X) < load(numbers, X)
    walking, inside, stays = none, none, none
    walk = no_section_walk(spread(0.0))
    while True:
        x, y, z = load(numbers, X), load(numbers, Y), load(numbers, Z)
        dx, dy, dz = load(numbers, DX), load(numbers, DY), load(numbers, DZ)
        base_x = load(numbers, _BASE_X)
        fresh, enters = load(wholes, _FRESH) != 0, load(wholes, _ENTERS) != 0
        hits = load(wholes, _HITS)
        draw, spare = load(wholes, _DRAW), load(wholes, _SPARE)
        has = load(wholes, _HAS) != 0
        path0, path1 = load(wholes, _PATH0), load(wholes, _PATH1)
        live = load(wholes, _RAY) >= 0
        inside = inside & (fresh ^ True)
        total = count_of(live)
        if total == 0:
            return
        most_walking = total - min(_TOGETHER, total)
        ended, down, lost = none, none, none
        while bits(ended) == 0:
            side = select(inside, 1.0, -1.0)
            while count_of(walking) > most_walking:
                walk, walking = walk_section(section, width, low, high, walk, side, slack, walking)
            done = live & (walking ^ True)
            arrived = done & (fresh ^ True)
            astray = is_astray(tile.underside, inside, dz)
            met, astray, distance, at_x, at_z, shift = section_end(walk, stays, astray)
            met, astray = met & arrived, astray & arrived
            x, z = select(arrived, at_x, x), select(arrived, at_z, z)
            y = select(arrived, y + distance * dy, y)
            base_x = select(arrived, base_x + shift, base_x)
            # Past the last segment: flight to the top of the film, or to its underside.
            free = arrived & ((met | astray) ^ True)
            flight = (select(inside | ((dz > 0.0) ^ True), 0.0, high) - z) / dz
            flight = select(flight > 0.0, flight, 0.0)
            x, y = select(free, x + flight * dx, x), select(free, y + flight * dy, y)
            grounded = free & inside
            turn = floor(x / width) * width
            near = x - turn
            near = select(near > 0.0, select(near < width, near, width), 0.0)
            x, z = select(grounded, near, x), select(grounded, 0.0, z)
            base_x = select(grounded, base_x + turn, base_x)
            number_of = whole(select(met, walk.place, 0.0))
            nx, nz, _, _ = gather_row(section.facing, number_of)
            under = (done & enters) | grounded
            meets = under | met
            # One interface for segments and underside.
            nx, nz = select(under, 0.0, nx), select(under, -1.0, nz)
            beyond = select(under, index_below, 1.0)
            ratio = select(inside, index / beyond, beyond / index)
            approach = select(under, -dz, dx * nx + dz * nz)
            size = magnitude(approach)
            reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
            number, _, aft = next_two(key0, key1, path0, path1, stream, draw, spare, has)
            draw, spare, has = take(draw, spare, has, aft, meets, none)
            mirrored = number < reflectance
            passed = meets & (mirrored ^ True)
            bend = select(
                mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach
            )
            bend = select(met, bend, 0.0)
            scale = select(passed, ratio, 1.0)
            beneath = select(mirrored, -dz, copy_sign(cos_out, dz))
            dx, dy = scale * dx + bend * nx, scale * dy
            dz = select(under, beneath, scale * dz + bend * nz)
            to_x, to_y, to_z = unit(dx, dy, dz)
            dx, dy, dz = select(met, to_x, dx), select(met, to_y, dy), select(met, to_z, dz)
            down = (under & (mirrored ^ inside)) | (free & ((dz > 0.0) ^ True) & (inside ^ True))
            inside = inside ^ passed
            hits = select(done, hits + 1, hits)
            lost = astray | (done & (hits > MOST_HITS))
            left = (free & (grounded ^ True)) | (under & down)
            ended = lost | left
            begins = done & (ended ^ True)
            fresh, enters = fresh & (done ^ True), enters & (done ^ True)
            started, goes = start_section(section, width, low, high, x, z, dx, dz, begins)
            walk = choose_section(begins, started, walk)
            stays = select(begins, goes ^ True, stays)
            walking = walking | goes
        store(numbers, X, x)
        store(numbers, Y, y)
        store(numbers, Z, z)
        store(numbers, DX, dx)
        store(numbers, DY, dy)
        store(numbers, DZ, dz)
        store(numbers, _BASE_X, base_x)
        store(wholes, _FRESH, select(fresh, 1, 0))
        store(wholes, _ENTERS, select(enters, 1, 0))
        store(wholes, _HITS, hits)
        store(wholes, _DRAW, draw)
        store(wholes, _SPARE, spare)
        store(wholes, _HAS, select(has, 1, 0))
        leaving, downward, strayed = bits(ended), bits(down), bits(lost)
        for lane in range(LANES):
            if (leaving >> lane) & 1:
                _give(place, rng, lane, numbers, wholes)
                sign = 1
                if (downward >> lane) & 1:
                    sign = -1
                if (strayed >> lane) & 1:
                    sign = 0
                way[wholes[_RAY * LANES + lane]] = sign
                following = _take(
                    tile, offset, rays, following, place, up, rng, lane, numbers, wholes
                )


@kernel
def _take(tile, offset, rays, following, place, up, rng, lane, numbers, wholes):
    """Put the queue's next ray into a lane, or empty it; return the number of the one after."""
    if following == len(rays):
        wholes[_RAY * LANES + lane] = _EMPTY
        return following
    ray = rays[following]
    x, y = place[ray, X], place[ray, Y]
    base_x = math.floor((x - offset) / tile.width) * tile.width + offset
    base_y = math.floor(y / tile.length) * tile.length
    upward = up[ray] != 0
    numbers[X * LANES + lane] = min(max(x - base_x, 0.0), tile.width)
    numbers[Y * LANES + lane] = min(max(y - base_y, 0.0), tile.length)
    numbers[Z * LANES + lane] = 0.0 if upward else tile.high
    for i in range(DX, DZ + 1):
        numbers[i * LANES + lane] = place[ray, i]
    numbers[_BASE_X * LANES + lane] = base_x
    numbers[_BASE_Y * LANES + lane] = base_y
    wholes[_FRESH * LANES + lane] = 1
    wholes[_ENTERS * LANES + lane] = 1 if upward and tile.underside else 0
    wholes[_HITS * LANES + lane] = 0
    wholes[_DRAW * LANES + lane] = rng[ray, BLOCK]
    wholes[_SPARE * LANES + lane] = rng[ray, SPARE]
    wholes[_HAS * LANES + lane] = rng[ray, HAS_SPARE]
    wholes[_PATH0 * LANES + lane] = rng[ray, PATH0]
    wholes[_PATH1 * LANES + lane] = rng[ray, PATH1]
    wholes[_RAY * LANES + lane] = ray
    return following + 1


@kernel
def _give(place, rng, lane, numbers, wholes):
    """Write a lane's ray back to where it came from."""
    ray = wholes[_RAY * LANES + lane]
    place[ray, X] = numbers[X * LANES + lane] + numbers[_BASE_X * LANES + lane]
    place[ray, Y] = numbers[Y * LANES + lane] + numbers[_BASE_Y * LANES + lane]
    for i in range(DX, DZ + 1):
        place[ray, i] = numbers[i * LANES + lane]
    rng[ray, BLOCK] = uint64(wholes[_DRAW * LANES + lane])
    rng[ray, SPARE] = uint64(wholes[_SPARE * LANES + lane])
    rng[ray, HAS_SPARE] = uint64(wholes[_HAS * LANES + lane])
