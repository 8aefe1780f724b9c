"""Passages of many rays through an extruded film, eight at a time.

The same physics as `film.film_passage`, ray by ray the same: a ray that has left the film makes
room in its lane for the next of the queue. In one round each ray tries one run of the chain, passes
or reflects at the segment it meets there, and does the same at the underside if nothing else is
in its way down.
"""

from numba import uint64

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import (
    LANES,
    any_of,
    bits,
    copy_sign,
    floor,
    lowest_bit,
    magnitude,
    select,
    spread,
)
from mpfcad.optics.base.lanes_array import load, load_lines, store, store_lines
from mpfcad.optics.base.sampling import KEY0, KEY1, STREAM
from mpfcad.optics.base.sampling_lanes import next_two, take
from mpfcad.optics.search.chain_walk import leave_run, meet_in_run, next_run, run_data, zone_entry

#: Columns of a ray's place: x, y, z [mm], the direction, two that are free.
PLACE_SIZE = 8
_EMPTY = -1
_MOST_ROUNDS = 200_000


@kernel
def film_passages(
    tile, index, index_below, offset, rays, place, way, rng, lane_place, lane_rng, lane_ray
):
    """Follow rays through a film of an extruded tile until they leave it.

    rays (n,) int64: the rows of place (…, 8) float64 [mm] and rng (…, 8) uint64 that hold the rays;
    place is moved on and `way` (…,) int64 gets 1, -1 or 0 as in `film_passage`. lane_place (8, 8)
    float64, lane_rng (8, 8) uint64 and lane_ray (1, 8) int64 are scratch.
    """
    if len(rays) == 0:
        return
    chain, width, low, high = tile.chain, tile.width, tile.low, tile.high
    key0, key1 = spread(rng[rays[0], KEY0]), spread(rng[rays[0], KEY1])
    stream = spread(rng[rays[0], STREAM])
    following = 0
    for lane in range(LANES):
        following = take_ray(rays, following, place, rng, lane, lane_place, lane_rng, lane_ray)
    live = load(lane_ray, 0) >= 0
    began, no = live, live ^ live
    inside, amid, fresh = no, no, no
    base, run, k = spread(0.0), spread(0.0), spread(0.0)
    rounds = spread(0)
    while any_of(live):
        x, y, z, dx, dy, dz, _, _ = load_lines(lane_place)
        _, _, path0, path1, _, draw, spare, unused = load_lines(lane_rng)
        has = unused != 0
        home = floor((x - offset) / width) * width + offset
        base = select(began, home, base)
        local = x - home
        local = select(local > 0.0, select(local < width, local, width), 0.0)
        x = select(began, local, x)
        entering = began & ((dz < 0.0) ^ True)
        z = select(began, select(entering, 0.0, high), z)
        old = began ^ True
        inside, amid = inside & old, amid & old
        fresh = (fresh & old) | (began ^ entering)
        rounds = select(began, 0, rounds)
        ended = no
        while not any_of(ended):
            first, shift = zone_entry(chain, width, select(inside, low, high), x, z, dx, dz)
            shift = select(fresh, shift, 0.0)
            x, base = x - shift, base + shift
            run = select(fresh, first, run)
            looking = live & (entering ^ True)
            ends = run_data(chain, run)
            met, k, distance, x, z, slope, nz, against = meet_in_run(
                ends, chain.segment, x, z, dx, dz, k, amid, inside, looking, False
            )
            y = y + distance * dy
            number, other, aft = next_two(key0, key1, path0, path1, stream, draw, spare, has)
            # The segment met.
            approach = against * nz
            size = magnitude(approach)
            ratio = select(inside, index, 1.0 / index)
            reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
            mirrored = number < reflectance
            bend = select(
                mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach
            )
            bend = select(met, bend * nz, 0.0)
            passed = met & (mirrored ^ True)
            scale = select(passed, ratio, 1.0)
            dx, dy, dz = scale * dx - bend * slope, scale * dy, scale * dz + bend
            inside = inside ^ passed
            # What is ahead: the same run, the next one, or free flight.
            level = select(inside, low, high)
            gone, amid = leave_run(ends, level, x, z, dx, dz, k, met, inside)
            gone, amid = gone & looking, amid & looking
            on = looking & ((gone | amid) ^ True)
            ahead, at, turn = next_run(chain, width, run, x, dx)
            run, x = select(on, ahead, run), select(on, at, x)
            base = base + select(on, turn, 0.0)
            flight = select(gone, (select(inside, 0.0, high) - z) / dz, 0.0)
            flight = select(flight > 0.0, flight, 0.0)
            x, y = x + flight * dx, y + flight * dy
            # The underside, from within or (entering) from below.
            under = entering | (gone & inside)
            z = select(under, 0.0, z)
            number = select(met, other, number)
            ratio = select(inside, index / index_below, index_below / index)
            size = magnitude(dz)
            reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
            mirrored = number < reflectance
            passed = under & (mirrored ^ True)
            scale = select(passed, ratio, 1.0)
            dx, dy = scale * dx, scale * dy
            dz = select(under, select(mirrored, -dz, copy_sign(cos_out, dz)), dz)
            down = under & (mirrored ^ inside)
            inside = inside ^ passed
            fresh, entering = under & (down ^ True), no
            # Each meeting has taken a number.
            draw, spare, has = take(draw, spare, has, aft, met ^ under, met & under)
            rounds = rounds + 1
            lost = live & (rounds > _MOST_ROUNDS)
            ended = down | lost | (gone & (under ^ True))
        store_lines(lane_place, select(ended, x + base, x), y, z, dx, dy, dz, x, x)
        unused = select(has, 1, 0)
        store_lines(lane_rng, key0, key1, path0, path1, stream, draw, spare, unused)
        left, downward, astray = bits(ended), bits(down), bits(lost)
        while left:
            lane = lowest_bit(left)
            left &= left - 1
            ray = uint64(lane_ray[0, uint64(lane)])
            store(place, ray, load(lane_place, lane))
            store(rng, ray, load(lane_rng, lane))
            sign = -1 if (downward >> lane) & 1 else 1
            way[ray] = 0 if (astray >> lane) & 1 else sign
            following = take_ray(rays, following, place, rng, lane, lane_place, lane_rng, lane_ray)
        live = load(lane_ray, 0) >= 0
        began = ended & live


@kernel
def take_ray(rays, following, place, rng, lane, lane_place, lane_rng, lane_ray):
    """Put the queue's next ray into a lane, or empty it; return the number of the one after."""
    if following == len(rays):
        lane_ray[0, uint64(lane)] = _EMPTY
        return following
    ray = rays[uint64(following)]
    store(lane_place, lane, load(place, ray))
    store(lane_rng, lane, load(rng, ray))
    lane_ray[0, uint64(lane)] = ray
    return following + 1
