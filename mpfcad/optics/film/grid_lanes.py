"""Passages of many rays through a field of small cells, eight at a time.

The same physics as `film.film_passage`, ray by ray the same. Rays walk over their grid a cell a
step, all lanes at once; when half of them have arrived somewhere, those pass or reflect there and
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
    magnitude,
    select,
    spread,
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
from mpfcad.optics.film.interface import unit
from mpfcad.optics.search.grid.walk import choose, no_walk, start_walk, walk_on
from mpfcad.optics.search.tiling import MOST_TILES, arrive, into_tile, rounding, to_zone

# Columns of a ray's place and first rows of the lanes' scratch.
X, Y, Z, DX, DY, DZ = range(6)
# Further rows.
_BASE_X, _BASE_Y = 6, 7
_STATE, _INSIDE, _HITS, _DRAW, _SPARE, _HAS, _PATH0, _PATH1, _RAY = range(9)
_ON_WAY, _FROM_ABOVE, _FROM_BELOW = range(3)
_NUMBERS, _WHOLES = 8 * LANES, 9 * LANES
_EMPTY = -1
#: So many rays wait for each other before they are passed on.
_TOGETHER = 4


@kernel
def grid_passages(tile, index, index_below, offset, rays, place, up, way, rng):
    """Follow rays through a film until they leave it, as `film_lanes.film_passages` does."""
    if len(rays) == 0:
        return
    grid, size, low, high = tile.grid, (tile.width, tile.length), tile.low, tile.high
    slack = rounding(size, high)
    key0, key1 = rng[rays[0], KEY0], rng[rays[0], KEY1]
    stream = spread(rng[rays[0], STREAM])
    numbers, wholes = local_floats(_NUMBERS), local_wholes(_WHOLES)
    following = 0
    for lane in range(LANES):
        following = _take(
            size, high, offset, rays, following, place, up, rng, lane, numbers, wholes
        )
    none = load(numbers, X) < load(numbers, X)
    walking = none
    walk = no_walk(spread(0.0), spread(-1), none)
    while True:
        x, y, z = load(numbers, X), load(numbers, Y), load(numbers, Z)
        dx, dy, dz = load(numbers, DX), load(numbers, DY), load(numbers, DZ)
        base_x, base_y = load(numbers, _BASE_X), load(numbers, _BASE_Y)
        state, hits = load(wholes, _STATE), load(wholes, _HITS)
        inside = load(wholes, _INSIDE) != 0
        draw, spare = load(wholes, _DRAW), load(wholes, _SPARE)
        has = load(wholes, _HAS) != 0
        path0, path1 = load(wholes, _PATH0), load(wholes, _PATH1)
        live = load(wholes, _RAY) >= 0
        total = count_of(live)
        if total == 0:
            return
        most_walking = total - min(_TOGETHER, total)
        ended, down, lost = none, none, none
        while bits(ended) == 0:
            side = select(inside, 1.0, -1.0)
            while count_of(walking) > most_walking:
                walk, walking = walk_on(grid, walk, x, y, z, dx, dy, dz, side, slack, walking)
            done = live & (walking ^ True)
            arrived = done & (state == _ON_WAY)
            ways = walk.to_x, walk.to_y, walk.edge, walk.leave
            met, turning, x, y, z, shift_x, shift_y = arrive(
                size, ways, walk.place >= 0, walk.best, x, y, z, dx, dy, dz, arrived
            )
            # Past the last facet: flight to the top of the film, or to its underside.
            free = arrived & ((met | turning) ^ True)
            astray = free & ((inside ^ (dz > 0.0)) ^ True)
            free = free & (astray ^ True)
            flight = select(free, (select(inside, 0.0, high) - z) / dz, 0.0)
            flight = select(flight > 0.0, flight, 0.0)
            x, y = x + flight * dx, y + flight * dy
            grounded = free & inside
            z = select(grounded, 0.0, z)
            _, nx, ny, nz = gather_row(grid.corner, select(met, walk.place, 0) * 3 + 2)
            under = (done & (state == _FROM_BELOW)) | grounded
            meets = under | met
            # One interface for facets and underside.
            nx, ny, nz = select(under, 0.0, nx), select(under, 0.0, ny), select(under, -1.0, nz)
            beyond = select(under, index_below, 1.0)
            ratio = select(inside, index / beyond, beyond / index)
            approach = dx * nx + dy * ny + dz * nz
            width = magnitude(approach)
            reflectance, cos_out = fresnel(select(width < 1.0, width, 1.0), ratio)
            number, _, aft = next_two(key0, key1, path0, path1, stream, draw, spare, has)
            draw, spare, has = take(draw, spare, has, aft, meets, none)
            mirrored = number < reflectance
            bend = select(
                mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach
            )
            bend = select(meets, bend, 0.0)
            scale = select(meets & (mirrored ^ True), ratio, 1.0)
            dx, dy, dz = scale * dx + bend * nx, scale * dy + bend * ny, scale * dz + bend * nz
            at_x, at_y, at_z = unit(dx, dy, dz)
            dx, dy, dz = select(met, at_x, dx), select(met, at_y, dy), select(met, at_z, dz)
            down = under & (mirrored ^ inside)
            inside = inside ^ (meets & (mirrored ^ True))
            hits = select(done, hits + 1, hits)
            lost = astray | (done & (hits > MOST_TILES))
            ended = down | lost | (free & (grounded ^ True))
            # On to the next way, or over the next tile.
            begins = done & (ended ^ True)
            state = select(begins, _ON_WAY, state)
            at_x, at_y, at_z = to_zone(
                low, high, x, y, z, dx, dy, dz, inside, begins & (turning ^ True)
            )
            x, y, z = select(begins, at_x, x), select(begins, at_y, y), select(begins, at_z, z)
            turn = select(begins, into_tile(size[0], x), 0.0)
            x, base_x = x - turn, base_x + turn + shift_x
            turn = select(begins, into_tile(size[1], y), 0.0)
            y, base_y = y - turn, base_y + turn + shift_y
            started = start_walk(grid, size, low, high, x, y, z, dx, dy, dz)
            walk = choose(begins, started, walk)
            walking = walking | begins
        store(numbers, X, x)
        store(numbers, Y, y)
        store(numbers, Z, z)
        store(numbers, DX, dx)
        store(numbers, DY, dy)
        store(numbers, DZ, dz)
        store(numbers, _BASE_X, base_x)
        store(numbers, _BASE_Y, base_y)
        store(wholes, _STATE, state)
        store(wholes, _INSIDE, select(inside, 1, 0))
        store(wholes, _HITS, hits)
        store(wholes, _DRAW, draw)
        store(wholes, _SPARE, spare)
        store(wholes, _HAS, select(has, 1, 0))
        left, downward, astray = bits(ended), bits(down), bits(lost)
        for lane in range(LANES):
            if (left >> lane) & 1:
                _give(place, rng, lane, numbers, wholes)
                sign = 1
                if (downward >> lane) & 1:
                    sign = -1
                if (astray >> lane) & 1:
                    sign = 0
                way[wholes[_RAY * LANES + lane]] = sign
                following = _take(
                    size, high, offset, rays, following, place, up, rng, lane, numbers, wholes
                )


@kernel
def _take(size, high, offset, rays, following, place, up, rng, lane, numbers, wholes):
    """Put the queue's next ray into a lane, or empty it; return the number of the one after."""
    if following == len(rays):
        wholes[_RAY * LANES + lane] = _EMPTY
        return following
    ray = rays[following]
    width, length = size
    x, y = place[ray, X], place[ray, Y]
    base_x = math.floor((x - offset) / width) * width + offset
    base_y = math.floor(y / length) * length
    upward = up[ray] != 0
    numbers[X * LANES + lane] = min(max(x - base_x, 0.0), width)
    numbers[Y * LANES + lane] = min(max(y - base_y, 0.0), length)
    numbers[Z * LANES + lane] = 0.0 if upward else high
    for i in range(DX, DZ + 1):
        numbers[i * LANES + lane] = place[ray, i]
    numbers[_BASE_X * LANES + lane] = base_x
    numbers[_BASE_Y * LANES + lane] = base_y
    wholes[_STATE * LANES + lane] = _FROM_BELOW if upward else _FROM_ABOVE
    wholes[_INSIDE * LANES + lane] = 0
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
