"""The space under the stack: round lamps in a row over a reflector."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import any_of, floor, magnitude, root, select
from mpfcad.optics.base.sampling import disk, frame, uniform
from mpfcad.optics.stokes.state import depolarise, mirror_light

LAMP, REFLECTOR, OPENING, LOST = range(4)
#: The columns of a cavity in `Scene.parameter`.
HEIGHT, LAMP_PITCH, LAMP_POSITION, LAMP_HEIGHT, LAMP_RADIUS = range(5)
LAMP_LUMINANCE, LAMP_REFLECTANCE, REFLECTANCE, SPECULAR_FRACTION, BRDF = range(5, 10)

#: The lamp number of a ray that starts on no lamp (every whole number near 0 is one).
NO_LAMP = -(2**40)
#: That of a ray that starts on the reflector.
ON_REFLECTOR = NO_LAMP - 1


@kernel
def lamp_hit(x, z, dx, dz, pitch, position, height, radius, own):
    """Return (distance, centre x, number) of the first lamp a ray meets, or (inf, 0, 0).

    Lamps are cylinders along y of `radius`, axes at z = `height`, x = `position` + i·`pitch`. `own`
    is the number i of the lamp that the ray starts on, which as a convex body it cannot meet again,
    or `NO_LAMP`. (x, z) and (dx, dz) are the ray's components across. One ray or eight; numbers are
    float64.
    """
    along = dx * dx + dz * dz
    slanted = (dz > 0.0) | (dz < 0.0)
    # The part of the ray at the lamps' level.
    a, b = (height - radius - z) / dz, (height + radius - z) / dz
    near, far = select(a < b, a, b), select(a < b, b, a)
    near = select(slanted & (near > 0.0), near, 0.0)
    far = select(slanted, far, select(magnitude(z - height) > radius, -1.0, math.inf))
    ahead = dx >= 0.0
    step = select(ahead, 1.0, -1.0)
    upright = ahead & (dx <= 0.0)
    # The number counted along the ray's way.
    i = step * -floor(((position - x - near * dx) * step + radius) / pitch)
    speed = magnitude(dx)
    looking = (along > 0.0) & (far >= 0.0)
    distance, at, number = along * 0.0 + math.inf, along * 0.0, along * 0.0
    for _ in range(1_000_000):
        centre = position + i * pitch
        past = (centre - step * radius - x) * step > far * speed
        past = select(upright, magnitude(centre - x) > radius, past)
        looking = looking & (past ^ True)
        if not any_of(looking):
            break
        ox, oz = x - centre, z - height
        b = ox * dx + oz * dz
        square = b * b - along * (ox * ox + oz * oz - radius * radius)
        met = looking & ((i > own) | (i < own)) & (b < 0.0) & (square >= 0.0)
        distance = select(met, (-b - root(select(met, square, 0.0))) / along, distance)
        at, number = select(met, centre, at), select(met, i, number)
        looking = looking & ((met | upright) ^ True)
        i = i + step
    return distance, at, number


@kernel
def cavity_hit(parameter, x, y, z, dx, dy, dz, own):
    """Return what a ray in the cavity meets: (what, x, y, z, lamp number, lamp centre x)."""
    top = parameter[HEIGHT]
    pitch, position = parameter[LAMP_PITCH], parameter[LAMP_POSITION]
    height, radius = parameter[LAMP_HEIGHT], parameter[LAMP_RADIUS]
    distance, centre, lamp = lamp_hit(x, z, dx, dz, pitch, position, height, radius, own)
    to_plane = math.inf
    if dz != 0.0:
        to_plane = ((top if dz > 0.0 else 0.0) - z) / dz
    if distance < to_plane:
        return LAMP, x + distance * dx, y + distance * dy, z + distance * dz, int(lamp), centre
    if to_plane == math.inf:
        return LOST, x, y, z, 0, 0.0
    x += to_plane * dx
    y += to_plane * dy
    if dz > 0.0:
        return OPENING, x, y, top, 0, 0.0
    return REFLECTOR, x, y, 0.0, 0, 0.0


@kernel
def lambertian(nx, ny, nz, rng):
    """Return a direction drawn with the cosine to the normal n as density."""
    px, py = disk(rng)
    return frame(nx, ny, nz, px, py, math.sqrt(max(0.0, 1.0 - px * px - py * py)))


@kernel
def reflector_direction(specular_fraction, dx, dy, dz, light, rng):
    """Return whether the reflector mirrors a ray (else Lambertian), and its direction after."""
    if uniform(rng) < specular_fraction:
        mirror_light(light, 0.0, 0.0, 1.0)
        return True, dx, dy, -dz
    depolarise(light)
    px, py = disk(rng)
    return False, px, py, math.sqrt(max(0.0, 1.0 - px * px - py * py))


@kernel
def tube_start(parameter, rng):
    """Return (x, z, dx, dy, dz) on the tube at `LAMP_POSITION`: a cosine about its normal."""
    angle = 2.0 * math.pi * uniform(rng)
    nx, nz = math.cos(angle), math.sin(angle)
    dx, dy, dz = lambertian(nx, 0.0, nz, rng)
    z = parameter[LAMP_HEIGHT] + parameter[LAMP_RADIUS] * nz
    x = parameter[LAMP_POSITION] + parameter[LAMP_RADIUS] * nx
    return x, z, dx, dy, dz
