"""A thin diffuser sheet: a Gaussian move of the direction cosines, accepted reciprocally."""

import math

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import gaussian_pair, uniform

#: The columns of a sheet in `Scene.parameter`.
SIGMA, INDEX, TRANSMISSION = range(3)


@kernel
def sheet_transmittance(cos_in, cos_out, index):
    """Return the share of light that two smooth faces pass, in at one angle, out at another.

    T = (1-R)(1-R')/(1-R R'), the sum over reflections to and fro; R, R' the Fresnel reflectances at
    the two directions outside. Symmetric in both, hence reciprocal; equal angles give (1-R)/(1+R).
    """
    first, _ = fresnel(cos_in, 1.0 / index)
    second, _ = fresnel(cos_out, 1.0 / index)
    return (1.0 - first) * (1.0 - second) / (1.0 - first * second)


@kernel
def sheet_passage(sigma, index, dx, dy, dz, rng):
    """Scatter a ray at a thin sheet: (passed, dx, dy, dz).

    (kx, ky) moves by a Gaussian of standard deviation `sigma` each: a kernel symmetric in the two
    directions in projected solid angle. A direction outside the unit disk, or not accepted by
    `sheet_transmittance`, is reflected as by a mirror.
    """
    move_x, move_y = gaussian_pair(rng)
    kx = dx + sigma * move_x
    ky = dy + sigma * move_y
    rest = 1.0 - kx * kx - ky * ky
    accept = uniform(rng)
    if rest <= 0.0:
        return False, dx, dy, -dz
    kz = math.sqrt(rest)
    if accept >= sheet_transmittance(abs(dz), kz, index):
        return False, dx, dy, -dz
    return True, kx, ky, math.copysign(kz, dz)
