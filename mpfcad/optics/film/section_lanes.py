"""Passages of many rays through an extruded film of any cross-section, eight at a time.

The same physics as `film.film_passage`, ray by ray the same, and the same ways of lanes as in
`chain_lanes`: in one round each ray tries one part of the section's layers, passes or reflects at
the segment it meets there, and does the same at a flat underside if nothing else is in its way.
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
from mpfcad.optics.film.chain_lanes import take_ray
from mpfcad.optics.film.interface import unit
from mpfcad.optics.search.chain_walk import leave_run, meet_in_run
from mpfcad.optics.search.layers_walk import layers_entry, next_part, part_across, part_data

#: Rounds after which a ray counts as lost; some are guided over thousands of strips.
_MOST_ROUNDS = 20_000_000


@kernel
def section_passages(
    tile, index, index_below, offset, rays, place, way, rng, lane_place, lane_rng, lane_ray
):
    """Follow rays through a film until they leave it, as `chain_lanes.film_passages` does."""
    if len(rays) == 0:
        return
    layers, width, low, high = tile.layers, tile.width, tile.low, tile.high
    lean = layers.lean[0]
    key0, key1 = spread(rng[rays[0], KEY0]), spread(rng[rays[0], KEY1])
    stream = spread(rng[rays[0], STREAM])
    following = 0
    for lane in range(LANES):
        following = take_ray(rays, following, place, rng, lane, lane_place, lane_rng, lane_ray)
    live = load(lane_ray, 0) >= 0
    began, no = live, live ^ live
    inside, amid, fresh, both = no, no, no, no
    base, part, k, limit = spread(0.0), spread(0.0), spread(0.0), spread(float("inf"))
    rounds = spread(0)
    while any_of(live):
        # x is leaned, dx is not.
        x, y, z, dx, dy, dz, _, _ = load_lines(lane_place)
        _, _, path0, path1, _, draw, spare, unused = load_lines(lane_rng)
        has = unused != 0
        home = floor((x - offset) / width) * width + offset
        base = select(began, home, base)
        local = x - home
        local = select(local > 0.0, select(local < width, local, width), 0.0)
        rises = (dz < 0.0) ^ True
        z = select(began, select(rises, 0.0, high), z)
        x = select(began, local + lean * z, x)
        entering = began & rises if tile.underside else no
        old = began ^ True
        inside, amid, both = inside & old, amid & old, both & old
        fresh = (fresh & old) | (began ^ entering)
        limit = select(old, limit, float("inf"))
        rounds = select(began, 0, rounds)
        ended = no
        while not any_of(ended):
            upward = dz > 0.0
            along = dx + lean * dz
            if any_of(fresh):
                first, shift = layers_entry(
                    layers, width, select(upward, low, high), upward, x, z, along, dz
                )
                shift = select(fresh, shift, 0.0)
                x, base = x - shift, base + shift
                part = select(fresh, first, part)
            looking = live & (entering ^ True)
            ends, lower, upper, turn, hill, below, above = part_data(layers, part)
            under = inside ^ hill
            other, apart, body = part_across(under, lower, upper, turn, below, above, z, dz)
            both = both & (apart ^ True)
            met, at, distance, hit, hit_z, slope, nz, against = meet_in_run(
                ends, layers.segment, x, turn * z, along, turn * dz, k, amid, under, looking, True
            )
            first_of_two = met & both & body
            met = met & (first_of_two ^ True) & (distance <= limit)
            k = select(met, at, k)
            x, z = select(met, hit, x), select(met, turn * hit_z, z)
            y = y + select(met, distance, 0.0) * dy
            number, second, aft = next_two(key0, key1, path0, path1, stream, draw, spare, has)
            if any_of(met):
                approach = against * nz
                size = magnitude(approach)
                ratio = select(inside, index, 1.0 / index)
                reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
                mirrored = number < reflectance
                bend = select(
                    mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach
                )
                bend = bend * nz
                passed = met & (mirrored ^ True)
                scale = select(mirrored, 1.0, ratio)
                to_x, to_y, to_z = unit(
                    scale * dx - bend * slope, scale * dy, scale * dz + bend * (turn - lean * slope)
                )
                dx, dy, dz = select(met, to_x, dx), select(met, to_y, dy), select(met, to_z, dz)
                along = dx + lean * dz
                inside = inside ^ passed
            # What is ahead: the same part, the one across, the next strip, or free flight.
            under = inside ^ hill
            other, apart, _ = part_across(under, lower, upper, turn, below, above, z, dz)
            level = select(under, lower, upper)
            gone, amid = leave_run(ends, level, x, turn * z, along, turn * dz, k, met, under)
            gone = gone & looking & (other < 0.0)
            amid = amid & looking
            on = looking & ((gone | amid) ^ True)
            waits = limit < float("inf")
            across = on & (select(met, apart ^ True, both) | waits)
            limit = select(first_of_two, distance, float("inf"))
            aside = on & (across ^ True)
            upward = dz > 0.0
            ahead, shift, free = next_part(
                layers, ends, select(upward, high, low), part, under, x, z, along, dz
            )
            gone = gone | (aside & free)
            part = select(aside, ahead, select(across, other, part))
            shift = select(aside, shift, 0.0)
            x, base = x - shift, base + shift
            both = aside | (amid & met)
            flight = select(gone, (select(inside | (dz < 0.0), 0.0, high) - z) / dz, 0.0)
            flight = select(flight > 0.0, flight, 0.0)
            x, y = x + flight * along, y + flight * dy
            # The underside, from within or (entering) from below.
            grounded = entering | (gone & inside)
            z = select(grounded, 0.0, z)
            out = gone & (grounded ^ True)
            down = out & (dz < 0.0)
            if any_of(grounded):
                number = select(met, second, number)
                ratio = select(inside, index / index_below, index_below / index)
                size = magnitude(dz)
                reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
                mirrored = number < reflectance
                passed = grounded & (mirrored ^ True)
                scale = select(passed, ratio, 1.0)
                dx, dy = scale * dx, scale * dy
                dz = select(grounded, select(mirrored, -dz, copy_sign(cos_out, dz)), dz)
                down = down | (grounded & (mirrored ^ inside))
                inside = inside ^ passed
            fresh, entering = grounded & (down ^ True), no
            # Each meeting has taken a number.
            draw, spare, has = take(draw, spare, has, aft, met ^ grounded, met & grounded)
            rounds = rounds + 1
            lost = live & (rounds > _MOST_ROUNDS)
            ended = down | lost | out
        upright = select(down, 0.0, lean * high)
        store_lines(lane_place, select(ended, x + base - upright, x), y, z, dx, dy, dz, x, x)
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
