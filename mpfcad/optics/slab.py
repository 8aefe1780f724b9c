"""A ray's passage through a plate: Fresnel at its faces, scattering and absorption inside."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.phase import scattering_cosine
from mpfcad.optics.base.sampling import flight, henyey_greenstein_slope, turn, uniform
from mpfcad.optics.score.state import ABSORBED, SCATTERED, TURNED, draw, weigh
from mpfcad.optics.stokes.interface import meet_interface
from mpfcad.optics.stokes.state import depolarise
from mpfcad.optics.stokes.uniaxial import delay

#: The columns of a plate in `Scene.parameter`; `PHASE` is the row of its phase function or -1.
INDEX, THICKNESS, SCATTERING, ABSORPTION, ASYMMETRY, BONDED, PHASE, INDEX_BELOW = range(8)
#: Of a uniaxial plate: radians a mm, and the direction of its axis (`stokes.uniaxial`).
DELAY, AXIS_X, AXIS_Y = range(8, 11)
_MOST_STEPS = 1_000_000


@kernel
def slab_passage(phase, parameter, up, x, y, dx, dy, dz, light, score, rng):
    """Follow a ray through a slab: (way, x, y, dx, dy, dz, travelled).

    `way` is 1 when it leaves upward, -1 downward, 0 when it was lost; `travelled` [mm] its path
    within, by which the volume absorbs. Free paths between scatterings are exponential of mean
    1/scattering.
    """
    index, thickness, scattering, asymmetry, bonded, row = (
        parameter[INDEX], parameter[THICKNESS], parameter[SCATTERING],
        parameter[ASYMMETRY], parameter[BONDED] != 0.0, int(parameter[PHASE]),
    )  # fmt: skip
    # Below it is air, or the slab on which it is bonded.
    below = parameter[INDEX_BELOW]
    travelled = 0.0
    z = 0.0 if up else thickness
    if up or not bonded:
        outside = below if up else 1.0
        mirrored, cos_out = meet_interface(
            abs(dz), outside / index, 0.0, 0.0, 1.0, dx, dy, dz, light, rng
        )
        if mirrored:
            return (-1 if up else 1), x, y, dx, dy, -dz, 0.0
        dx, dy, dz = dx * outside / index, dy * outside / index, math.copysign(cos_out, dz)
    for _ in range(_MOST_STEPS):
        free, to_face = flight(thickness, scattering, z, dz, rng)
        step = min(free, to_face)
        weigh(score, ABSORBED, -step)
        if scattering > 0.0:
            draw(score, SCATTERED, (1.0 / scattering if free < to_face else 0.0) - step)
        travelled += step
        delay(light, parameter[DELAY], parameter[AXIS_X], parameter[AXIS_Y], step, dx, dy, dz)
        x += step * dx
        y += step * dy
        if free < to_face:
            z += step * dz
            cosine = scattering_cosine(phase, row, asymmetry, uniform(rng))
            if row < 0:
                draw(score, TURNED, henyey_greenstein_slope(asymmetry, cosine))
            dx, dy, dz = turn(dx, dy, dz, cosine, 2.0 * math.pi * uniform(rng))
            depolarise(light)
            continue
        top = dz > 0.0
        z = thickness if top else 0.0
        if top and bonded:
            return 1, x, y, dx, dy, dz, travelled
        ratio = index if top else index / below
        mirrored, cos_out = meet_interface(abs(dz), ratio, 0.0, 0.0, 1.0, dx, dy, dz, light, rng)
        if mirrored:
            dz = -dz
            continue
        way = 1 if top else -1
        return way, x, y, dx * ratio, dy * ratio, math.copysign(cos_out, dz), travelled
    return 0, x, y, dx, dy, dz, 0.0
