"""Starts of paths at a meter or from below, eight at a time: those of `source.start_ray`."""

from numba import uint64

from mpfcad.optics.cavity import NO_LAMP
from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import select, spread
from mpfcad.optics.lanes_array import load, load_lines, store, store_lines
from mpfcad.optics.sampling import disk_point
from mpfcad.optics.sampling_lanes import next_two, start_net_paths, take
from mpfcad.optics.source import EYE, look, remaining_cosine
from mpfcad.optics.wave import enqueue


@kernel
def start_rays(scene, source, seed, stream, first, number, slots, wave):
    """Put paths `first` + `number` and on into up to eight slots, before their first element.

    Their source is a meter or Lambertian light from below.
    """
    place, rng = wave.lane_place, wave.lane_rng
    e = len(scene.kind) - 1 if source.kind == EYE else 0
    points = uint64(len(source.position))
    for i in range(len(slots)):
        point = (first + uint64(number + i)) % points
        place[i, 0], place[i, 1] = source.position[point], source.along[point]
        place[i, 2], place[i, 3] = source.tilt_x[point], source.tilt_y[point]
    x, y, tilt_x, tilt_y, _, _, _, _ = load_lines(place)
    key0, key1, path0, path1, seq, draw, spare = start_net_paths(
        rng, seed, stream, first + uint64(number), points, len(slots)
    )
    all_of, none = draw < 0, draw >= 0
    has = none
    one, two, aft = next_two(key0, key1, path0, path1, seq, draw, spare, has)
    draw, spare, has = take(draw, spare, has, aft, none, all_of)
    length = source.spot_along if source.spot_along > 0.0 else scene.length
    x = x + (one - 0.5) * source.spot
    y = y + (two - 0.5) * length
    one, two, aft = next_two(key0, key1, path0, path1, seq, draw, spare, has)
    draw, spare, has = take(draw, spare, has, aft, none, all_of)
    px, py = disk_point(one, two)
    if source.kind == EYE:
        dx, dy, dz = look(tilt_x, tilt_y, source.acceptance, px, py)
    else:
        dx, dy, dz = px, py, remaining_cosine(px, py)
    nothing = spread(0.0)
    store_lines(place, x, y, nothing, dx, dy, dz, nothing, nothing)
    store_lines(rng, key0, key1, path0, path1, seq, draw, spare, select(has, 1, 0))
    for i in range(len(slots)):
        slot = slots[i]
        store(wave.place, slot, load(place, i))
        store(wave.rng, slot, load(rng, i))
        wave.upward[slot] = 0 if source.kind == EYE else 1
        _reset(wave, slot, number + i)
        enqueue(wave, e, slot)


@kernel
def _reset(wave, slot, number):
    """Let a slot hold a new path that has met nothing yet."""
    wave.weight[slot] = 1.0
    wave.radiance[slot] = 0.0
    wave.lamp[slot] = NO_LAMP
    wave.path[slot] = number
    for f in range(wave.once.shape[1]):
        wave.once[slot, f] = 0.0
