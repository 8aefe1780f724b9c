"""One ray's way over a board of LEDs until it leaves upward; LEDs are met by chance."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.recorder import FLOW_ELEMENTS, FLOW_LAMPS, FLOW_LOST
from mpfcad.optics.base.roulette import roulette
from mpfcad.optics.bsdf.passage import bsdf_passage
from mpfcad.optics.cavity.board import (
    CUP_HEIGHT,
    CUP_REFLECTANCE,
    CUP_WALL,
    LED_FACTOR,
    LED_FLUX,
    LED_LENGTH,
    LED_REFLECTANCE,
    LED_SIDE,
    LED_TOP,
    LED_WIDTH,
    board_hit,
    board_reflectance,
)
from mpfcad.optics.cavity.cup import cup_direction, cup_hit
from mpfcad.optics.cavity.emission import emitted_intensity
from mpfcad.optics.cavity.endless import (
    BRDF,
    OPENING,
    REFLECTOR,
    SPECULAR_FRACTION,
    lambertian,
    reflector_direction,
)
from mpfcad.optics.spectral.hue import EMITTER, HOLE, SURFACE, WALL, seen, strike
from mpfcad.optics.stokes.state import depolarise

_MOST_MEETINGS = 1_000_000
#: mm² in a m²: luminances are in cd/m², lengths in mm.
_SQUARE_METRE = 1e6


@kernel
def led_luminance(scene, number, dx, dy, dz):
    """Return the luminance [cd/m²] of an LED's top in the direction of its light, dz > 0."""
    parameter = scene.parameter[0]
    area = parameter[LED_WIDTH] * parameter[LED_LENGTH]
    flux = parameter[LED_FLUX] * scene.led[number, LED_FACTOR]
    return _SQUARE_METRE * flux * emitted_intensity(scene.emission, dx, dy, dz) / (area * dz)


@kernel
def over_board(scene, x, y, z, dx, dy, dz, weight, flow, light, hue, rng):
    """Follow a ray over the board until it leaves or ends: (x, y, dx, dy, dz, weight, radiance)."""
    parameter = scene.parameter[0]
    radiance = 0.0
    for _ in range(_MOST_MEETINGS):
        if parameter[CUP_HEIGHT] > 0.0:
            hit = cup_hit(parameter, scene.led, x, y, z, dx, dy, dz)
        else:
            hit = board_hit(parameter, scene.led, x, y, z, dx, dy, dz)
        what, x, y, z, number, nx, ny, nz = hit
        if what == OPENING:
            return x, y, dx, dy, dz, weight, radiance
        if what in (LED_TOP, LED_SIDE):
            if what == LED_TOP:
                radiance += seen(hue, weight * led_luminance(scene, number, -dx, -dy, -dz))
            flow[FLOW_LAMPS] += weight * (1.0 - parameter[LED_REFLECTANCE])
            weight *= parameter[LED_REFLECTANCE]
            strike(hue, 0, EMITTER)
            dx, dy, dz = lambertian(nx, ny, nz, rng)
            depolarise(light)
        elif what == CUP_WALL:
            flow[FLOW_ELEMENTS] += weight * (1.0 - parameter[CUP_REFLECTANCE])
            weight *= parameter[CUP_REFLECTANCE]
            strike(hue, 0, WALL)
            dx, dy, dz = cup_direction(parameter, dx, dy, dz, nx, ny, nz, light, rng)
        elif what == REFLECTOR:
            before = weight
            reflectance, hole = board_reflectance(parameter, scene.led, x, y)
            table = int(parameter[BRDF])
            if table >= 0 and not hole:
                _, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
                weight *= survival
                dz = abs(dz)
                depolarise(light)
            else:
                weight *= reflectance
                strike(hue, 0, HOLE if hole else SURFACE)
                share = 0.0 if hole else parameter[SPECULAR_FRACTION]
                _, dx, dy, dz = reflector_direction(share, dx, dy, dz, light, rng)
            flow[FLOW_ELEMENTS] += before - weight
        else:
            break
        weight = roulette(weight, flow, rng)
        if weight == 0.0:
            return x, y, dx, dy, dz, weight, radiance
    flow[FLOW_LOST] += weight
    return x, y, dx, dy, dz, 0.0, radiance
