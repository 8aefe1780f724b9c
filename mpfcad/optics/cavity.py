"""The space under the stack: round lamps in a row over a reflector."""

import math

from mpfcad.optics.kernel import kernel
from mpfcad.optics.sampling import disk, turn, uniform

LAMP, REFLECTOR, OPENING, LOST = range(4)
#: The columns of a cavity in `Scene.parameter`.
HEIGHT, LAMP_PITCH, LAMP_POSITION, LAMP_HEIGHT, LAMP_RADIUS = range(5)
LAMP_LUMINANCE, LAMP_REFLECTANCE, REFLECTANCE, SPECULAR_FRACTION, BRDF = range(5, 10)

#: The lamp number of a ray that starts on no lamp (every whole number near 0 is one).
NO_LAMP = -(2**40)


@kernel
def lamp_hit(x, z, dx, dz, pitch, position, height, radius, own):
    """Return (distance, centre x, number) of the first lamp a ray meets, or (inf, 0, 0).

    Lamps are cylinders along y of `radius`, axes at z = `height`, x = `position` + i·`pitch`. `own`
    is the number i of the lamp that the ray starts on, which as a convex body it cannot meet again,
    or `NO_LAMP`. (x, z) and (dx, dz) are the ray's components across.
    """
    along = dx * dx + dz * dz
    if along == 0.0:
        return math.inf, 0.0, 0
    # The part of the ray at the lamps' level.
    near, far = 0.0, math.inf
    if dz != 0.0:
        a = (height - radius - z) / dz
        b = (height + radius - z) / dz
        near = max(0.0, min(a, b))
        far = max(a, b)
    elif abs(z - height) > radius:
        return math.inf, 0.0, 0
    if far < 0.0:
        return math.inf, 0.0, 0
    start = x + near * dx
    if dx >= 0.0:
        i = math.ceil((start - radius - position) / pitch)
        step = 1
    else:
        i = math.floor((start + radius - position) / pitch)
        step = -1
    for _ in range(1_000_000):
        centre = position + i * pitch
        nearest_approach = (centre - step * radius - x) * step
        if dx == 0.0:
            if abs(centre - x) > radius:
                return math.inf, 0.0, 0
        elif nearest_approach > far * abs(dx):
            return math.inf, 0.0, 0
        if i != own:
            ox, oz = x - centre, z - height
            b = ox * dx + oz * dz
            c = ox * ox + oz * oz - radius * radius
            root = b * b - along * c
            if b < 0.0 and root >= 0.0:
                return (-b - math.sqrt(root)) / along, centre, i
        if dx == 0.0:
            return math.inf, 0.0, 0
        i += step
    return math.inf, 0.0, 0


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
        return LAMP, x + distance * dx, y + distance * dy, z + distance * dz, lamp, centre
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
    cosine = math.sqrt(max(0.0, 1.0 - px * px - py * py))
    return turn(nx, ny, nz, cosine, math.atan2(py, px))


@kernel
def reflector_direction(specular_fraction, dx, dy, dz, rng):
    """Return whether the reflector mirrors a ray, and its direction after: mirrored or Lambertian."""
    if uniform(rng) < specular_fraction:
        return True, dx, dy, -dz
    px, py = disk(rng)
    return False, px, py, math.sqrt(max(0.0, 1.0 - px * px - py * py))
