"""Fresnel reflection and refraction at a smooth dielectric interface, unpolarised light."""

import math

from mpfcad.optics.kernel import kernel


@kernel
def fresnel(cos_in, index_ratio):
    """Return (reflectance, cosine of the refracted ray) of an interface.

    `cos_in` is the incident ray's cosine to the normal (positive), `index_ratio` the refractive
    index on the ray's side over that beyond. Mean of s and p (Hsieh, MPF thesis, eq. 8):
    R = (r_s² + r_p²)/2; beyond the critical angle (1, 0).
    """
    sin2_out = index_ratio * index_ratio * (1.0 - cos_in * cos_in)
    if sin2_out >= 1.0:
        return 1.0, 0.0
    cos_out = math.sqrt(1.0 - sin2_out)
    r_s = (index_ratio * cos_in - cos_out) / (index_ratio * cos_in + cos_out)
    r_p = (cos_in - index_ratio * cos_out) / (cos_in + index_ratio * cos_out)
    return 0.5 * (r_s * r_s + r_p * r_p), cos_out
