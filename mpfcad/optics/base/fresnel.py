"""Fresnel reflection and refraction at a smooth dielectric interface, unpolarised light."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import root, select


@kernel
def fresnel(cos_in, index_ratio):
    """Return (reflectance, cosine of the refracted ray) of an interface.

    `cos_in` is the incident ray's cosine to the normal (positive), `index_ratio` the refractive
    index on the ray's side over that beyond. Mean of s and p (Hsieh, MPF thesis, eq. 8):
    R = (r_s² + r_p²)/2; beyond the critical angle (1, 0). One ray or eight (`lanes`).
    """
    sin2_out = index_ratio * index_ratio * (1.0 - cos_in * cos_in)
    total = sin2_out >= 1.0
    cos_out = root(select(total, 0.0, 1.0 - sin2_out))
    # r_s = (n c - c')/(n c + c'), r_p = (c - n c')/(c + n c'), over one denominator.
    near, far = index_ratio * cos_in, index_ratio * cos_out
    s_sum, p_sum = near + cos_out, cos_in + far
    s_part, p_part = (near - cos_out) * p_sum, (cos_in - far) * s_sum
    both = s_sum * p_sum
    reflectance = 0.5 * (s_part * s_part + p_part * p_part) / (both * both)
    return select(total, 1.0, reflectance), cos_out


@kernel
def fresnel_slope(cos_in, index):
    """Return dR/dn of the reflectance of a medium of index n, met from air.

    r_s = (c - q)/(c + q), r_p = (n² c - q)/(n² c + q) with q = √(n² - 1 + c²), dq/dn = n/q.
    """
    q = root(index * index - 1.0 + cos_in * cos_in)
    turned, dense = index / q, index * index * cos_in
    s_sum, p_sum = cos_in + q, dense + q
    s_slope = -2.0 * cos_in * turned / (s_sum * s_sum)
    p_slope = 2.0 * (2.0 * index * cos_in * q - dense * turned) / (p_sum * p_sum)
    return (cos_in - q) / s_sum * s_slope + (dense - q) / p_sum * p_slope
