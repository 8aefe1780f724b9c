"""Passages of many rays through an extruded film of any cross-section, sixteen at a time.

The same physics as `film.film_passage`, ray by ray the same, and the same ways of lanes as in
`chain_lanes`: in one round each ray tries one part of the section's layers, and passes or reflects
at the segment it meets there. Without a flat underside rays come to the zone from both sides.
"""

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import (
    WIDE,
    any_of,
    bits,
    copy_sign,
    magnitude,
    real,
    select,
    spread_wide,
)
from mpfcad.optics.base.lanes_array import (
    gather_half,
    gather_line,
    load_from,
    put,
    scatter_half,
    scatter_line,
)
from mpfcad.optics.base.sampling_lanes import next_one, take_one
from mpfcad.optics.film.chain_lanes import enter, within_tile
from mpfcad.optics.film.interface import unit
from mpfcad.optics.film.interface_lanes import pass_underside
from mpfcad.optics.film.queue import fill_lanes, get_ready, next_eight
from mpfcad.optics.search.chain_walk import leave_run, meet_in_run
from mpfcad.optics.search.layers_walk import layers_entry, next_part, part_across, part_data

#: Rounds after which a ray counts as lost; some are guided over thousands of strips.
_MOST_ROUNDS = 20_000_000


@kernel
def section_passages(tile, index, index_below, offset, rays, place, way, rng, lane_row, waiting):
    """Follow rays through a film until they leave it, as `chain_lanes.film_passages` does."""
    if len(rays) == 0:
        return
    layers, width, low, high = tile.layers, tile.width, tile.low, tile.high
    lean = layers.lean[0]
    none = len(place) - 1
    for i in range(WIDE):
        waiting[i] = none
    following, ready, row = 0, 0, spread_wide(none)
    ended = row == row
    no = ended ^ ended
    inside, amid, fresh, banded, both = no, no, no, no, no
    rounds = row ^ row
    base, part, k = real(rounds), real(rounds), real(rounds)
    limit = spread_wide(float("inf"))
    while True:
        while ready < WIDE and following < len(rays):
            count, following, ready = next_eight(rays, following, place, ready, lane_row, waiting)
            if count > 0:
                left = 0
                if tile.underside:
                    left = bits(enter(index, index_below, place, rng, load_from(lane_row, 0)))
                ready = get_ready(left, count, ready, way, lane_row, waiting)
        row, ready = fill_lanes(ended, row, ready, waiting)
        live = row < none
        if not any_of(live):
            return
        # x is leaned, dx is not.
        x, y, z, dx, dy, dz, _, _ = gather_line(place, row)
        stream, draw, spare, unused = gather_half(rng, row)
        has = unused != 0
        home, local = within_tile(x, offset, width)
        rises, old = (dz < 0.0) ^ True, ended ^ True
        z = select(ended, select(rises, 0.0, high), z)
        x, base = select(ended, local + lean * z, x), select(ended, home, base)
        within = ended & rises if tile.underside else no
        inside, amid, fresh, both = (
            (inside & old) | within,
            amid & old,
            (fresh & old) | ended,
            both & old,
        )
        banded = banded & old
        limit = select(ended, float("inf"), limit)
        rounds = select(ended, 0, rounds)
        ended, down, lost = no, no, no
        while not any_of(ended):
            along = dx + lean * dz
            if any_of(fresh):
                first, shift = layers_entry(layers, width, low, high, banded, x, z, along, dz)
                shift = select(fresh, shift, 0.0)
                x, base = x - shift, base + shift
                part = select(fresh, first, part)
            ends, lower, upper, turn, hill, below, above = part_data(layers, part)
            under = inside ^ hill
            other, apart, body = part_across(under, lower, upper, turn, below, above, z, dz)
            both = both & (apart ^ True)
            met, at, distance, hit, hit_z, slope, nz, against = meet_in_run(
                ends, layers.segment, x, turn * z, along, turn * dz, k, amid, under, live, True
            )
            first_of_two = met & both & body
            met = met & (first_of_two ^ True) & (distance <= limit)
            k = select(met, at, k)
            x, z = select(met, hit, x), select(met, turn * hit_z, z)
            y = y + select(met, distance, 0.0) * dy
            if any_of(met):
                number, aft = next_one(rng, row, stream, draw, spare, has, met)
                draw, spare, has = take_one(draw, spare, has, aft, met)
                approach = against * nz
                size = magnitude(approach)
                ratio = select(inside, index, 1.0 / index)
                reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
                mirrored = number < reflectance
                bend = select(
                    mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach
                )
                bend = bend * nz
                scale = select(mirrored, 1.0, ratio)
                to_x, to_y, to_z = unit(
                    scale * dx - bend * slope, scale * dy, scale * dz + bend * (turn - lean * slope)
                )
                dx, dy, dz = select(met, to_x, dx), select(met, to_y, dy), select(met, to_z, dz)
                along = dx + lean * dz
                inside = inside ^ (met & (mirrored ^ True))
            # What is ahead: the same part, the one across, the next strip, or free flight.
            under = inside ^ hill
            other, apart, _ = part_across(under, lower, upper, turn, below, above, z, dz)
            level = select(under, lower, upper)
            gone, amid = leave_run(ends, level, x, turn * z, along, turn * dz, k, met, under)
            gone = gone & live & (other < 0.0)
            amid = amid & live
            on = live & ((gone | amid) ^ True)
            waits = limit < float("inf")
            across = on & (select(met, apart ^ True, both) | waits)
            limit = select(first_of_two, distance, float("inf"))
            aside = on & (across ^ True)
            ahead, shift, free, banded = next_part(
                layers, ends, select(dz > 0.0, high, low), part, under, x, z, along, dz
            )
            gone, banded = gone | (aside & free), banded & aside & (free ^ True)
            part = select(aside, ahead, select(across, other, part))
            shift = select(aside, shift, 0.0)
            x, base = x - shift, base + shift
            both = (aside & (banded ^ True)) | (amid & met)
            fresh, down = gone & inside, gone & (dz < 0.0)
            if any_of(gone):
                flight = select(gone, (select(inside | down, 0.0, high) - z) / dz, 0.0)
                flight = select(flight > 0.0, flight, 0.0)
                x, y = x + flight * along, y + flight * dy
            if any_of(fresh):
                z = select(fresh, 0.0, z)
                number, aft = next_one(rng, row, stream, draw, spare, has, fresh)
                draw, spare, has = take_one(draw, spare, has, aft, fresh)
                dx, dy, dz, mirrored = pass_underside(
                    index / index_below, number, dx, dy, dz, fresh
                )
                inside = inside ^ (fresh & (mirrored ^ True))
                fresh = fresh & mirrored
            grounded, fresh = fresh, fresh | banded
            rounds = rounds + 1
            lost = live & (rounds > _MOST_ROUNDS)
            ended = (gone & (grounded ^ True)) | lost
        x_out = x + base - select(down, 0.0, lean * high)
        scatter_line(place, row, select(ended, x_out, x), y, z, dx, dy, dz, x, x)
        scatter_half(rng, row, stream, draw, spare, select(has, 1, 0))
        put(way, row, select(lost, 0, select(down, -1, 1)))
        ended = ended | (live ^ True)
