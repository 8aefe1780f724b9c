"""The oracle's space under the stack: lamps over a reflector, in plain Python."""

import math

from mpfcad.optics.reference_ray import Philox, Vector, disk, lambertian, roulette
from mpfcad.optics.scene import Cavity


def cavity_passage(
    cavity: Cavity, up: bool, place: Vector, d: Vector, weight: float, rng: Philox
) -> tuple[bool, Vector, Vector, float, float]:
    """Follow a ray until it leaves the cavity upward or ends."""
    x, y, z = place[0], place[1], cavity.height
    total, own = 0.0, None
    while weight > 0:
        distance, lamp = _lamp(cavity, x, z, d, own)
        plane = ((cavity.height if d[2] > 0 else 0.0) - z) / d[2]
        step = min(distance, plane)
        x, y, z = x + step * d[0], y + step * d[1], z + step * d[2]
        if distance < plane:
            total += weight * cavity.lamp_luminance
            weight *= cavity.lamp_reflectance
            centre = cavity.lamp_position + lamp * cavity.lamp_pitch
            normal = (
                (x - centre) / cavity.lamp_radius, 0.0,
                (z - cavity.lamp_height) / cavity.lamp_radius,
            )  # fmt: skip
            d, own = lambertian(normal, rng), lamp
        elif d[2] > 0:
            break
        else:
            z, own = 0.0, None
            weight *= cavity.reflectance
            if rng() < cavity.specular_fraction:
                d = (d[0], d[1], -d[2])
            else:
                px, py = disk(rng)
                d = (px, py, math.sqrt(1 - px * px - py * py))
        weight = roulette(weight, rng)
    return True, (x, y, 0.0), d, weight, total


def _lamp(
    cavity: Cavity, x: float, z: float, d: Vector, own: int | None
) -> tuple[float, int | None]:
    """Return (distance, number) of the nearest lamp among those within 40 pitches."""
    best, lamp = math.inf, None
    middle = round((x - cavity.lamp_position) / cavity.lamp_pitch)
    along = d[0] ** 2 + d[2] ** 2
    for number in range(middle - 40, middle + 41):
        if number == own:
            continue
        ox = x - (cavity.lamp_position + number * cavity.lamp_pitch)
        oz = z - cavity.lamp_height
        b = ox * d[0] + oz * d[2]
        root = b * b - along * (ox**2 + oz**2 - cavity.lamp_radius**2)
        if b < 0 <= root and (-b - math.sqrt(root)) / along < best:
            best, lamp = (-b - math.sqrt(root)) / along, number
    return best, lamp
