"""Passages of many rays through an extruded film, eight at a time.

The same physics as `film.film_passage`, ray by ray the same: a ray that has left the film makes
room in its lane for the next of the queue.
"""

import math

from numba import uint64

from mpfcad.optics.chain import chain_hit
from mpfcad.optics.fresnel import fresnel
from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import (
    LANES,
    any_of,
    bits,
    copy_sign,
    floor,
    magnitude,
    real,
    select,
    spread,
)
from mpfcad.optics.lanes_array import load, store
from mpfcad.optics.sampling import (
    BLOCK,
    HAS_SPARE,
    KEY0,
    KEY1,
    PATH0,
    PATH1,
    SPARE,
    STREAM,
    net_number,
    philox4x32,
)

# Columns of a ray's place and way.
X, Y, Z, DX, DY, DZ = range(6)
WAY = 0
# Rows of the lanes' scratch.
_BASE = 6
_SEGMENT, _INSIDE, _HITS, _DRAW, _SPARE, _HAS, _PATH0, _PATH1, _RAY = range(9)
FLOAT_ROWS, WHOLE_ROWS = 7, 9
_ENTERING = -3
_EMPTY = -1
_MOST_HITS = 100_000


@kernel
def film_passages(
    tile, index, index_below, offset, rays, place, up, way, rng, lane_float, lane_whole
):
    """Follow rays through a film of an extruded tile until they leave it.

    rays (n,) int64: the rows of place (…, 6) float64 [mm], up (…,) int64, rng (…, 8) uint64 that
    hold the rays; place is moved on and `way` (…,) int64 gets 1, -1 or 0 as in `film_passage`.
    lane_float (7, 8) float64 and lane_whole (9, 8) int64 are scratch.
    """
    if len(rays) == 0:
        return
    chain, width, low, high = tile.chain, tile.width, tile.low, tile.high
    key0, key1 = rng[rays[0], KEY0], rng[rays[0], KEY1]
    stream = spread(rng[rays[0], STREAM])
    following = 0
    for lane in range(LANES):
        following = _take(
            width, high, offset, rays, following, place, up, rng, lane, lane_float, lane_whole
        )
    while True:
        x, y, z = load(lane_float, X), load(lane_float, Y), load(lane_float, Z)
        dx, dy, dz = load(lane_float, DX), load(lane_float, DY), load(lane_float, DZ)
        base = load(lane_float, _BASE)
        k, hits = load(lane_whole, _SEGMENT), load(lane_whole, _HITS)
        inside = load(lane_whole, _INSIDE) != 0
        draw, spare = load(lane_whole, _DRAW), load(lane_whole, _SPARE)
        has = load(lane_whole, _HAS) != 0
        path0, path1 = load(lane_whole, _PATH0), load(lane_whole, _PATH1)
        live = load(lane_whole, _RAY) >= 0
        if not any_of(live):
            return
        ended = live ^ live
        while not any_of(ended):
            entering = k == _ENTERING
            k, distance, x, z, shift, nx, nz = chain_hit(
                chain, width, low, high, x, z, dx, dz, k, inside, live & (entering ^ True)
            )
            base = base + shift
            y = y + distance * dy
            # Past the last facet: flight to the top of the film, or to its underside.
            free = live & (k == -1)
            flight = select(free, (select(inside, 0.0, high) - z) / dz, 0.0)
            flight = select(flight > 0.0, flight, 0.0)
            x, y = x + flight * dx, y + flight * dy
            z = select(free & inside, 0.0, z)
            turn = select(free & inside, floor(x / width) * width, 0.0)
            x, base = x - turn, base + turn
            under = entering | (free & inside)
            meets = live & (under | (k >= 0))
            # One interface for facets and underside.
            nx, nz = select(under, 0.0, nx), select(under, -1.0, nz)
            beyond = select(under, index_below, 1.0)
            ratio = select(inside, index / beyond, beyond / index)
            approach = dx * nx + dz * nz
            size = magnitude(approach)
            reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
            a, b, c, d = philox4x32(draw, stream, path0, path1, key0, key1)
            drawn = select(has, spare, (a << 32) | b)
            netted = draw < 0
            if any_of(live & netted):
                drawn = select(netted, net_number(spare, draw), drawn)
            number = real(drawn >> 11) * 2.0**-53
            spare = select(has | netted, spare, (c << 32) | d)
            draw = select(meets & (has ^ True), draw + 1, draw)
            has = has ^ (meets & (netted ^ True))
            mirrored = number < reflectance
            bend = select(
                mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach
            )
            bend = select(meets, bend, 0.0)
            scale = select(meets & (mirrored ^ True), ratio, 1.0)
            dx, dy, dz = scale * dx + bend * nx, scale * dy, scale * dz + bend * nz
            down = under & (mirrored ^ inside)
            inside = inside ^ (meets & (mirrored ^ True))
            k = select(under, -1, k)
            hits = hits + 1
            lost = live & ((k == -2) | (hits > _MOST_HITS))
            ended = live & (down | lost | (free & (under ^ True)))
        store(lane_float, X, x)
        store(lane_float, Y, y)
        store(lane_float, Z, z)
        store(lane_float, DX, dx)
        store(lane_float, DY, dy)
        store(lane_float, DZ, dz)
        store(lane_float, _BASE, base)
        store(lane_whole, _SEGMENT, k)
        store(lane_whole, _INSIDE, select(inside, 1, 0))
        store(lane_whole, _HITS, hits)
        store(lane_whole, _DRAW, draw)
        store(lane_whole, _SPARE, spare)
        store(lane_whole, _HAS, select(has, 1, 0))
        left = bits(ended)
        downward, astray = bits(down), bits(lost)
        for lane in range(LANES):
            if (left >> lane) & 1:
                _give(place, rng, lane, lane_float, lane_whole)
                sign = 1
                if (downward >> lane) & 1:
                    sign = -1
                if (astray >> lane) & 1:
                    sign = 0
                way[lane_whole[_RAY, lane]] = sign
                following = _take(
                    width, high, offset, rays, following, place, up, rng, lane, lane_float,
                    lane_whole,
                )  # fmt: skip


