"""Rays in lanes at a surface of a film: Fresnel or total reflection, as `film.interface`."""

from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import copy_sign, magnitude, select


@kernel
def pass_facet(index, number, slope, nz, against, dx, dy, dz, met, inside):
    """Pass or reflect rays that have met a segment: (dx, dy, dz, passed).

    `number` (uniform) chooses; the segment has the upward normal (-slope, 1) · nz, and `against` is
    the direction's product with (-slope, 1).
    """
    approach = against * nz
    size = magnitude(approach)
    ratio = select(inside, index, 1.0 / index)
    reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
    mirrored = number < reflectance
    bend = select(mirrored, -2.0 * approach, copy_sign(cos_out, approach) - ratio * approach)
    bend = select(met, bend * nz, 0.0)
    passed = met & (mirrored ^ True)
    scale = select(passed, ratio, 1.0)
    return scale * dx - bend * slope, scale * dy, scale * dz + bend, passed


@kernel
def pass_underside(ratio, number, dx, dy, dz, meets):
    """Pass or reflect rays that meet the flat underside: (dx, dy, dz, mirrored)."""
    size = magnitude(dz)
    reflectance, cos_out = fresnel(select(size < 1.0, size, 1.0), ratio)
    mirrored = number < reflectance
    scale = select(meets & (mirrored ^ True), ratio, 1.0)
    turned = select(mirrored, -dz, copy_sign(cos_out, dz))
    return scale * dx, scale * dy, select(meets, turned, dz), mirrored
