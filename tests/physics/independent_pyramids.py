"""The light of a field of pyramids, by a calculation that shares nothing with the tracer.

Whole arrays of rays in numpy, cell by cell; a pyramid is four planes of a formula, not facets of a
mesh; numpy's own random numbers. The field is endless or ends in upright sides.
"""

import numpy as np


def pyramid_values(index, base, pitch, height, lambertian, rays, seed, cells=None):
    """Return (mean, standard error) of the light that reaches what lies under the film, 0…1.

    Rays come down on the middle cell, Lambertian or exactly along the normal: by reciprocity the
    transmittance for Lambertian light, and the normal luminance over a radiance of 1, from below.
    Over `cells` (odd) cells a side the film ends: what leaves it sideways and downward reaches
    what shines, which goes on there. pitch, height of a pyramid, base under its foot [mm].
    """
    rng = np.random.default_rng(seed)
    half, top = pitch / 2, base + height
    slope = np.array([height, half]) / np.hypot(height, half)
    planes = np.array([[slope[0], 0, slope[1]], [-slope[0], 0, slope[1]],
                       [0, slope[0], slope[1]], [0, -slope[0], slope[1]]])  # fmt: skip
    level = top * slope[1]
    p = np.empty((rays, 3))
    p[:, :2] = (rng.random((rays, 2)) - 0.5) * pitch
    p[:, 2] = top
    d = np.zeros((rays, 3))
    if lambertian:
        k, angle = np.sqrt(rng.random(rays)), 2 * np.pi * rng.random(rays)
        d[:, 0], d[:, 1] = k * np.cos(angle), k * np.sin(angle)
    d[:, 2] = -np.sqrt(1 - d[:, 0] ** 2 - d[:, 1] ** 2)
    cell, inside, reached = np.zeros((rays, 2), int), np.zeros(rays, bool), 0
    last = np.inf if cells is None else cells // 2
    while len(p):
        n = len(p)
        here = np.arange(n)
        with np.errstate(divide="ignore", invalid="ignore"):
            toward = d @ planes.T
            to_plane = (level - p @ planes.T) / toward
            enter = np.where(toward < 0, to_plane, -np.inf)
            leave = np.where(toward > 0, to_plane, np.inf)
            to_side = np.where(d[:, :2] == 0, np.inf, (np.sign(d[:, :2]) * half - p[:, :2])
                               / d[:, :2])  # fmt: skip
            floor = np.where(inside & (d[:, 2] < 0), -p[:, 2] / d[:, 2], np.inf)
            # In air a ray above all tips is gone.
            above = np.where(~inside & (d[:, 2] > 0), (top - p[:, 2]) / d[:, 2], np.inf)
        facet = np.where(inside, leave.argmin(axis=1), enter.argmax(axis=1))
        hit = np.where(inside, leave[here, facet], enter[here, facet])
        meets = inside | ((hit <= leave.min(axis=1)) & (hit > -1e-12))
        hit = np.maximum(np.where(meets, hit, np.inf), 0)
        axis = to_side.argmin(axis=1)
        side, floor, above = (np.maximum(v, 0) for v in (to_side[here, axis], floor, above))
        step = np.min([hit, side, floor, above], axis=0)
        gone = step == above
        at_facet, under = ~gone & (step == hit), ~gone & (step == floor) & (floor < hit)
        cross = ~gone & ~at_facet & ~under
        p = p + np.where(gone, 0, step)[:, None] * d
        way = np.sign(d[here, axis]).astype(int)
        rim = cross & (cell[here, axis] * way >= last)
        open_air = rim & ~inside
        reached += int((open_air & (d[:, 2] < 0)).sum())
        gone |= open_air
        moved = cross & ~rim
        cell[here[moved], axis[moved]] += way[moved]
        p[here[moved], axis[moved]] = -way[moved] * half
        normal = planes[facet]
        normal[under] = 0, 0, -1
        normal[rim] = 0
        normal[here[rim], axis[rim]] = way[rim]
        wall = (at_facet | under | rim) & ~gone
        along = np.einsum("ij,ij->i", d, normal)
        ratio = np.where(inside, index, 1 / index)
        a = np.abs(along).clip(0, 1)
        sine2 = ratio**2 * (1 - a * a)
        b = np.sqrt(np.maximum(1 - sine2, 0))
        s, q = (ratio * a - b) / (ratio * a + b), (ratio * b - a) / (ratio * b + a)
        mirrored = (sine2 >= 1) | (rng.random(n) < (s * s + q * q) / 2)
        back, out = wall & mirrored, wall & ~mirrored
        bent = ratio[:, None] * d + (np.sign(along) * b - ratio * along)[:, None] * normal
        d = np.where(back[:, None], d - 2 * along[:, None] * normal, d)
        d = np.where(out[:, None], bent, d)
        d /= np.linalg.norm(d, axis=1)[:, None]
        inside = inside ^ out
        reached += int((out & under).sum() + (out & rim & (d[:, 2] < 0)).sum())
        stay = ~gone & ~(out & (under | rim))
        p, d, cell, inside = p[stay], d[stay], cell[stay], inside[stay]
    mean = reached / rays
    return mean, np.sqrt(mean * (1 - mean) / rays)
