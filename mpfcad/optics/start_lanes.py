"""Starts of paths at a meter or from below, eight at a time: those of `source.start_ray`."""

from numba import int64, uint64

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import select, spread
from mpfcad.optics.base.lanes_array import gather, load, store, store_lines
from mpfcad.optics.base.sampling import disk_point
from mpfcad.optics.base.sampling_lanes import next_two, start_net_paths, take
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.source import EYE, look, remaining_cosine


@kernel
def start_rays(scene, source, seed, stream, first, number, slots, wave):
    """Put paths `first` + `number` and on into up to eight slots, before their first element.

    Their source is a meter or Lambertian light from below.
    """
    place, rng = wave.lane_place, wave.lane_rng
    points = uint64(len(source.position))
    key0, key1, path0, path1, seq, draw, spare, point = start_net_paths(
        seed, stream, first + uint64(number), points
    )
    all_of, none = draw < 0, draw >= 0
    has = none
    one, two, aft = next_two(key0, key1, path0, path1, seq, draw, spare, has)
    draw, spare, has = take(draw, spare, has, aft, none, all_of)
    length = source.spot_along if source.spot_along > 0.0 else scene.length
    x = gather(source.position, point) + (one - 0.5) * source.spot
    y = gather(source.along, point) + (two - 0.5) * length
    one, two, aft = next_two(key0, key1, path0, path1, seq, draw, spare, has)
    draw, spare, has = take(draw, spare, has, aft, none, all_of)
    px, py = disk_point(one, two)
    if source.kind == EYE:
        tilt_x, tilt_y = gather(source.tilt_x, point), gather(source.tilt_y, point)
        dx, dy, dz = look(tilt_x, tilt_y, source.acceptance, px, py)
    else:
        dx, dy, dz = px, py, remaining_cosine(px, py)
    nothing = spread(0.0)
    store_lines(place, x, y, nothing, dx, dy, dz, nothing, nothing)
    store_lines(rng, key0, key1, path0, path1, seq, draw, spare, select(has, 1, 0))
    e = len(scene.kind) - 1 if source.kind == EYE else 0
    upward = 0 if source.kind == EYE else 1
    waiting = wave.length[e]
    queue = wave.queue[e, waiting : waiting + len(slots)]
    for i in range(len(slots)):
        slot = uint64(slots[i])
        store(wave.place, slot, load(place, i))
        store(wave.rng, slot, load(rng, i))
        wave.upward[slot] = upward
        wave.weight[slot] = 1.0
        wave.radiance[slot] = 0.0
        wave.lamp[slot] = NO_LAMP
        wave.path[slot] = number + i
        queue[i] = int64(slot)
    wave.length[e] = waiting + len(slots)
