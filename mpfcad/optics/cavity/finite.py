"""The space under a finite panel: walls at its four edges, lamps one by one, of finite length.

Bodies are convex and the box is seen from inside, so a ray can meet neither the lamp nor the wall
that it starts on: no offset is needed.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.cavity.endless import (
    HEIGHT,
    LAMP,
    LAMP_HEIGHT,
    LAMP_RADIUS,
    LOST,
    OPENING,
    REFLECTOR,
    lambertian,
)
from mpfcad.optics.stokes.state import depolarise, mirror_light

NO_WALL = np.array([-np.inf, np.inf, -np.inf, np.inf, 0.0, 0.0, np.inf])
#: The columns of `Panel.arrays`: of the walls, and of each lamp.
LEFT, RIGHT, NEAR, FAR, WALL_REFLECTANCE, WALL_SPECULAR_FRACTION, HALF_LAMP = range(7)
POSITION, FACTOR, SHARE = range(3)
LAMP_END, WALL_ACROSS, WALL_ALONG = range(LOST + 1, LOST + 4)


@dataclass(frozen=True)
class Panel:
    """The edges of a finite backlight and its lamps; lengths in mm.

    Attributes
    ----------
    left, right, near, far
        x and y of the walls; beside them everything above the cavity is black
    lamp_position, lamp_factor
        x of each lamp's axis; its luminance as a multiple of the cavity's `lamp_luminance`
    lamp_length
        of the tubes, about y = 0; the walls cut off what is longer
    wall_reflectance, wall_specular_fraction
        of the walls 0…1; the mirror-like part of it 0…1, the rest is Lambertian
    """

    left: float
    right: float
    near: float
    far: float
    lamp_position: tuple[float, ...]
    lamp_factor: tuple[float, ...]
    lamp_length: float
    wall_reflectance: float
    wall_specular_fraction: float

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return what the kernels read of it: walls (7,), lamps (l, 3) float64.

        Walls: left, right, near, far, reflectance, specular share, half the lamps' length. Lamps:
        position, factor, share of all light that this lamp and those before it give.
        """
        wall, lamp = NO_WALL.copy(), np.zeros((len(self.lamp_position), 3))
        wall[LEFT], wall[RIGHT], wall[NEAR], wall[FAR] = self.left, self.right, self.near, self.far
        wall[WALL_REFLECTANCE] = self.wall_reflectance
        wall[WALL_SPECULAR_FRACTION] = self.wall_specular_fraction
        wall[HALF_LAMP] = self.lamp_length / 2
        factor = np.array(self.lamp_factor, np.float64)
        lamp[:, POSITION], lamp[:, FACTOR] = self.lamp_position, factor
        lamp[:, SHARE] = np.cumsum(factor) / max(factor.sum(), 1e-300)
        return wall, lamp


@kernel
def rod_hit(x, y, z, dx, dy, dz, centre, height, radius, half):
    """Return (distance, whether at an end) of a lamp that a ray meets, or (inf, False).

    The lamp is a cylinder along y about (centre, height) from y = -`half` to `half`, closed by flat
    ends; the ray starts outside it.
    """
    ox, oz = x - centre, z - height
    along = dx * dx + dz * dz
    b = ox * dx + oz * dz
    c = ox * ox + oz * oz - radius * radius
    root = b * b - along * c
    if abs(y) > half and y * dy < 0.0:
        distance = (abs(y) - half) / abs(dy)
        ex, ez = ox + distance * dx, oz + distance * dz
        if ex * ex + ez * ez <= radius * radius:
            return distance, True
    if b >= 0.0 or root < 0.0:
        return math.inf, False
    distance = (-b - math.sqrt(root)) / along
    if abs(y + distance * dy) > half:
        return math.inf, False
    return distance, False


@kernel
def panel_hit(parameter, wall, lamp, x, y, z, dx, dy, dz, own):
    """Return what a ray under a finite panel meets: (what, x, y, z, lamp number, lamp centre x).

    `parameter` is the cavity's; `wall` and `lamp` the scene's; `own` the lamp that the ray starts
    on, or `NO_LAMP`.
    """
    best, end, number = math.inf, False, -1
    height, radius, half = parameter[LAMP_HEIGHT], parameter[LAMP_RADIUS], wall[HALF_LAMP]
    for i in range(len(lamp)):
        if i == own:
            continue
        distance, at_end = rod_hit(x, y, z, dx, dy, dz, lamp[i, POSITION], height, radius, half)
        if distance < best:
            best, end, number = distance, at_end, i
    to_z, to_x, to_y = math.inf, math.inf, math.inf
    if dz != 0.0:
        to_z = max(0.0, ((parameter[HEIGHT] if dz > 0.0 else 0.0) - z) / dz)
    if dx != 0.0:
        to_x = max(0.0, ((wall[RIGHT] if dx > 0.0 else wall[LEFT]) - x) / dx)
    if dy != 0.0:
        to_y = max(0.0, ((wall[FAR] if dy > 0.0 else wall[NEAR]) - y) / dy)
    nearest = min(to_x, to_y, to_z)
    if best < nearest:
        what = LAMP_END if end else LAMP
        return what, x + best * dx, y + best * dy, z + best * dz, number, lamp[number, POSITION]
    if nearest == math.inf:
        return LOST, x, y, z, 0, 0.0
    x = min(max(x + nearest * dx, wall[LEFT]), wall[RIGHT])
    y = min(max(y + nearest * dy, wall[NEAR]), wall[FAR])
    if to_z <= nearest:
        if dz > 0.0:
            return OPENING, x, y, parameter[HEIGHT], 0, 0.0
        return REFLECTOR, x, y, 0.0, 0, 0.0
    z += nearest * dz
    if to_x <= nearest:
        return WALL_ACROSS, (wall[RIGHT] if dx > 0.0 else wall[LEFT]), y, z, 0, 0.0
    return WALL_ALONG, x, (wall[FAR] if dy > 0.0 else wall[NEAR]), z, 0, 0.0


@kernel
def wall_direction(what, specular_fraction, dx, dy, dz, light, rng):
    """Return the direction after a side wall: mirrored or Lambertian."""
    across = what == WALL_ACROSS
    if uniform(rng) < specular_fraction:
        mirror_light(light, 1.0 if across else 0.0, 0.0 if across else 1.0, 0.0)
        return (-dx if across else dx), (dy if across else -dy), dz
    depolarise(light)
    if across:
        return lambertian(-math.copysign(1.0, dx), 0.0, 0.0, rng)
    return lambertian(0.0, -math.copysign(1.0, dy), 0.0, rng)


@kernel
def lamp_start(parameter, wall, lamp, rng):
    """Return a point and direction of the lamps' light: (x, y, z, dx, dy, dz, lamp number).

    The lamp is drawn by its luminance, the point evenly on the part of its tube under the panel.
    """
    share = uniform(rng)
    i = 0
    while i < len(lamp) - 1 and share >= lamp[i, SHARE]:
        i += 1
    half = min(wall[HALF_LAMP], wall[FAR])
    y = (2.0 * uniform(rng) - 1.0) * half
    angle = 2.0 * math.pi * uniform(rng)
    nx, nz = math.cos(angle), math.sin(angle)
    dx, dy, dz = lambertian(nx, 0.0, nz, rng)
    x = lamp[i, POSITION] + parameter[LAMP_RADIUS] * nx
    z = parameter[LAMP_HEIGHT] + parameter[LAMP_RADIUS] * nz
    return x, y, z, dx, dy, dz, i
