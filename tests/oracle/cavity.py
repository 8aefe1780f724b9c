"""The oracle's space under the stack: lamps over a reflector, in plain Python."""

import copy
import math

from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import Cavity
from oracle.bsdf import scatter
from oracle.ray import Philox, Vector, disk, lambertian, roulette


def _with_share(cavity: Cavity, share: float) -> Cavity:
    """Return a cavity with another mirrored share; its other numbers may be those of bands."""
    other = copy.copy(cavity)
    object.__setattr__(other, "specular_fraction", share)
    return other


def cavity_passage(
    cavity: Cavity, up: bool, place: Vector, d: Vector, weight: float, rng: Philox
) -> tuple[bool, Vector, Vector, float, float]:
    """Follow a ray until it leaves the cavity upward or ends."""
    if cavity.panel:
        return _panel_passage(cavity, place, d, weight, rng)
    x, y, z = place[0], place[1], cavity.height
    total, own, counted = 0.0, None, range(0)
    while weight > 0:
        distance, lamp = _lamp(cavity, x, z, d, own)
        plane = ((cavity.height if d[2] > 0 else 0.0) - z) / d[2]
        step = min(distance, plane)
        x, y, z = x + step * d[0], y + step * d[1], z + step * d[2]
        if distance < plane:
            if lamp not in counted:
                total += weight * cavity.lamp_luminance
                rng.found(weight * cavity.lamp_luminance)
            counted = range(0)
            weight *= cavity.lamp_reflectance
            rng.happens(cavity, "lamp_reflectance", math.log)
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
            mirrored = (d[0], d[1], -d[2])
            d, kept = _reflector(cavity, d, rng)
            weight *= kept
            if cavity.brdf is None:
                rng.happens(cavity, "reflectance", math.log)
                share, counted = _direct(cavity, x, mirrored)
                total += weight * share * cavity.lamp_luminance
                more, _ = _direct(_with_share(cavity, 1.0), x, mirrored)
                less, _ = _direct(_with_share(cavity, 0.0), x, mirrored)
                part = weight * cavity.lamp_luminance
                rng.found(part * share, part * (more - less))
                is_mirrored = d == mirrored
                rng.happens(
                    cavity, "specular_fraction",
                    lambda s, m=is_mirrored: math.log(s if m else 1 - s),
                )  # fmt: skip
                if d == mirrored:
                    counted = range(-10_000, 10_000)
        weight = roulette(weight, rng)
    return True, (x, y, 0.0), d, weight, total


def _reflector(cavity: Cavity, d: Vector, rng: Philox) -> tuple[Vector, float]:
    """Return the direction after the reflector and the share of the light it leaves."""
    if cavity.brdf is not None:
        _, d, kept = scatter(cavity.brdf, cavity.blend, d, rng)
        rng.depolarise()
        return (d[0], d[1], abs(d[2])), kept
    if rng() < cavity.specular_fraction:
        rng.mirror((0.0, 0.0, 1.0))
        return (d[0], d[1], -d[2]), cavity.reflectance
    px, py = disk(rng)
    rng.depolarise()
    return (px, py, math.sqrt(1 - px * px - py * py)), cavity.reflectance


def _direct(cavity: Cavity, x: float, mirrored: Vector) -> tuple[float, range]:
    """Return the share of a ray's reflected light that lamps send there, and which lamps it holds.

    Lambertian part: half the sines' difference over the union of three lamps' angles.
    """
    nearest = round((x - cavity.lamp_position) / cavity.lamp_pitch)
    seen = []
    for number in range(nearest - 1, nearest + 2):
        across = cavity.lamp_position + number * cavity.lamp_pitch - x
        angle = math.atan2(across, cavity.lamp_height)
        half = math.asin(cavity.lamp_radius / math.hypot(across, cavity.lamp_height))
        seen.append((angle - half, angle + half))
    view, past = 0.0, -math.pi
    for low, high in sorted(seen):
        if high > past:
            view += (math.sin(high) - math.sin(max(low, past))) / 2
            past = high
    hit = _lamp(cavity, x, 0.0, mirrored, None)[1] is not None
    share = (1 - cavity.specular_fraction) * view + cavity.specular_fraction * hit
    return share, range(nearest - 1, nearest + 2)


def _lamp(
    cavity: Cavity, x: float, z: float, d: Vector, own: int | None
) -> tuple[float, int | None]:
    """Return (distance, number) of the nearest lamp among all under the ray's way to a plane."""
    best, lamp = math.inf, None
    end = x + ((cavity.height if d[2] > 0 else 0.0) - z) / d[2] * d[0]
    low, high = ((v - cavity.lamp_position) / cavity.lamp_pitch for v in sorted((x, end)))
    along = d[0] ** 2 + d[2] ** 2
    for number in range(math.floor(low) - 1, math.ceil(high) + 2):
        if number == own:
            continue
        ox = x - (cavity.lamp_position + number * cavity.lamp_pitch)
        oz = z - cavity.lamp_height
        b = ox * d[0] + oz * d[2]
        root = b * b - along * (ox**2 + oz**2 - cavity.lamp_radius**2)
        if b < 0 <= root and (-b - math.sqrt(root)) / along < best:
            best, lamp = (-b - math.sqrt(root)) / along, number
    return best, lamp


