"""A ray against triangles, eight at a time, in double precision, watertight along shared edges."""

from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import select
from mpfcad.optics.lanes_array import load


@kernel
def edge_product(dx, dy, dz, ax, ay, az, bx, by, bz):
    """Return d · (a × b): the side on which a ray from the origin passes the edge a→b.

    Exactly antisymmetric in a and b, so that two facets that share an edge never both miss a ray.
    """
    return dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)


@kernel
def triangle_distances(corner, row, ox, oy, oz, dx, dy, dz, side):
    """Return the distances along a ray to eight facets, infinite where one is missed.

    Nine rows of `corner` (…, 8) float64 [mm] from `row` on hold the corners, x, y, z each,
    anticlockwise from outside. With `side` = 1 only facets that the ray leaves through count
    (d·n > 0), with -1 only those it enters through. A NaN is a miss.
    """
    ax, ay, az = load(corner, row) - ox, load(corner, row + 1) - oy, load(corner, row + 2) - oz
    bx, by, bz = load(corner, row + 3) - ox, load(corner, row + 4) - oy, load(corner, row + 5) - oz
    cx, cy, cz = load(corner, row + 6) - ox, load(corner, row + 7) - oy, load(corner, row + 8) - oz
    return facet_distances(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, side)


@kernel
def facet_distances(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, side):
    """Return the distance along a ray from the origin to a facet, or of eight rays to eight."""
    u = side * edge_product(dx, dy, dz, bx, by, bz, cx, cy, cz)
    v = side * edge_product(dx, dy, dz, cx, cy, cz, ax, ay, az)
    w = side * edge_product(dx, dy, dz, ax, ay, az, bx, by, bz)
    total = u + v + w
    met = (u >= 0.0) & (v >= 0.0) & (w >= 0.0) & (total > 0.0)
    px = (u * ax + v * bx + w * cx) / total
    py = (u * ay + v * by + w * cy) / total
    pz = (u * az + v * bz + w * cz) / total
    return select(met, px * dx + py * dy + pz * dz, float("inf"))
