"""A ray against a triangle in double precision, watertight along shared edges."""

from mpfcad.optics.kernel import kernel


@kernel
def edge_product(dx, dy, dz, ax, ay, az, bx, by, bz):
    """Return d · (a × b): the side on which a ray from the origin passes the edge a→b.

    Exactly antisymmetric in a and b, so that two facets that share an edge never both miss a ray.
    """
    return dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)


@kernel
def triangle_distance(corner, t, ox, oy, oz, dx, dy, dz, side):
    """Return the distance along a ray to facet t, or infinity when it is missed.

    `corner` (n, 9) float64 [mm] holds the corners, anticlockwise from outside. With `side` = 1 only
    facets that the ray leaves through count (d·n > 0), with -1 only those it enters through. A
    NaN is a miss.
    """
    ax, ay, az = corner[t, 0] - ox, corner[t, 1] - oy, corner[t, 2] - oz
    bx, by, bz = corner[t, 3] - ox, corner[t, 4] - oy, corner[t, 5] - oz
    cx, cy, cz = corner[t, 6] - ox, corner[t, 7] - oy, corner[t, 8] - oz
    u = side * edge_product(dx, dy, dz, bx, by, bz, cx, cy, cz)
    v = side * edge_product(dx, dy, dz, cx, cy, cz, ax, ay, az)
    w = side * edge_product(dx, dy, dz, ax, ay, az, bx, by, bz)
    if not (u >= 0.0 and v >= 0.0 and w >= 0.0):
        return float("inf")
    total = u + v + w
    if not total > 0.0:
        return float("inf")
    px = (u * ax + v * bx + w * cx) / total
    py = (u * ay + v * by + w * cy) / total
    pz = (u * az + v * bz + w * cz) / total
    return px * dx + py * dy + pz * dz
