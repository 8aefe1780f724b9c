"""Ways of many rays through an endless cavity of lamps, sixteen at a time: those of `passage`."""

import numpy as np

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import WIDE, any_of, root, select, spread_wide
from mpfcad.optics.base.lanes_array import (
    gather,
    gather_first_half,
    gather_half,
    gather_line,
    load_wide,
    scatter_half,
    scatter_line,
)
from mpfcad.optics.base.recorder import FLOW_ELEMENTS, FLOW_LAMPS, FLOW_LOST, FLOW_ROULETTE
from mpfcad.optics.base.roulette import ROULETTE_BELOW
from mpfcad.optics.base.sampling import disk_point, frame
from mpfcad.optics.base.sampling_lanes import next_two, take
from mpfcad.optics.cavity.direct import ALL_COUNTED, NONE_COUNTED, direct_light
from mpfcad.optics.cavity.endless import (
    HEIGHT,
    LAMP_HEIGHT,
    LAMP_LUMINANCE,
    LAMP_PITCH,
    LAMP_POSITION,
    LAMP_RADIUS,
    LAMP_REFLECTANCE,
    NO_LAMP,
    REFLECTANCE,
    SPECULAR_FRACTION,
    lamp_hit,
)
from mpfcad.optics.cavity.glow import glow_at, land
from mpfcad.optics.score.state import settle_lanes
from mpfcad.optics.spectral.hue import look_at, seen

_MOST_MEETINGS = 1_000_000
_FOUND, _LAMPS, _ELEMENT, _ROULETTE, _LOST, _WEIGHT, _LANDED = range(7)
_LANE = np.arange(WIDE)


@kernel
def cavity_passages(cavity, glow, slots, wave, sums, landed, score, hue):
    """Follow the rays of up to sixteen slots, which come from above, through an endless cavity.

    `cavity` are its parameters; its reflector is no table. `glow` (n+1,) ends rays there (`glow`),
    or is empty. `sums` (f,) gets where weights went, `landed` the weights that ended by the glow,
    `score` what derivatives need, or is None.
    """
    for i in range(WIDE):
        # Lanes without a slot have the last row, whose weight is 0.
        wave.lane_row[i] = slots[i] if i < len(slots) else len(wave.place) - 1
    flow = wave.lane_flow
    row = load_wide(wave.lane_row, 0)
    _follow(cavity, glow, wave.place, wave.rng, wave.weight, row, flow, score)
    for i in range(len(slots)):
        slot = slots[i]
        wave.weight[slot] = flow[i, _WEIGHT]
        wave.way[slot] = 1
        look_at(hue, wave, slot)
        wave.radiance[slot] += seen(hue, flow[i, _FOUND])
        sums[FLOW_LAMPS] += flow[i, _LAMPS]
        sums[FLOW_ELEMENTS] += flow[i, _ELEMENT]
        sums[FLOW_ROULETTE] += flow[i, _ROULETTE]
        sums[FLOW_LOST] += flow[i, _LOST]
        if len(glow) > 0:
            land(glow, cavity, wave.place[slot, 0], flow[i, _LANDED], wave.path[slot], landed)
    settle_lanes(score, wave, slots)


