"""A third calculation of a film's light, for figures that both codes of one house could get wrong.

Shares nothing with the tracer: whole arrays of rays in numpy, in the cross-section, groove by
groove, each ray against every segment of its groove; numpy's own random numbers; the surface is
that of the formulas, not of a mesh file.
"""

import numpy as np


def film_values(groove, index: float, base: float, lambertian: bool, rays: int, seed: int):
    """Return (mean, standard error) of the light that reaches the underside, 0…1.

    Rays come down from above, Lambertian or exactly along the normal: by reciprocity the
    transmittance for Lambertian light, and the normal luminance over a radiance of 1, from below.

    groove: (x, z) [mm] from -w to w; base [mm] under the valleys.
    """
    rng = np.random.default_rng(seed)
    gx, gz = np.array(groove[0]), np.array(groove[1]) + base
    width, high = gx[-1] - gx[0], gz.max()
    ux, uz = np.diff(gx), np.diff(gz)
    length = np.hypot(ux, uz)
    nx, nz = -uz / length, ux / length
    x = rng.random(rays) * width + gx[0]
    z = np.full(rays, high)
    dx, dy = np.zeros(rays), np.zeros(rays)
    if lambertian:
        k = np.sqrt((np.arange(rays) + rng.random(rays)) / rays)
        angle = 2 * np.pi * rng.random(rays)
        dx, dy = k * np.cos(angle), k * np.sin(angle)
    dz = -np.sqrt(1 - dx * dx - dy * dy)
    inside = np.zeros(rays, bool)
    reached = 0
    while len(x):
        # First segment of this groove that the ray leaves through (inside) or enters (outside).
        approach = dx[:, None] * nx + dz[:, None] * nz
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((gx[:-1] - x[:, None]) * nx + (gz[:-1] - z[:, None]) * nz) / approach
            at = x[:, None] + t * dx[:, None]
            flat = z[:, None] + t * dz[:, None]
            share = ((at - gx[:-1]) * ux + (flat - gz[:-1]) * uz) / length**2
        good = (approach > 0) == inside[:, None]
        good &= (t > -1e-12) & (share >= 0) & (share <= 1)
        t = np.where(good, t, np.inf)
        segment = t.argmin(axis=1)
        hit = t[np.arange(len(x)), segment]
        with np.errstate(divide="ignore", invalid="ignore"):
            side = np.where(dx > 0, gx[-1] - x, gx[0] - x) / dx
            level = np.where(dz < 0, np.where(inside, 0 - z, gz.min() - 1e-6 - z), high - z) / dz
        side = np.where(dx == 0, np.inf, side)
        # Upward in air past the tips: gone. Downward inside to z = 0: the underside.
        gone = ~inside & (dz > 0) & (level <= np.minimum(hit, side))
        under = inside & (dz < 0) & (level < np.minimum(hit, side))
        facet = (hit <= side) & ~gone & ~under
        step = np.where(facet, hit, np.where(under, level, side))
        step = np.where(gone, 0, step)
        x, z = x + step * dx, z + step * dz
        # Into the next groove.
        cross = ~facet & ~gone & ~under
        x = np.where(cross, np.where(dx > 0, gx[0], gx[-1]), x)
        z = np.where(under, 0, z)
        ax, az = np.where(facet, nx[segment], 0), np.where(facet, nz[segment], -1)
        cos_in = np.where(facet | under, np.abs(dx * ax + dz * az), 1).clip(0, 1)
        ratio = np.where(inside, index, 1 / index)
        sin2 = ratio**2 * (1 - cos_in**2)
        total = sin2 >= 1
        cos_out = np.sqrt(np.where(total, 0, 1 - sin2))
        rs = (ratio * cos_in - cos_out) / (ratio * cos_in + cos_out)
        rp = (ratio * cos_out - cos_in) / (ratio * cos_out + cos_in)
        mirrored = total | (rng.random(len(x)) < (rs**2 + rp**2) / 2)
        toward = dx * ax + dz * az
        meets = facet | under
        out = meets & ~mirrored
        back = meets & mirrored
        bend = np.where(out, np.sign(toward) * cos_out - ratio * toward, 0)
        bend = np.where(back, -2 * toward, bend)
        scale = np.where(out, ratio, 1)
        dx, dy, dz = scale * dx + bend * ax, scale * dy, scale * dz + bend * az
        reached += int((out & under).sum())
        stay = ~gone & ~(out & under)
        inside = np.where(out, ~inside, inside)[stay]
        x, z, dx, dy, dz = (v[stay] for v in (x, z, dx, dy, dz))
    mean = reached / rays
    return mean, np.sqrt(mean * (1 - mean) / rays)
