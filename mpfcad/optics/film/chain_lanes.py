"""Passages of many rays through an extruded film, sixteen at a time.

The same physics as `film.film_passage`, ray by ray the same. Rays that come from below pass the
underside first. Then they go through the film in lanes: one that has left makes room for the next.
In one round each ray tries one run of the chain, passes or reflects at the segment it meets there,
and does the same at the underside if nothing else is in its way down.
"""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import WIDE, any_of, bits, floor, real, select, spread_wide
from mpfcad.optics.base.lanes_array import (
    gather_half,
    gather_line,
    load_from,
    put,
    scatter_half,
    scatter_line,
)
from mpfcad.optics.base.sampling_lanes import next_one, take_one
from mpfcad.optics.film.interface_lanes import pass_facet, pass_underside
from mpfcad.optics.film.queue import fill_lanes, get_ready, next_eight
from mpfcad.optics.search.chain_walk import leave_run, meet_in_run, next_run, run_data, zone_entry

#: Columns of a ray's place: x, y, z [mm], the direction, two that are free.
PLACE_SIZE = 8
_MOST_ROUNDS = 200_000


@kernel
def film_passages(tile, index, index_below, offset, rays, place, way, rng, lane_row, waiting):
    """Follow rays through a film of an extruded tile until they leave it.

    rays (n,) int64: the rows of place (m, 8) float64 [mm] and rng (m, 8) uint64 that hold the rays,
    not the last ones; place is moved on and `way` (…,) int64 gets 1, -1 or 0 as in `film_passage`.
    lane_row (16,) and waiting (48,) int64 are scratch.
    """
    if len(rays) == 0:
        return
    chain, width, low, high = tile.chain, tile.width, tile.low, tile.high
    none = len(place) - 1
    for i in range(WIDE):
        waiting[i] = none
    following, ready, row = 0, 0, spread_wide(none)
    ended = row == row
    no = ended ^ ended
    inside, amid, fresh = no, no, no
    rounds = row ^ row
    base, run, k = real(rounds), real(rounds), real(rounds)
    while True:
        while ready < WIDE and following < len(rays):
            count, following, ready = next_eight(rays, following, place, ready, lane_row, waiting)
            if count > 0:
                left = bits(enter(index, index_below, place, rng, load_from(lane_row, 0)))
                ready = get_ready(left, count, ready, way, lane_row, waiting)
        row, ready = fill_lanes(ended, row, ready, waiting)
        live = row < none
        if not any_of(live):
            return
        x, y, z, dx, dy, dz, _, _ = gather_line(place, row)
        stream, draw, spare, unused = gather_half(rng, row)
        has = unused != 0
        home, local = within_tile(x, offset, width)
        x, base = select(ended, local, x), select(ended, home, base)
        rises, old = (dz < 0.0) ^ True, ended ^ True
        z = select(ended, select(rises, 0.0, high), z)
        inside, amid, fresh = (inside & old) | (ended & rises), amid & old, (fresh & old) | ended
        rounds = select(ended, 0, rounds)
        ended, down, lost = no, no, no
        while not any_of(ended):
            if any_of(fresh):
                first, shift = zone_entry(chain, width, select(inside, low, high), x, z, dx, dz)
                shift = select(fresh, shift, 0.0)
                x, base = x - shift, base + shift
                run = select(fresh, first, run)
            ends = run_data(chain, run)
            met, k, distance, x, z, slope, nz, against = meet_in_run(
                ends, chain.segment, x, z, dx, dz, k, amid, inside, live, False
            )
            y = y + distance * dy
            number, aft = next_one(rng, row, stream, draw, spare, has, met)
            draw, spare, has = take_one(draw, spare, has, aft, met)
            dx, dy, dz, passed = pass_facet(
                index, number, slope, nz, against, dx, dy, dz, met, inside
            )
            inside = inside ^ passed
            # What is ahead: the same run, the next one, or free flight.
            level = select(inside, low, high)
            gone, amid = leave_run(ends, level, x, z, dx, dz, k, met, inside)
            gone, amid = gone & live, amid & live
            on = live & ((gone | amid) ^ True)
            ahead, at, turn = next_run(chain, width, run, x, dx)
            run, x = select(on, ahead, run), select(on, at, x)
            base = base + select(on, turn, 0.0)
            fresh, down = gone & inside, no
            if any_of(gone):
                flight = select(gone, (select(inside, 0.0, high) - z) / dz, 0.0)
                flight = select(flight > 0.0, flight, 0.0)
                x, y = x + flight * dx, y + flight * dy
            if any_of(fresh):
                z = select(fresh, 0.0, z)
                number, aft = next_one(rng, row, stream, draw, spare, has, fresh)
                draw, spare, has = take_one(draw, spare, has, aft, fresh)
                dx, dy, dz, mirrored = pass_underside(
                    index / index_below, number, dx, dy, dz, fresh
                )
                down = fresh & (mirrored ^ True)
                fresh = fresh & mirrored
            rounds = rounds + 1
            lost = live & (rounds > _MOST_ROUNDS)
            ended = (gone & (fresh ^ True)) | lost
        scatter_line(place, row, select(ended, x + base, x), y, z, dx, dy, dz, x, x)
        scatter_half(rng, row, stream, draw, spare, select(has, 1, 0))
        put(way, row, select(lost, 0, select(down, -1, 1)))
        ended = ended | (live ^ True)


@kernel
def within_tile(x, offset, width):
    """Return where the tile begins that rays [mm] come to, and their x within it."""
    home = select(x == x, offset, x)
    local = x - home
    if any_of(((local >= 0.0) & (local < width)) ^ True):
        home = floor(local / width) * width + offset
        local = x - home
    return home, select(local > 0.0, select(local < width, local, width), 0.0)


@kernel
def enter(index, index_below, place, rng, row):
    """Let eight rays from below pass or reflect at the underside; return which have left there."""
    x, y, z, dx, dy, dz, _, _ = gather_line(place, row)
    stream, draw, spare, unused = gather_half(rng, row)
    has, every = unused != 0, row < len(place) - 1
    number, aft = next_one(rng, row, stream, draw, spare, has, every)
    draw, spare, has = take_one(draw, spare, has, aft, every)
    dx, dy, dz, mirrored = pass_underside(index_below / index, number, dx, dy, dz, every)
    scatter_line(place, row, x, y, z, dx, dy, dz, x, x)
    scatter_half(rng, row, stream, draw, spare, select(has, 1, 0))
    return mirrored
