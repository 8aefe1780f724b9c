"""The polarisation of a path: the Stokes vectors that four meters would send out along it.

A path runs from the meter to the lamps. What a meter of the row vector D (an analyser) sees is
D M₁ M₂ … S, and rows are multiplied from the left as the path goes. The Mueller matrix of the way
back is Q Mᵀ Q with Q = diag(1, 1, -1, 1) (Sekera, "Scattering matrices and reciprocity
relationships for various representations of the state of polarization", JOSA 56, 1966). So in the
axes (e, d × e) of the path's own direction d a row D changes as the Stokes vector of light that the
meter sends out. One set of kernels therefore serves paths from the meter and paths from the lamps.

Four rows go along: the plain meter's (1, 0, 0, 0), by which the path is drawn, and those that read
Q, U and V of the light. No row's intensity exceeds the first's, which is kept at 1, so weights stay
bounded. Where light is depolarised all rows become alike, and the first alone is followed on.

Conventions (Born and Wolf; Collett, "Polarized light", 1993): exp(-iωt); Q > 0 is light along e;
U + iV = 2 E₁ E₂*.
"""

import math

from mpfcad.optics.base.kernel import kernel

#: Shape of `light`: four rows (I, Q, U, V), then the axis e and whether all rows are alike.
LIGHT_SHAPE = (5, 4)
ROWS, AXIS = 4, 4
#: In the row `AXIS`, after the three components of e: not 0 where all rows are alike.
ALIKE = 3


@kernel
def start_light(light, rows, dx, dy, dz):
    """Set the state to the four meters that look along d.

    Q is what passes a polariser along y, as the grooves of a film run, less what passes one along
    x: e = d × x. U is the same at 45° from y, anticlockwise seen from above, and across. The rows
    are Q of `state` above, as the light comes along -d. Of a single of the `rows`, the plain
    meter's, no other is followed.
    """
    for i in range(ROWS):
        for j in range(4):
            light[i, j] = 1.0 if i == j else 0.0
    light[2, 2] = -1.0
    light[AXIS, ALIKE] = 1.0 if rows == 1 else 0.0
    norm = math.sqrt(dy * dy + dz * dz)
    if norm > 0.0:
        set_axis(light, 0.0, dz / norm, -dy / norm)
    else:
        set_axis(light, 0.0, 1.0, 0.0)


@kernel
def set_axis(light, ex, ey, ez):
    """Set the axis e to which the rows refer."""
    light[AXIS, 0], light[AXIS, 1], light[AXIS, 2] = ex, ey, ez


@kernel
def depolarise(light):
    """Make the light unpolarised and leave its intensities; nothing happens without a state."""
    if light is not None:
        for i in range(live_rows(light)):
            light[i, 1], light[i, 2], light[i, 3] = 0.0, 0.0, 0.0
        light[AXIS, ALIKE] = 1.0


@kernel
def keep_rows(light, kept):
    """Keep what each meter sees, for a path that starts again unpolarised (`take_rows`)."""
    if light is not None:
        for i in range(ROWS):
            kept[i] = light[i, 0]


@kernel
def take_rows(light, kept):
    """Set the state to unpolarised light of which each meter sees what was kept."""
    if light is not None:
        for i in range(ROWS):
            light[i, 0] = kept[i]
        light[AXIS, ALIKE] = 0.0
        depolarise(light)


@kernel
def refer_to(light, sx, sy, sz, dx, dy, dz):
    """Refer the rows to the axis s, a unit vector across the direction d."""
    ex, ey, ez = light[AXIS, 0], light[AXIS, 1], light[AXIS, 2]
    along = ex * sx + ey * sy + ez * sz
    fx, fy, fz = dy * ez - dz * ey, dz * ex - dx * ez, dx * ey - dy * ex
    aside = fx * sx + fy * sy + fz * sz
    norm = along * along + aside * aside
    set_axis(light, sx, sy, sz)
    if norm == 0.0:
        return
    cosine = (along * along - aside * aside) / norm
    sine = 2.0 * along * aside / norm
    for i in range(live_rows(light)):
        q, u = light[i, 1], light[i, 2]
        light[i, 1], light[i, 2] = cosine * q + sine * u, cosine * u - sine * q


@kernel
def live_rows(light):
    """Return how many rows change apart from each other."""
    return ROWS if light[AXIS, ALIKE] == 0.0 else 1


@kernel
def change(light, a, b, c, s):
    """Multiply the rows by a Mueller matrix, and divide them by the first's intensity after it.

    [[a, b, 0, 0], [b, a, 0, 0], [0, 0, c, s], [0, 0, -s, c]]: what has the axes (e, d × e), such as
    an interface or a polariser. Returns that intensity.
    """
    passed = a + b * light[0, 1]
    if passed <= 0.0:
        depolarise(light)
        return 0.0
    scale = 1.0 / passed
    for i in range(live_rows(light)):
        one, q, u, v = light[i, 0], light[i, 1], light[i, 2], light[i, 3]
        light[i, 0], light[i, 1] = scale * (a * one + b * q), scale * (b * one + a * q)
        light[i, 2], light[i, 3] = scale * (c * u + s * v), scale * (c * v - s * u)
    return passed


@kernel
def mirror_light(light, mx, my, mz):
    """Reflect the state as a perfect mirror across the unit vector m: U and V change sign."""
    if light is not None:
        ex, ey, ez = light[AXIS, 0], light[AXIS, 1], light[AXIS, 2]
        twice = 2.0 * (ex * mx + ey * my + ez * mz)
        set_axis(light, ex - twice * mx, ey - twice * my, ez - twice * mz)
        for i in range(live_rows(light)):
            light[i, 2], light[i, 3] = -light[i, 2], -light[i, 3]


@kernel
def turn_light(light, cosine, sine, flipped):
    """Turn the axis as `film.passage.into_film` turns a ray: about z, then upside down."""
    if light is not None:
        ex, ey, ez = light[AXIS, 0], light[AXIS, 1], light[AXIS, 2]
        ex, ey = cosine * ex + sine * ey, cosine * ey - sine * ex
        if flipped:
            ex, ez = -ex, -ez
        set_axis(light, ex, ey, ez)


@kernel
def turn_light_back(light, cosine, sine, flipped):
    """Turn the axis back, as `film.passage.out_of_film` turns a ray."""
    if light is not None:
        ex, ey, ez = light[AXIS, 0], light[AXIS, 1], light[AXIS, 2]
        if flipped:
            ex, ez = -ex, -ez
        set_axis(light, cosine * ex - sine * ey, cosine * ey + sine * ex, ez)


@kernel
def fade(light, share):
    """Leave `share` of the polarisation: a depolariser that is alike for all states."""
    if share == 0.0:
        depolarise(light)
    elif light is not None:
        for i in range(live_rows(light)):
            light[i, 1], light[i, 2] = share * light[i, 1], share * light[i, 2]
            light[i, 3] *= share


@kernel
def scatter_light(light, passed, dx, dy, dz, kx, ky, kz):
    """Carry the state from direction d to k, by the least turn or, not `passed`, as by a mirror.

    The rotation that takes d to k takes e to e - (e·k)/(1 + d·k) (d + k) (parallel transport).
    """
    if light is not None:
        if passed:
            ex, ey, ez = light[AXIS, 0], light[AXIS, 1], light[AXIS, 2]
            part = (ex * kx + ey * ky + ez * kz) / (1.0 + dx * kx + dy * ky + dz * kz)
            set_axis(light, ex - part * (dx + kx), ey - part * (dy + ky), ez - part * (dz + kz))
        else:
            mirror_light(light, 0.0, 0.0, 1.0)