def _panel_passage(
    cavity: Cavity, o: Vector, d: Vector, weight: float, rng: Philox
) -> tuple[bool, Vector, Vector, float, float]:
    """Follow a ray in a box with walls: everything is tried, the nearest thing met."""
    panel = cavity.panel
    o = (o[0], o[1], cavity.height)
    total, own = 0.0, None
    while weight > 0:
        met = [hit for i in range(len(panel.lamp_position)) if i != own
               for hit in _rod(cavity, i, o, d)]  # fmt: skip
        for axis, low, high in (
            (0, panel.left, panel.right), (1, panel.near, panel.far), (2, 0.0, cavity.height)
        ):  # fmt: skip
            if d[axis]:
                plane = high if d[axis] > 0 else low
                normal = [0.0, 0.0, 0.0]
                normal[axis] = -math.copysign(1.0, d[axis])
                met.append((max(0.0, (plane - o[axis]) / d[axis]), "xyz"[axis], tuple(normal)))
        distance, what, normal = min(met, key=lambda hit: hit[0])
        o = tuple(a + distance * b for a, b in zip(o, d, strict=True))
        if what == "z" and d[2] > 0:
            break
        if isinstance(what, int):
            own = what
            if normal[1] == 0:
                total += weight * cavity.lamp_luminance * panel.lamp_factor[own]
            weight *= cavity.lamp_reflectance
            d = lambertian(normal, rng)
        else:
            own = None
            if what == "z" and cavity.brdf is not None:
                d, kept = _reflector(cavity, d, rng)
                weight, o = roulette(weight * kept, rng), _onto(o, 2, panel, True)
                continue
            walls = (panel.wall_reflectance, panel.wall_specular_fraction)
            share, mirrored = (cavity.reflectance, cavity.specular_fraction)
            share, mirrored = (share, mirrored) if what == "z" else walls
            weight *= share
            o = _onto(o, "xyz".index(what), panel, what == "z")
            mirror = tuple(-c if n else c for c, n in zip(d, normal, strict=True))
            if rng() < mirrored:
                rng.mirror(normal)
                d = mirror
            else:
                d = lambertian(normal, rng)
            if what == "z":
                total += weight * cavity.lamp_luminance * _surplus(cavity, o[0], mirror, d)
        weight = roulette(weight, rng)
    return True, (o[0], o[1], 0.0), d, weight, total


def _surplus(cavity: Cavity, x: float, mirror: Vector, d: Vector) -> float:
    """Return the mean light of endless lamps over directions after the reflector, less that in d.

    Of three lamps as seen from below; what one hides of the next but one is not among them.
    """
    panel = cavity.panel
    lamps = sorted(zip(panel.lamp_position, panel.lamp_factor, strict=True))
    nearest = min(range(len(lamps)), key=lambda i: abs(lamps[i][0] - x))
    seen = []
    for place, factor in lamps[max(0, nearest - 1) : nearest + 2]:
        angle = math.atan2(place - x, cavity.lamp_height)
        half = math.asin(cavity.lamp_radius / math.hypot(place - x, cavity.lamp_height))
        seen.append([angle - half, angle + half, factor])
    for i in range(len(seen)):
        middle = min(nearest, 1)
        if i < middle:
            seen[i][1] = min(seen[i][1], seen[middle][0])
        elif i > middle:
            seen[i][0] = max(seen[i][0], seen[middle][1])
    seen = [s for s in seen if s[1] > s[0]]
    view = sum((math.sin(high) - math.sin(low)) / 2 * factor for low, high, factor in seen)
    by_mirror, taken = (
        sum(factor for low, high, factor in seen if low <= math.atan2(v[0], v[2]) < high)
        for v in (mirror, d)
    )
    share = cavity.specular_fraction
    return (1 - share) * view + share * by_mirror - taken


def _onto(o: Vector, axis: int, panel: Panel, floor: bool) -> Vector:
    """Return a point put exactly onto the wall or floor it lies on."""
    if floor:
        return (o[0], o[1], 0.0)
    edges = ((panel.left, panel.right), (panel.near, panel.far))[axis]
    plane = min(edges, key=lambda edge: abs(edge - o[axis]))
    return (plane, o[1], o[2]) if axis == 0 else (o[0], plane, o[2])


def _rod(cavity: Cavity, number: int, o: Vector, d: Vector) -> list[tuple[float, int, Vector]]:
    """Return where a ray enters a lamp, on its tube or at an end, if it does."""
    centre, half = cavity.panel.lamp_position[number], cavity.panel.lamp_length / 2
    radius = cavity.lamp_radius
    x, z = o[0] - centre, o[2] - cavity.lamp_height
    met = []
    for end in (-half, half):
        if d[1] and end * d[1] < 0 and (end - o[1]) / d[1] > 0:
            distance = (end - o[1]) / d[1]
            if math.hypot(x + distance * d[0], z + distance * d[2]) <= radius:
                met.append((distance, number, (0.0, math.copysign(1.0, end), 0.0)))
    along = d[0] ** 2 + d[2] ** 2
    b = x * d[0] + z * d[2]
    root = b * b - along * (x * x + z * z - radius**2)
    if b < 0 <= root:
        distance = (-b - math.sqrt(root)) / along
        if abs(o[1] + distance * d[1]) <= half:
            normal = ((x + distance * d[0]) / radius, 0.0, (z + distance * d[2]) / radius)
            met.append((distance, number, normal))
    return met
