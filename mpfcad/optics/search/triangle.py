"""A ray against triangles, eight at a time, in double precision, watertight at edges and vertices.

Corners are projected along the ray onto the plane across the axis that it is most parallel to, each
by itself, and the sides on which the ray passes are those of the projected edges (Woop, Benthin and
Wald, "Watertight ray/triangle intersection", 2013). Rounding moves a projected corner for all its
facets alike, and the rounded difference of two rounded products has their sign or is 0: so of the
facets about an edge or a vertex at least one meets the ray.
"""

from typing import NamedTuple

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import copy_sign, magnitude, root, select

#: How far behind its start a ray may meet a facet that it starts over by rounding, in roundings.
BEHIND = 1e4

#: The rounding of places in a tile times this is more than any of its edges, seen along any ray.
_LONGEST = 1e15


class Aim(NamedTuple):
    """A ray's projection; of one ray or eight.

    Attributes
    ----------
    by_x, by_y
        whether it is most parallel to x, to y; else to z
    shear_0, shear_1, inverse
        slopes against that axis of the two that follow it in turn, and 1 over the direction on it
    sense
        1 where facets that count are anticlockwise in the projection, else -1
    """

    by_x: bool
    by_y: bool
    shear_0: float
    shear_1: float
    inverse: float
    sense: float


@kernel
def aim_at(dx, dy, dz, side):
    """Return the aim of a ray: at facets that it leaves through (`side` 1), or enters (-1)."""
    across, along, up = magnitude(dx), magnitude(dy), magnitude(dz)
    by_x = (across > along) & (across > up)
    by_y = (by_x ^ True) & (along > up)
    first, second, main = turned(by_x, by_y, dx, dy, dz)
    inverse = 1.0 / main
    return Aim(by_x, by_y, first * inverse, second * inverse, inverse, copy_sign(1.0, main) * side)


@kernel
def turned(by_x, by_y, x, y, z):
    """Return (x, y, z) turned so that the axis projected along comes last."""
    return (
        select(by_x, y, select(by_y, z, x)),
        select(by_x, z, select(by_y, x, y)),
        select(by_x, x, select(by_y, y, z)),
    )


@kernel
def facet_distance(aim, a, b, c, slack):
    """Return (met, beyond, distance [mm]): whether a ray meets the facet abc, and where.

    Corners are relative to the ray's start and `turned`, anticlockwise from outside. Only facets
    that the ray is aimed at count; a NaN is a miss. `beyond`: the ray passes beyond an edge, by far
    less than anything but how far is left to `on_edge`.
    """
    u, v, w = _sides(aim, a, b, c)
    rim = -slack * (slack * _LONGEST)
    met = (u >= rim) & (v >= rim) & (w >= rim) & (u + v + w > 0.0)
    beyond = (u < 0.0) | (v < 0.0) | (w < 0.0)
    u, v, w = select(u > 0.0, u, 0.0), select(v > 0.0, v, 0.0), select(w > 0.0, w, 0.0)
    distance = (u * a[2] + v * b[2] + w * c[2]) / (u + v + w) * aim.inverse
    return met, beyond, distance


@kernel
def _projected(aim, corner):
    return corner[0] - aim.shear_0 * corner[2], corner[1] - aim.shear_1 * corner[2]


@kernel
def _sides(aim, a, b, c):
    """Return the side on which a ray passes each edge, above 0 inside: bc, ca and ab."""
    a, b, c = _projected(aim, a), _projected(aim, b), _projected(aim, c)
    return (
        aim.sense * (b[0] * c[1] - b[1] * c[0]),
        aim.sense * (c[0] * a[1] - c[1] * a[0]),
        aim.sense * (a[0] * b[1] - a[1] * b[0]),
    )


@kernel
def on_edge(aim, a, b, c, slack):
    """Return whether a ray passes no edge of a facet by more than `slack` [mm].

    One that is turned on an edge may start as far beyond it.
    """
    u, v, w = _sides(aim, a, b, c)
    a, b, c = _projected(aim, a), _projected(aim, b), _projected(aim, c)
    near = (u >= -slack * _length(b, c)) & (v >= -slack * _length(c, a))
    return near & (w >= -slack * _length(a, b))


@kernel
def _length(a, b):
    x, y = b[0] - a[0], b[1] - a[1]
    return root(x * x + y * y)
