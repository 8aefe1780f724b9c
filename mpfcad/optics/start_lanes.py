"""Starts of paths at a meter or from below, eight at a time: those of `source.start_ray`."""

from numba import int64, uint64

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import LANES, spread
from mpfcad.optics.base.lanes_array import gather, load_from, scatter_line
from mpfcad.optics.base.sampling import disk_point
from mpfcad.optics.base.sampling_lanes import net_share, start_net_paths
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.source import EYE, look, remaining_cosine


@kernel
def start_rays(scene, source, seed, stream, first, number, slots, wave):
    """Put paths `first` + `number` and on into up to eight slots, before their first element.

    Their source is a meter or Lambertian light from below.
    """
    points = uint64(len(source.position))
    key0, key1, path0, path1, seq, draw, spare, point = start_net_paths(
        seed, stream, first, first + uint64(number), points, wave.net_key
    )
    length = source.spot_along if source.spot_along > 0.0 else scene.length
    across, along = net_share(spare, draw), net_share(spare, draw + 1)
    x = gather(source.position, point) + (across - 0.5) * source.spot
    y = gather(source.along, point) + (along - 0.5) * length
    zero = spread(0.0)
    tilt_x, tilt_y = gather(source.tilt_x, point), gather(source.tilt_y, point)
    if source.kind == EYE and source.acceptance == 0.0:
        # A meter without a cone looks one way; what it would draw is left out.
        dx, dy, dz = tilt_x, tilt_y, -remaining_cosine(tilt_x, tilt_y)
    else:
        px, py = disk_point(net_share(spare, draw + 2), net_share(spare, draw + 3))
        if source.kind == EYE:
            dx, dy, dz = look(tilt_x, tilt_y, source.acceptance, px, py)
        else:
            dx, dy, dz = px, py, remaining_cosine(px, py)
    for i in range(LANES):
        wave.lane_row[i] = int64(slots[i]) if i < len(slots) else len(wave.place) - 1
    row = load_from(wave.lane_row, 0)
    scatter_line(wave.place, row, x, y, zero, dx, dy, dz, zero, zero)
    none = spread(0)
    scatter_line(wave.rng, row, key0, key1, path0, path1, seq, draw + 4, spare, none)
    e = len(scene.kind) - 1 if source.kind == EYE else 0
    upward = 0 if source.kind == EYE else 1
    waiting = wave.length[e]
    queue = wave.queue[e, waiting : waiting + len(slots)]
    for i in range(len(slots)):
        slot = uint64(slots[i])
        wave.upward[slot] = upward
        wave.weight[slot] = 1.0
        wave.radiance[slot] = 0.0
        wave.lamp[slot] = NO_LAMP
        wave.path[slot] = number + i
        queue[i] = int64(slot)
    wave.length[e] = waiting + len(slots)
