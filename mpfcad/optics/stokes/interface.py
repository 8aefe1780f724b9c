"""A smooth interface: passed or reflected by chance, of unpolarised light or of a state."""

import math

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.stokes.state import change, refer_to

#: Below this squared sine to the normal every plane holds both: s and p are alike.
_NORMAL = 1e-26


@kernel
def meet_interface(cos_in, ratio, nx, ny, nz, dx, dy, dz, light, rng):
    """Return whether a ray is reflected, and the cosine of the refracted one.

    `cos_in` is the ray's cosine to the normal n, positive; `ratio` the index on the ray's side over
    that beyond. Without a state, `light` None, the reflectance is the mean of s and p.
    """
    if light is None:
        reflectance, cos_out = fresnel(cos_in, ratio)
        mirrored = uniform(rng) < reflectance
    else:
        mirrored, cos_out = _meet_polarised(cos_in, ratio, nx, ny, nz, dx, dy, dz, light, rng)
    return mirrored, cos_out


@kernel
def amplitudes(cos_in, ratio):
    """Return (R_s, R_p, cosine, sine, cosine of the refracted ray) of an interface.

    R_s, R_p are the reflectances. r_s r_p* = cosine - i sine, with r_s = (n c - c')/(n c + c') and
    r_p = (c - n c')/(c + n c') (Born and Wolf, 1.5.2), p along k × s before and after. Beyond the
    critical angle c' = i √(n² sin² - 1): both are 1, with a phase between them.
    """
    square = ratio * ratio * (1.0 - cos_in * cos_in)
    if square >= 1.0:
        far = math.sqrt(square - 1.0)
        x, y = ratio * cos_in, far
        p, q = cos_in, ratio * far
        # r_s = (x - iy)²/(x² + y²), and so is r_p of (p, q).
        s_real, s_imaginary, s_norm = x * x - y * y, -2.0 * x * y, x * x + y * y
        p_real, p_imaginary, p_norm = p * p - q * q, -2.0 * p * q, p * p + q * q
        norm = s_norm * p_norm
        cosine = (s_real * p_real + s_imaginary * p_imaginary) / norm
        sine = (s_real * p_imaginary - s_imaginary * p_real) / norm
        return 1.0, 1.0, cosine, sine, 0.0
    cos_out = math.sqrt(1.0 - square)
    r_s = (ratio * cos_in - cos_out) / (ratio * cos_in + cos_out)
    r_p = (cos_in - ratio * cos_out) / (cos_in + ratio * cos_out)
    return r_s * r_s, r_p * r_p, r_s * r_p, 0.0, cos_out


@kernel
def _meet_polarised(cos_in, ratio, nx, ny, nz, dx, dy, dz, light, rng):
    """Return what `meet_interface` does, and change the state."""
    sx, sy, sz = dy * nz - dz * ny, dz * nx - dx * nz, dx * ny - dy * nx
    square = sx * sx + sy * sy + sz * sz
    if square > _NORMAL:
        scale = 1.0 / math.sqrt(square)
        refer_to(light, scale * sx, scale * sy, scale * sz, dx, dy, dz)
    r_s, r_p, cosine, sine, cos_out = amplitudes(cos_in, ratio)
    a, b = 0.5 * (r_s + r_p), 0.5 * (r_s - r_p)
    mirrored = uniform(rng) < a + b * light[0, 1]
    if mirrored:
        change(light, a, b, cosine, sine)
    else:
        change(light, 1.0 - a, -b, math.sqrt((1.0 - r_s) * (1.0 - r_p)), 0.0)
    return mirrored, cos_out
