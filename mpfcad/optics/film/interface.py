"""A smooth or rough surface between two materials: a ray is reflected or refracted.

A rough one is Gaussian, of a given root mean square slope (Beckmann and Spizzichino, "The
scattering of electromagnetic waves from rough surfaces", 1963), with the heights of its microfacets
independent of each other (Smith, IEEE Trans. Antennas Propag. 15, 1967). A ray walks from one
microfacet to the next, as often as the surface's own shadow makes it, and each is a smooth
interface (Heitz, Hanika, d'Eon, Dachsbacher, "Multiple-scattering microfacet BSDFs with the Smith
model", ACM Trans. Graph. 35, 2016). So no light is lost, and light passes both ways alike.

A height counts by the share of the surface that lies below it (`level`, 0 … 1): the walk depends
on nothing else of the heights.
"""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import frame, gaussian_pair, uniform
from mpfcad.optics.stokes.interface import meet_interface

#: Microfacets after which a ray is taken to leave the surface.
_MOST = 10_000
#: Slopes beyond which a Gaussian holds nothing that counts, in standard deviations.
_FAR = 8.0
_HALVINGS = 48
#: Λ of a direction that nothing blocks.
_LEAST = 1e-300


@kernel
def unit(dx, dy, dz):
    """Return a direction, or eight, of a length that is 1 to rounding, as 1 to its own (Newton).

    Else the rounding of thousands of total reflections would add up, and with it the distances that
    are measured along the direction would be wrong.
    """
    factor = 1.5 - 0.5 * (dx * dx + dy * dy + dz * dz)
    return factor * dx, factor * dy, factor * dz


@kernel
def interface(ratio, slope, nx, ny, nz, dx, dy, dz, light, rng):
    """Pass or reflect a ray at a surface of unit normal n: (mirrored, dx, dy, dz).

    `ratio`: index on the ray's side over that beyond; `slope`: root mean square slope of the
    surface in each direction, 0 where it is smooth.
    """
    if slope > 0.0 and ratio != 1.0:
        return _rough(ratio, slope, nx, ny, nz, dx, dy, dz, light, rng)
    approach = dx * nx + dy * ny + dz * nz
    cos_in = min(1.0, abs(approach))
    mirrored, cos_out = meet_interface(cos_in, ratio, nx, ny, nz, dx, dy, dz, light, rng)
    bend = -2.0 * approach if mirrored else math.copysign(cos_out, approach) - ratio * approach
    scale = 1.0 if mirrored else ratio
    dx, dy, dz = unit(scale * dx + bend * nx, scale * dy + bend * ny, scale * dz + bend * nz)
    return mirrored, dx, dy, dz


@kernel
def _rough(ratio, slope, nx, ny, nz, dx, dy, dz, light, rng):
    """Pass or reflect a ray at a rough surface, as `interface` does.

    In the surface's own axes w is the direction, its third component along the normal of the side
    on which the ray is.
    """
    side = -1.0 if dx * nx + dy * ny + dz * nz > 0.0 else 1.0
    ax, ay, az = frame(nx, ny, nz, 1.0, 0.0, 0.0)
    bx, by, bz = frame(nx, ny, nz, 0.0, 1.0, 0.0)
    wx, wy = dx * ax + dy * ay + dz * az, dx * bx + dy * by + dz * bz
    wz = side * (dx * nx + dy * ny + dz * nz)
    mirrored, level = True, 1.0
    for _ in range(_MOST):
        level *= (1.0 - uniform(rng)) ** (-1.0 / shadow(wx, wy, wz, slope))
        if wz > 0.0 and not level < 1.0:
            break
        mx, my, mz = microfacet(-wx, -wy, -wz, slope, rng)
        approach = wx * mx + wy * my + wz * mz
        # Normal and direction in the scene's axes, to which the light's state refers.
        kx, ky, kz = in_axes(wx, wy, side * wz, ax, ay, az, bx, by, bz, nx, ny, nz)
        sx, sy, sz = in_axes(mx, my, side * mz, ax, ay, az, bx, by, bz, nx, ny, nz)
        back, cos_out = meet_interface(
            min(1.0, abs(approach)), ratio, sx, sy, sz, kx, ky, kz, light, rng
        )
        if back:
            bend = -2.0 * approach
            wx, wy, wz = unit(wx + bend * mx, wy + bend * my, wz + bend * mz)
            continue
        bend = -cos_out - ratio * approach
        wx, wy, wz = unit(ratio * wx + bend * mx, ratio * wy + bend * my, ratio * wz + bend * mz)
        # On the other side the surface lies upside down.
        wz, level, ratio, side, mirrored = -wz, 1.0 - level, 1.0 / ratio, -side, not mirrored
    dx, dy, dz = in_axes(wx, wy, side * wz, ax, ay, az, bx, by, bz, nx, ny, nz)
    return mirrored, dx, dy, dz


@kernel
def in_axes(u, v, w, ax, ay, az, bx, by, bz, nx, ny, nz):
    """Return u a + v b + w n."""
    return (
        u * ax + v * bx + w * nx,
        u * ay + v * by + w * ny,
        u * az + v * bz + w * nz,
    )


@kernel
def shadow(wx, wy, wz, slope):
    """Return Smith's Λ of a direction: of a level l, the share l^Λ of the rays leaves unblocked.

    With a = cot θ / (√2 slope): Λ = exp(-a²)/(2 a √π) - erfc(a)/2, and -1 - Λ(-a) downward.
    """
    spread = math.sqrt(2.0 * (wx * wx + wy * wy)) * slope
    a = abs(wz) / spread if spread > 0.0 else _FAR
    blocked = _LEAST
    if a == 0.0:
        blocked = math.inf
    elif a < _FAR:
        blocked += math.exp(-a * a) / (2.0 * a * math.sqrt(math.pi)) - 0.5 * math.erfc(a)
    return blocked if wz > 0.0 else -1.0 - blocked


@kernel
def microfacet(wx, wy, wz, slope, rng):
    """Return the unit normal of a microfacet that is seen from a direction w.

    Of the slopes s along w and q across it, in units of `slope`, q is Gaussian, and s has the
    density (A - s) φ(s) up to A = cot θ / slope: its share up to s is A Φ(s) + φ(s), over its all.
    """
    sine = math.sqrt(wx * wx + wy * wy)
    across, _ = gaussian_pair(rng)
    share = uniform(rng)
    cosine, turn = (wx / sine, wy / sine) if sine > 0.0 else (1.0, 0.0)
    edge = wz / (slope * sine) if sine > 0.0 else math.inf
    low, high = -_FAR, min(edge, _FAR)
    if edge > 1e6:
        edge = 1e6
    wanted = share * _seen(edge, high)
    if high <= low:
        low = high - 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _seen(edge, middle) < wanted:
            low = middle
        else:
            high = middle
    along, across = slope * 0.5 * (low + high), slope * across
    scale = 1.0 / math.sqrt(1.0 + along * along + across * across)
    return (
        -scale * (along * cosine - across * turn),
        -scale * (along * turn + across * cosine),
        scale,
    )


@kernel
def _seen(edge, s):
    """Return how much is seen of the slopes up to s (in standard deviations): A Φ(s) + φ(s)."""
    density = math.exp(-0.5 * s * s) / math.sqrt(2.0 * math.pi)
    return edge * 0.5 * math.erfc(-s / math.sqrt(2.0)) + density