@kernel
def _follow(cavity, glow, place, rng, weights, row, flow, score):
    """Follow the rays of some rows until all have left; put where their weights went into flow."""
    top, luminance = cavity[HEIGHT], cavity[LAMP_LUMINANCE]
    height, radius = cavity[LAMP_HEIGHT], cavity[LAMP_RADIUS]
    specular = cavity[SPECULAR_FRACTION]
    x, y, _, dx, dy, dz, _, _ = gather_line(place, row)
    key0, key1, path0, path1 = gather_first_half(rng, row)
    stream, draw, spare, unused = gather_half(rng, row)
    weight = gather(weights, row)
    has = unused != 0
    z = spread_wide(top)
    zero = spread_wide(0.0)
    own = spread_wide(1.0 * NO_LAMP)
    first, last = spread_wide(1.0 * NONE_COUNTED[0]), spread_wide(1.0 * NONE_COUNTED[1])
    found, to_lamps, to_element, to_roulette, lost, ended = zero, zero, zero, zero, zero, zero
    if score is not None:
        # Meetings with lamps and reflector, the mirrored part's score; light by each; control.
        lamps, floors, odds, by_lamps, by_floors, by_odds, drawn = (
            zero, zero, zero, zero, zero, zero, zero,
        )  # fmt: skip
        to_mirror, to_diffuse = 1.0 / specular, -1.0 / (1.0 - specular)
    alive = weight > 0.0
    for _ in range(_MOST_MEETINGS):
        if not any_of(alive):
            break
        distance, centre, number = lamp_hit(
            x, z, dx, dz, cavity[LAMP_PITCH], cavity[LAMP_POSITION], height, radius, own
        )
        up, down = alive & (dz > 0.0), alive & (dz < 0.0)
        plane = (select(dz > 0.0, top, 0.0) - z) / dz
        lamp = alive & ((distance < plane) | ((up | down) ^ True)) & (distance < 1e300)
        floor = down & (lamp ^ True)
        stuck = alive & ((up | down | lamp) ^ True)
        step = select(lamp, distance, select(up | down, plane, 0.0))
        x, y = x + step * dx, y + step * dy
        z = select(floor, 0.0, select(lamp, z + step * dz, z))
        alive = lamp | floor
        if not any_of(alive):
            lost = lost + select(stuck, weight, 0.0)
            weight = select(stuck, 0.0, weight)
            break
        # Weight and light found.
        fresh = lamp & (((number >= first) & (number <= last)) ^ True)
        found = found + select(fresh, weight * luminance, 0.0)
        if score is not None:
            light = select(fresh, weight * luminance, 0.0)
            by_lamps, by_floors = by_lamps + light * lamps, by_floors + light * floors
            by_odds = by_odds + light * odds
            lamps, floors = lamps + select(lamp, 1.0, 0.0), floors + select(floor, 1.0, 0.0)
        to_lamps = to_lamps + select(lamp, weight * (1.0 - cavity[LAMP_REFLECTANCE]), 0.0)
        kept = weight * select(
            lamp, cavity[LAMP_REFLECTANCE], select(floor, cavity[REFLECTANCE], 1.0)
        )
        to_element = to_element + select(floor, weight - kept, 0.0)
        weight = kept
        first, last = (
            select(lamp, 1.0 * NONE_COUNTED[0], first),
            select(lamp, 1.0 * NONE_COUNTED[1], last),
        )
        if luminance > 0.0:
            share, nearest, slope = direct_light(cavity, x, dx, dz)
            found = found + select(floor, weight * share * luminance, 0.0)
            if score is not None:
                light = select(floor, weight * share * luminance, 0.0)
                by_lamps, by_floors = by_lamps + light * lamps, by_floors + light * floors
                slope = select(floor, weight * slope * luminance, 0.0)
                by_odds = by_odds + light * odds + slope
            first, last = select(floor, nearest - 1.0, first), select(floor, nearest + 1.0, last)
        if len(glow) > 0:
            back = glow_at(glow, cavity[LAMP_PITCH], cavity[LAMP_POSITION], x)
            found = found + select(floor, weight * (1.0 - specular) * back, 0.0)
        # The direction after: about the lamp's normal, Lambertian or mirrored.
        one, two, aft = next_two(key0, key1, path0, path1, stream, draw, spare, has)
        mirrored = floor & (one < specular)
        diffuse = floor & (mirrored ^ True)
        draw, spare, has = take(draw, spare, has, aft, mirrored, lamp | diffuse)
        if score is not None:
            step = select(mirrored, to_mirror, select(diffuse, to_diffuse, 0.0))
            odds, drawn = odds + step, drawn + weight * step
        first = select(mirrored, 1.0 * ALL_COUNTED[0], first)
        last = select(mirrored, 1.0 * ALL_COUNTED[1], last)
        three, four, aft = next_two(key0, key1, path0, path1, stream, draw, spare, has)
        px, py = disk_point(select(lamp, one, two), select(lamp, two, three))
        rest = 1.0 - px * px - py * py
        pz = root(select(rest > 0.0, rest, 0.0))
        if any_of(lamp):
            nx, nz = (x - centre) / radius, (z - height) / radius
            lx, ly, lz = frame(nx, zero, nz, px, py, pz)
            px, py, pz = select(lamp, lx, px), select(lamp, ly, py), select(lamp, lz, pz)
        turned = lamp | diffuse
        dx, dy = select(turned, px, dx), select(turned, py, dy)
        dz = select(turned, pz, select(mirrored, -dz, dz))
        own = select(lamp, number, select(floor, 1.0 * NO_LAMP, own))
        if len(glow) > 0:
            ended = ended + select(diffuse, weight, 0.0)
            weight = select(diffuse, 0.0, weight)
        # The roulette.
        faint = (lamp | floor) & (weight < ROULETTE_BELOW) & (weight > 0.0)
        draw, spare, has = take(draw, spare, has, aft, diffuse ^ faint, diffuse & faint)
        ends = faint & (select(diffuse, four, three) < 0.5)
        lives = faint & (ends ^ True)
        to_roulette = to_roulette + select(ends, weight, select(lives, -weight, 0.0))
        lost = lost + select(stuck, weight, 0.0)
        weight = select(ends | stuck, 0.0, select(lives, 2.0 * weight, weight))
        alive = (lamp | floor) & (weight > 0.0)
    lost = lost + select(alive, weight, 0.0)
    weight = select(alive, 0.0, weight)
    scatter_line(place, row, x, y, z, dx, dy, dz, zero, zero)
    scatter_half(rng, row, stream, draw, spare, select(has, 1, 0))
    lane = load_wide(_LANE, 0)
    scatter_line(flow, lane, found, to_lamps, to_element, to_roulette, lost, weight, ended, zero)
    if score is not None:
        scatter_line(
            score.lane, lane, lamps / cavity[LAMP_REFLECTANCE], floors / cavity[REFLECTANCE], odds,
            by_lamps / cavity[LAMP_REFLECTANCE], by_floors / cavity[REFLECTANCE], by_odds, drawn,
            zero,
        )  # fmt: skip
