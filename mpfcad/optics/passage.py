"""One ray's passage through one element of a scene, of whatever kind, with its weight."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.recorder import (
    FLOW_ELEMENTS,
    FLOW_LAMPS,
    FLOW_LOST,
    FLOW_ROULETTE,
    FLOW_WALLS,
)
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.bsdf.passage import bsdf_passage
from mpfcad.optics.cavity.direct import ALL_COUNTED, NONE_COUNTED, direct_light, panel_surplus
from mpfcad.optics.cavity.endless import (
    BRDF,
    HEIGHT,
    LAMP,
    LAMP_HEIGHT,
    LAMP_LUMINANCE,
    LAMP_RADIUS,
    LAMP_REFLECTANCE,
    NO_LAMP,
    OPENING,
    REFLECTANCE,
    REFLECTOR,
    SPECULAR_FRACTION,
    cavity_hit,
    lambertian,
    reflector_direction,
)
from mpfcad.optics.cavity.finite import (
    FACTOR,
    LAMP_END,
    WALL_ACROSS,
    WALL_ALONG,
    WALL_REFLECTANCE,
    WALL_SPECULAR_FRACTION,
    panel_hit,
    wall_direction,
)
from mpfcad.optics.element import BSDF, CAVITY, SHEET, SLAB
from mpfcad.optics.film.passage import placed_film_passage
from mpfcad.optics.sheet import sheet_passage
from mpfcad.optics.slab import slab_passage

_ROULETTE_BELOW = 0.1
_MOST_MEETINGS = 1_000_000


@kernel
def _cavity(scene, x, y, z, dx, dy, dz, lamp, weight, flow, rng):
    """Follow a ray in the cavity until it leaves or ends: (x, y, dx, dy, dz, weight, radiance)."""
    parameter = scene.parameter[0]
    finite = len(scene.lamp) > 0
    radiance = 0.0
    first, last = NONE_COUNTED
    for _ in range(_MOST_MEETINGS):
        if finite:
            what, x, y, z, number, centre = panel_hit(
                parameter, scene.wall, scene.lamp, x, y, z, dx, dy, dz, lamp
            )
        else:
            what, x, y, z, number, centre = cavity_hit(parameter, x, y, z, dx, dy, dz, lamp)
        if what == OPENING:
            return x, y, dx, dy, dz, weight, radiance
        if what == LAMP:
            luminance = parameter[LAMP_LUMINANCE] * (scene.lamp[number, FACTOR] if finite else 1.0)
            if not first <= number <= last:
                radiance += weight * luminance
            first, last = NONE_COUNTED
            flow[FLOW_LAMPS] += weight * (1.0 - parameter[LAMP_REFLECTANCE])
            weight *= parameter[LAMP_REFLECTANCE]
            lamp = number
            nx = (x - centre) / parameter[LAMP_RADIUS]
            nz = (z - parameter[LAMP_HEIGHT]) / parameter[LAMP_RADIUS]
            dx, dy, dz = lambertian(nx, 0.0, nz, rng)
        elif what == REFLECTOR:
            before = weight
            lamp = NO_LAMP
            table = int(parameter[BRDF])
            if table >= 0:
                _, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
                weight *= survival
                dz = abs(dz)
            else:
                weight *= parameter[REFLECTANCE]
                if not finite:
                    share, nearest = direct_light(parameter, x, dx, dz)
                    radiance += weight * share * parameter[LAMP_LUMINANCE]
                    first, last = int(nearest) - 1, int(nearest) + 1
                come = dx / math.sqrt(dx * dx + dz * dz)
                mirrored, dx, dy, dz = reflector_direction(
                    parameter[SPECULAR_FRACTION], dx, dy, dz, rng
                )
                if mirrored and not finite:
                    first, last = ALL_COUNTED
                if finite:
                    gone = dx / math.sqrt(dx * dx + dz * dz)
                    surplus = panel_surplus(parameter, scene.lamp, x, come, gone)
                    radiance += weight * surplus * parameter[LAMP_LUMINANCE]
            flow[FLOW_ELEMENTS] += before - weight
        elif what in (WALL_ACROSS, WALL_ALONG):
            flow[FLOW_WALLS] += weight * (1.0 - scene.wall[WALL_REFLECTANCE])
            weight *= scene.wall[WALL_REFLECTANCE]
            lamp = NO_LAMP
            dx, dy, dz = wall_direction(what, scene.wall[WALL_SPECULAR_FRACTION], dx, dy, dz, rng)
        elif what == LAMP_END:
            # The ends hold the electrodes: they reflect like the tube and do not shine.
            flow[FLOW_LAMPS] += weight * (1.0 - parameter[LAMP_REFLECTANCE])
            weight *= parameter[LAMP_REFLECTANCE]
            lamp = number
            dx, dy, dz = lambertian(0.0, math.copysign(1.0, y), 0.0, rng)
        else:
            break
        weight = roulette(weight, flow, rng)
        if weight == 0.0:
            return x, y, dx, dy, dz, weight, radiance
    flow[FLOW_LOST] += weight
    return x, y, dx, dy, dz, 0.0, radiance


@kernel
def roulette(weight, flow, rng):
    """End a faint path half of the time, and double it otherwise; `flow` keeps the difference."""
    if weight >= _ROULETTE_BELOW or weight == 0.0:
        return weight
    if uniform(rng) < 0.5:
        flow[FLOW_ROULETTE] += weight
        return 0.0
    flow[FLOW_ROULETTE] -= weight
    return 2.0 * weight


@kernel
def pass_element(scene, e, up, x, y, z, dx, dy, dz, lamp, weight, flow, rng):
    """Follow a ray through element e: (way, x, y, dx, dy, dz, weight, radiance found).

    `way` is 1 when it leaves upward, -1 downward, 0 when it was lost; z and lamp count for a path
    that starts in the cavity.
    """
    kind = scene.kind[e]
    parameter = scene.parameter[e]
    way = 1
    before = weight
    found = 0.0
    if kind == CAVITY:
        if lamp == NO_LAMP:
            z = parameter[HEIGHT]
        x, y, dx, dy, dz, weight, found = _cavity(
            scene, x, y, z, dx, dy, dz, lamp, weight, flow, rng
        )
        before = weight
    elif kind == SLAB:
        way, x, y, dx, dy, dz, survival = slab_passage(
            scene.phase, parameter, up, x, y, dx, dy, dz, rng
        )
        weight *= survival
    elif kind == SHEET:
        sigma, index, transmission = parameter[0], parameter[1], parameter[2]
        passed, dx, dy, dz = sheet_passage(sigma, index, dx, dy, dz, rng)
        weight *= transmission
        way = 1 if passed == up else -1
    elif kind == BSDF:
        table = int(parameter[0])
        passed, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
        weight *= survival
        way = 1 if passed == up else -1
    else:
        way, x, y, dx, dy, dz = placed_film_passage(
            scene.tiles, scene.phase, parameter, up, x, y, dx, dy, dz, rng
        )
    flow[FLOW_ELEMENTS + e] += before - weight
    return way, x, y, dx, dy, dz, weight, found
