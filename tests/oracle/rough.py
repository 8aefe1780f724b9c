"""The oracle's rough surface: the walk over Smith's microfacets, in plain Python.

The heights are those of a surface whose heights are even between -1 and 1, and shadow and seen
slopes are integrals done by quadrature or root finding, not the kernels' closed forms.
"""

import math

from scipy.optimize import brentq

from oracle.ray import Philox, Vector, about, dot, refract


def rough_interface(
    n_in: float, n_out: float, slope: float, n: Vector, d: Vector, rng: Philox
) -> tuple[bool, Vector]:
    """Pass or reflect a ray at a rough surface of unit normal n: (passed, direction)."""
    axes = about(n, 0.0, 0.0), about(n, 0.0, math.pi / 2), n
    # In the surface's axes, the third of which points to the side on which the ray is.
    side = 1.0 if dot(d, n) < 0 else -1.0
    w = (dot(d, axes[0]), dot(d, axes[1]), side * dot(d, n))
    passed, height = False, 1.0
    while True:
        height = _next_height(w, height, slope, rng())
        if height >= 1:
            break
        m = _microfacet(tuple(-c for c in w), slope, rng)
        if rng.reflects(_in_axes(w, side, axes), _in_axes(m, side, axes), n_in, n_out):
            w = tuple(a - 2 * dot(w, m) * b for a, b in zip(w, m, strict=True))
            continue
        w = refract(w, m, n_in, n_out)
        w, height, side = (w[0], w[1], -w[2]), -height, -side
        n_in, n_out, passed = n_out, n_in, not passed
    return passed, _in_axes(w, side, axes)


def _in_axes(w: Vector, side: float, axes: tuple[Vector, Vector, Vector]) -> Vector:
    """Return a vector of the surface's axes in the scene's."""
    up = side * w[2]
    return tuple(w[0] * a + w[1] * b + up * c for a, b, c in zip(*axes, strict=True))


def _next_height(w: Vector, height: float, slope: float, u: float) -> float:
    """Return the height at which a ray meets the surface next; 1 and more: it leaves."""
    below, shadow = (1 + height) / 2, _shadow(w, slope)
    grown = -math.log(1 - u) / shadow if shadow else math.inf
    return 2 * below * math.exp(grown) - 1 if grown < 700 else math.inf


def _shadow(w: Vector, slope: float) -> float:
    """Return Λ: the mean of the slopes beyond the ray's own, over that one (Smith)."""
    sine = math.hypot(w[0], w[1])
    own = w[2] / (sine * slope)
    if own > 8 * math.sqrt(2):
        return 0.0
    beyond = _density(own) - own * _share(-own)
    return beyond / own


def _microfacet(w: Vector, slope: float, rng: Philox) -> Vector:
    """Return a microfacet's normal as seen from w, by the share seen of lesser slopes."""
    radius = math.sqrt(-2 * math.log(1 - rng()))
    across = radius * math.cos(2 * math.pi * rng())
    share = rng()
    sine = math.hypot(w[0], w[1])
    edge = w[2] / (slope * sine)

    def seen(s: float) -> float:
        return edge * _share(s) + _density(s)

    high = min(edge, 8.0)
    along = brentq(lambda s: seen(s) - share * seen(high), -8.0, high, xtol=1e-14, rtol=1e-15)
    x, y = w[0] / sine, w[1] / sine
    p = slope * (along * x - across * y)
    q = slope * (along * y + across * x)
    size = math.sqrt(1 + p * p + q * q)
    return (-p / size, -q / size, 1 / size)


def _density(s: float) -> float:
    return math.exp(-s * s / 2) / math.sqrt(2 * math.pi)


def _share(s: float) -> float:
    return math.erfc(-s / math.sqrt(2)) / 2