@kernel
def _take(width, high, offset, rays, following, place, up, rng, lane, lane_float, lane_whole):
    """Put the queue's next ray into a lane, or empty it; return the number of the one after."""
    if following == len(rays):
        lane_whole[_RAY, lane] = _EMPTY
        return following
    ray = rays[following]
    x = place[ray, X]
    base = math.floor((x - offset) / width) * width + offset
    lane_float[X, lane] = min(max(x - base, 0.0), width)
    lane_float[_BASE, lane] = base
    upward = up[ray] != 0
    lane_float[Y, lane] = place[ray, Y]
    lane_float[Z, lane] = 0.0 if upward else high
    for i in range(DX, DZ + 1):
        lane_float[i, lane] = place[ray, i]
    lane_whole[_SEGMENT, lane] = _ENTERING if upward else -1
    lane_whole[_INSIDE, lane] = 0
    lane_whole[_HITS, lane] = 0
    lane_whole[_DRAW, lane] = rng[ray, BLOCK]
    lane_whole[_SPARE, lane] = rng[ray, SPARE]
    lane_whole[_HAS, lane] = rng[ray, HAS_SPARE]
    lane_whole[_PATH0, lane] = rng[ray, PATH0]
    lane_whole[_PATH1, lane] = rng[ray, PATH1]
    lane_whole[_RAY, lane] = ray
    return following + 1


@kernel
def _give(place, rng, lane, lane_float, lane_whole):
    """Write a lane's ray back to where it came from."""
    ray = lane_whole[_RAY, lane]
    place[ray, X] = lane_float[X, lane] + lane_float[_BASE, lane]
    place[ray, Y] = lane_float[Y, lane]
    for i in range(DX, DZ + 1):
        place[ray, i] = lane_float[i, lane]
    rng[ray, BLOCK] = uint64(lane_whole[_DRAW, lane])
    rng[ray, SPARE] = uint64(lane_whole[_SPARE, lane])
    rng[ray, HAS_SPARE] = uint64(lane_whole[_HAS, lane])
