"""One ray's way through the space under the stack, whatever lights it, until it leaves upward."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.recorder import FLOW_ELEMENTS, FLOW_LAMPS, FLOW_LOST, FLOW_WALLS
from mpfcad.optics.base.roulette import roulette
from mpfcad.optics.bsdf.passage import bsdf_passage
from mpfcad.optics.cavity.board_passage import over_board
from mpfcad.optics.cavity.direct import (
    ALL_COUNTED,
    NONE_COUNTED,
    direct_light,
    lamp_view,
    panel_surplus,
)
from mpfcad.optics.cavity.endless import (
    BRDF,
    HEIGHT,
    LAMP,
    LAMP_HEIGHT,
    LAMP_LUMINANCE,
    LAMP_PITCH,
    LAMP_POSITION,
    LAMP_RADIUS,
    LAMP_REFLECTANCE,
    NO_LAMP,
    ON_REFLECTOR,
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
from mpfcad.optics.score.state import (
    AT_LAMP,
    AT_REFLECTOR,
    MIRRORED,
    draw_weighed,
    shine,
    shine_by,
    weigh,
)
from mpfcad.optics.spectral.hue import EMITTER, SURFACE, WALL, seen, strike
from mpfcad.optics.stokes.state import depolarise

_MOST_MEETINGS = 1_000_000


@kernel
def cavity_passage(scene, x, y, z, dx, dy, dz, lamp, weight, flow, light, score, hue, rng):
    """Follow a ray in the cavity until it leaves or ends: (x, y, dx, dy, dz, weight, radiance).

    `lamp` is the emitter that the ray starts on, at (x, y, z), `ON_REFLECTOR`, or `NO_LAMP`: it
    comes from above. No ray that comes from above is followed here where the scene has a glow.
    """
    if lamp == NO_LAMP:
        z = scene.parameter[0, HEIGHT]
    elif lamp == ON_REFLECTOR:
        z = 0.0
    if len(scene.led) > 0:
        return over_board(scene, x, y, z, dx, dy, dz, weight, flow, light, hue, rng)
    return _among_tubes(scene, x, y, z, dx, dy, dz, lamp, weight, flow, light, score, hue, rng)


@kernel
def _among_tubes(scene, x, y, z, dx, dy, dz, lamp, weight, flow, light, score, hue, rng):
    """Follow a ray in the cavity until it leaves or ends: (x, y, dx, dy, dz, weight, radiance)."""
    parameter = scene.parameter[0]
    finite = len(scene.lamp) > 0
    radiance = 0.0
    first, last = NONE_COUNTED
    if lamp == ON_REFLECTOR:
        # What lamps send there directly is left out: `direct_light` adds it.
        _, nearest = lamp_view(
            parameter[LAMP_PITCH], parameter[LAMP_POSITION], parameter[LAMP_HEIGHT],
            parameter[LAMP_RADIUS], x,
        )  # fmt: skip
        first, last = int(nearest) - 1, int(nearest) + 1
        lamp = NO_LAMP
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
                radiance += seen(hue, weight * luminance)
                shine(score, weight * luminance)
            first, last = NONE_COUNTED
            flow[FLOW_LAMPS] += weight * (1.0 - parameter[LAMP_REFLECTANCE])
            weight *= parameter[LAMP_REFLECTANCE]
            weigh(score, AT_LAMP, 1.0 / parameter[LAMP_REFLECTANCE])
            strike(hue, 0, EMITTER)
            lamp = number
            nx = (x - centre) / parameter[LAMP_RADIUS]
            nz = (z - parameter[LAMP_HEIGHT]) / parameter[LAMP_RADIUS]
            dx, dy, dz = lambertian(nx, 0.0, nz, rng)
            depolarise(light)
        elif what == REFLECTOR:
            before = weight
            lamp = NO_LAMP
            table = int(parameter[BRDF])
            if table >= 0:
                _, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
                weight *= survival
                dz = abs(dz)
                depolarise(light)
            else:
                weight *= parameter[REFLECTANCE]
                weigh(score, AT_REFLECTOR, 1.0 / parameter[REFLECTANCE])
                strike(hue, 0, SURFACE)
                if not finite:
                    share, nearest, tilt = direct_light(parameter, x, dx, dz)
                    radiance += seen(hue, weight * share * parameter[LAMP_LUMINANCE])
                    shine(score, weight * share * parameter[LAMP_LUMINANCE])
                    shine_by(score, MIRRORED, weight * tilt * parameter[LAMP_LUMINANCE])
                    first, last = int(nearest) - 1, int(nearest) + 1
                come = dx / math.sqrt(dx * dx + dz * dz)
                mirrored, dx, dy, dz = reflector_direction(
                    parameter[SPECULAR_FRACTION], dx, dy, dz, light, rng
                )
                share = parameter[SPECULAR_FRACTION]
                odds = 1.0 / share if mirrored else -1.0 / (1.0 - share)
                draw_weighed(score, MIRRORED, odds, weight)
                if mirrored and not finite:
                    first, last = ALL_COUNTED
                if finite:
                    gone = dx / math.sqrt(dx * dx + dz * dz)
                    surplus, tilt = panel_surplus(parameter, scene.lamp, x, come, gone)
                    radiance += seen(hue, weight * surplus * parameter[LAMP_LUMINANCE])
                    shine(score, weight * surplus * parameter[LAMP_LUMINANCE])
                    shine_by(score, MIRRORED, weight * tilt * parameter[LAMP_LUMINANCE])
            flow[FLOW_ELEMENTS] += before - weight
        elif what in (WALL_ACROSS, WALL_ALONG):
            flow[FLOW_WALLS] += weight * (1.0 - scene.wall[WALL_REFLECTANCE])
            weight *= scene.wall[WALL_REFLECTANCE]
            strike(hue, 0, WALL)
            lamp = NO_LAMP
            dx, dy, dz = wall_direction(
                what, scene.wall[WALL_SPECULAR_FRACTION], dx, dy, dz, light, rng
            )
        elif what == LAMP_END:
            # The ends hold the electrodes: they reflect like the tube and do not shine.
            flow[FLOW_LAMPS] += weight * (1.0 - parameter[LAMP_REFLECTANCE])
            weight *= parameter[LAMP_REFLECTANCE]
            weigh(score, AT_LAMP, 1.0 / parameter[LAMP_REFLECTANCE])
            strike(hue, 0, EMITTER)
            lamp = number
            dx, dy, dz = lambertian(0.0, math.copysign(1.0, y), 0.0, rng)
            depolarise(light)
        else:
            break
        weight = roulette(weight, flow, rng)
        if weight == 0.0:
            return x, y, dx, dy, dz, weight, radiance
    flow[FLOW_LOST] += weight
    return x, y, dx, dy, dz, 0.0, radiance
