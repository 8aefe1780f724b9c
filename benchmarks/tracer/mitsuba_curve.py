"""The luminance over a lamp pitch of a film in its backlight, traced by Mitsuba.

Scene, surfaces and lamps are Mitsuba's; the loop along a path is written here on them. Its own
path integrator moves each ray on by 9e-5 of the largest coordinate, 1.5 µm over a lamp pitch: 4 %
of a prism's facet. Here a ray is moved on by some hundredths of a micrometre. Nothing changes along
the grooves, so each meeting is moved back to y = 0.
"""

import drjit as dr
import numpy as np

from tracer.mitsuba_scene import mesh_shape, mitsuba, sheet_class, stack_world
from tracer.stl import read_corners

mi = mitsuba()
mi.register_bsdf("sheet", sheet_class(mi))

#: Half the extent of everything along the grooves [µm].
HALF = 12e3
#: How far a ray is moved on: at the origin, and a part of the largest coordinate [µm].
STEP, STEP_PART = 0.01, 3e-6
#: Paths that carry less than this end by chance.
ROULETTE = 0.3
#: Meetings after which a path ends: one that slips through a crack into glass can be caught there.
MOST = 5_000
#: Corners are rounded to so much [µm]: those of neighbouring tiles are the same, without a crack.
GRID = 1e-3
#: Paths of one launch.
LAUNCH = 1 << 18


def curve(elements, path, offset, meter, position, paths, seed, lamps=1):
    """Return luminances [cd/m²] that a meter sees at places [pitch] from a lamp, and their errors.

    elements: cavity, clear plate, sheet, film, sheet, from the bottom up. offset: of the tile's
    left edge from a lamp's axis [mm]. meter: width of its spot [mm], sine of its acceptance.
    lamps: an odd number, between mirrors half a pitch beside the outer ones. One lamp stands for a
    row without end where the film is its own mirror image about it.
    """
    pitch = elements[0].lamp_pitch
    scene, wall, top = _scene(elements, path, offset, lamps)
    spot, acceptance = meter
    place = np.where(position > 0.5, position - 1, position) * pitch * 1e3
    each = max(1, LAUNCH // len(position))
    rounds = max(2, round(paths / (each * len(position))))
    values = [
        _launch(scene, place, each, (spot * 1e3, acceptance), (wall, top), seed * 10_000 + number)
        for number in range(rounds)
    ]
    mean = np.mean([value.mean(axis=1) for value in values], axis=0)
    spread = np.mean([value.var(axis=1) for value in values], axis=0)
    return mean, np.sqrt(spread / (each * rounds))


def _launch(scene, place, each, meter, size, seed):
    """Return what `each` rays bring to each place [µm], (places, each)."""
    (spot, acceptance), (wall, top) = meter, size
    count = each * len(place)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    lane = dr.arange(mi.UInt32, count) // each
    x = dr.gather(mi.Float, mi.Float(place.astype(np.float32)), lane)
    x += (sampler.next_1d() - 0.5) * spot
    # Beyond a mirror lies what is before it.
    x = dr.select(dr.abs(x) > wall, dr.mulsign(2 * wall - dr.abs(x), x), x)
    tilt = mi.warp.square_to_uniform_disk(sampler.next_2d()) * acceptance
    down = -dr.sqrt(1 - dr.squared_norm(tilt))
    origin, toward = mi.Point3f(x, 0, top), mi.Vector3f(tilt.x, tilt.y, down)
    return np.array(follow(scene, origin, toward, sampler), float).reshape(len(place), each)


@dr.syntax
def follow(scene, origin, direction, sampler):
    """Return the radiance that comes along rays, next-event estimation weighed with what is met."""
    context = mi.BSDFContext()
    value, weight, density = mi.Float(0), mi.Float(1), mi.Float(1)
    active, sharp = mi.Bool(True), mi.Bool(True)
    before, count = dr.zeros(mi.Interaction3f), mi.UInt32(0)
    while active:
        hit = scene.ray_intersect(mi.Ray3f(origin, direction), active)
        met = mi.DirectionSample3f(scene, hit, before)
        chance = scene.pdf_emitter_direction(before, met, active & ~sharp)
        share = dr.select(sharp, 1, density / (density + chance))
        lit = hit.emitter(scene, active).eval(hit, active)
        value += dr.select(active, weight * share * lit.x, 0)
        active &= hit.is_valid()
        hit.p.y = 0
        bsdf = hit.bsdf()
        smooth = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        lamp, bright = scene.sample_emitter_direction(hit, sampler.next_2d(), True, smooth)
        smooth &= lamp.pdf > 0
        part, own = bsdf.eval_pdf(context, hit, hit.to_local(lamp.d), smooth)
        value += dr.select(smooth, weight * part.x * bright.x * lamp.pdf / (lamp.pdf + own), 0)
        sample, factor = bsdf.sample(context, hit, sampler.next_1d(), sampler.next_2d(), active)
        weight *= factor.x
        sharp = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta)
        # A blend's own density leaves out the share of its other part.
        density = bsdf.pdf(context, hit, sample.wo, active & ~sharp)
        direction = hit.to_world(sample.wo)
        step = STEP + STEP_PART * dr.maximum(dr.abs(hit.p.x), dr.abs(hit.p.z))
        away = dr.mulsign(step, dr.dot(hit.n, direction))
        origin = mi.Point3f(hit.p + mi.Vector3f(hit.n) * away)
        before.p = hit.p
        before.n = hit.n
        keep = dr.minimum(weight / ROULETTE, 1)
        count += 1
        active &= (sampler.next_1d() < keep) & (keep > 0) & (count < MOST)
        weight = dr.select(active, weight / keep, weight)
    return value


def _scene(elements, path, offset, lamps):
    pitch = elements[0].lamp_pitch * 1e3
    wall = lamps * pitch / 2
    axes = [(number - lamps // 2) * pitch for number in range(lamps)]
    corner = _tiles(path, offset * 1e3, wall)
    vertex = corner.reshape(-1, 3)
    film = mesh_shape(mi, vertex, np.arange(len(vertex)).reshape(-1, 3), elements[3].index)
    world, top = stack_world(mi, elements, film, axes, (wall, HALF))
    return mi.load_dict(world), wall, top


def _tiles(path, left, wall):
    """Return the corners (t, 3, 3) [µm] of copies of a film's tile that reach over ± wall.

    Without the sides between them; left: x of one tile's left edge [µm].
    """
    corner = read_corners(path) * 1e3
    low, high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    width = high[0] - low[0]
    near = 1e-3
    sides = [np.all(np.abs(corner[:, :, 0] - end) < near, axis=1) for end in (low[0], high[0])]
    corner = corner[~(sides[0] | sides[1])] - low
    corner[:, :, 1] = (corner[:, :, 1] / (high[1] - low[1]) - 0.5) * 2.2 * HALF
    first, last = (int(np.floor((end - left) / width)) for end in (-wall, wall))
    shift = np.zeros((last - first + 1, 1, 1, 3))
    shift[..., 0] += left + width * np.arange(first, last + 1)[:, None, None]
    return GRID * np.round((corner + shift).reshape(-1, 3, 3) / GRID)
