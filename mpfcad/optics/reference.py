"""The oracle: the same physics as the kernels in plain, slow Python, for tests to compare with.

No tree, no chain, no numba: every facet of the tile is tried for every ray by the textbook formula
(Möller and Trumbore, 1997), and each element is a few readable lines. It draws the same random
numbers in the same order as `engine`, so that single paths can be compared, not only means.
"""

import math
from collections.abc import Sequence

from mpfcad.optics.reference_bsdf import scatter
from mpfcad.optics.scene import BsdfSheet, Cavity, Element, Film, Sheet, Slab

Vector = tuple[float, float, float]


class Philox:
    """Philox4x32-10 in Python integers, counted by (draw, stream, path)."""

    def __init__(self, seed: int, stream: int, path: int) -> None:
        self.key = (seed & 0xFFFFFFFF, seed >> 32)
        self.tail = [stream, path & 0xFFFFFFFF, path >> 32]
        self.block = 0
        self.ready: list[float] = []

    def __call__(self) -> float:
        """Return the next number in [0, 1)."""
        if not self.ready:
            a, b, c, d = self._words()
            self.block += 1
            self.ready = [((a << 32 | b) >> 11) * 2.0**-53, ((c << 32 | d) >> 11) * 2.0**-53]
        return self.ready.pop(0)

    def _words(self) -> list[int]:
        word = [self.block, *self.tail]
        k0, k1 = self.key
        for _ in range(10):
            p0, p1 = 0xD2511F53 * word[0], 0xCD9E8D57 * word[2]
            word = [
                (p1 >> 32) ^ word[1] ^ k0, p1 & 0xFFFFFFFF,
                (p0 >> 32) ^ word[3] ^ k1, p0 & 0xFFFFFFFF,
            ]  # fmt: skip
            k0, k1 = (k0 + 0x9E3779B9) & 0xFFFFFFFF, (k1 + 0xBB67AE85) & 0xFFFFFFFF
        return word


def reflectance(cos_in: float, n_in: float, n_out: float) -> float:
    """Return the unpolarised Fresnel reflectance, from the angles (1 beyond the critical one)."""
    angle_in = math.acos(min(1.0, cos_in))
    sine = n_in * math.sin(angle_in) / n_out
    if sine >= 1.0:
        return 1.0
    angle_out = math.asin(sine)
    if angle_in < 1e-7 or n_in == n_out:
        return ((n_in - n_out) / (n_in + n_out)) ** 2
    minus, plus = angle_in - angle_out, angle_in + angle_out
    s, p = math.sin(minus) / math.sin(plus), math.tan(minus) / math.tan(plus)
    return (s * s + p * p) / 2


def refract(d: Vector, n: Vector, n_in: float, n_out: float) -> Vector:
    """Return the refracted direction; n is the unit normal on the side of the ray's arrival."""
    ratio = n_in / n_out
    cos_in = -dot(d, n)
    cos_out = math.sqrt(1 - ratio**2 * (1 - cos_in**2))
    return tuple(ratio * a + (ratio * cos_in - cos_out) * b for a, b in zip(d, n, strict=True))


def dot(a: Vector, b: Vector) -> float:
    """Return a · b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def facet_distance(corners: Sequence[Vector], o: Vector, d: Vector) -> float | None:
    """Return the distance from o along d to a facet, or None."""
    e1, e2 = minus(corners[1], corners[0]), minus(corners[2], corners[0])
    p = cross(d, e2)
    determinant = dot(e1, p)
    if determinant == 0:
        return None
    s = minus(o, corners[0])
    u = dot(s, p) / determinant
    q = cross(s, e1)
    v = dot(d, q) / determinant
    if u < 0 or v < 0 or u + v > 1:
        return None
    return dot(e2, q) / determinant


def disk(rng: Philox) -> tuple[float, float]:
    """Return a point uniform in the unit disk."""
    radius = math.sqrt(rng())
    angle = 2 * math.pi * rng()
    return radius * math.cos(angle), radius * math.sin(angle)


def about(axis: Vector, cosine: float, azimuth: float) -> Vector:
    """Return the direction at an angle about an axis (frame of Duff et al., 2017)."""
    x, y, z = axis
    sign = math.copysign(1.0, z)
    a = -1 / (sign + z)
    t = (1 + sign * x * x * a, sign * x * y * a, -sign * x)
    b = (x * y * a, sign + y * y * a, -y)
    sine = math.sqrt(max(0.0, 1 - cosine**2))
    p, q = sine * math.cos(azimuth), sine * math.sin(azimuth)
    return tuple(p * t[i] + q * b[i] + cosine * axis[i] for i in range(3))


def lambertian(normal: Vector, rng: Philox) -> Vector:
    """Return a cosine-weighted direction about a normal."""
    px, py = disk(rng)
    return about(normal, math.sqrt(1 - px * px - py * py), math.atan2(py, px))


class ReferenceTracer:
    """Traces paths backward from a meter through elements given from the bottom up."""

    def __init__(self, elements: list[Element], *, below: float = 0.0, above: float = 0.0) -> None:
        self.elements = elements
        self.below, self.above = below, above
        films = [e for e in elements if isinstance(e, Film)]
        self.length = films[0].mesh.size[1] if films else 1.0
        self.facets = []
        if films:
            vertex = [tuple(map(float, v)) for v in films[0].mesh.vertex]
            self.facets = [[vertex[i] for i in facet] for facet in films[0].mesh.top]

    def radiance(
        self, x: float, spot: float, acceptance: float, rng: Philox, *,
        y: float = 0.0, tilt: tuple[float, float] = (0.0, 0.0), spot_along: float = 0.0,
    ) -> float:  # fmt: skip
        """Return the radiance that one path collects, seen from above at (x, y) [mm].

        `tilt` are the direction cosines of the meter's axis, (0, 0) for the normal.
        """
        x += (rng() - 0.5) * spot
        y += (rng() - 0.5) * (spot_along or self.length)
        place, d = (x, y, 0.0), self._look(tilt, acceptance, disk(rng))
        weight, total = 1.0, 0.0
        number, up = len(self.elements) - 1, False
        while True:
            if number < 0:
                return total + weight * self.below
            if number == len(self.elements):
                return total + weight * self.above
            element = self.elements[number]
            pass_through = {
                Cavity: self._cavity, Slab: self._slab, Sheet: self._sheet, Film: self._film,
                BsdfSheet: self._bsdf,
            }[type(element)]  # fmt: skip
            up, place, d, weight, found = pass_through(element, up, place, d, weight, rng)
            total += found
            weight = self._roulette(weight, rng)
            if weight == 0:
                return total
            number += 1 if up else -1

    @staticmethod
    def _look(tilt: tuple[float, float], acceptance: float, point: tuple[float, float]) -> Vector:
        """Return a ray's direction in the cone: the normal's cone, turned onto the axis."""
        sine = math.hypot(*tilt)
        px, py = acceptance * point[0], acceptance * point[1]
        d = (px, py, -math.sqrt(1 - px * px - py * py))
        if sine == 0:
            return d
        # By Rodrigues' formula about the horizontal axis n across the tilt.
        n = (tilt[1] / sine, -tilt[0] / sine, 0.0)
        cosine, along, side = math.sqrt(1 - sine**2), dot(n, d), cross(n, d)
        d = tuple(cosine * d[i] + sine * side[i] + (1 - cosine) * along * n[i] for i in range(3))
        return (d[0], d[1], -abs(d[2]))

    @staticmethod
    def _roulette(weight: float, rng: Philox) -> float:
        if weight >= 0.1 or weight == 0:
            return weight
        return 0.0 if rng() < 0.5 else 2 * weight

    def _cavity(self, cavity, up, place, d, weight, rng):
        x, y, z = place[0], place[1], cavity.height
        total, own = 0.0, None
        while weight > 0:
            distance, lamp = self._lamp(cavity, x, z, d, own)
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
                d, kept = self._reflector(cavity, d, rng)
                weight *= kept
            weight = self._roulette(weight, rng)
        return True, (x, y, 0.0), d, weight, total

    @staticmethod
    def _reflector(cavity, d, rng):
        if cavity.brdf is not None:
            _, d, kept = scatter(cavity.brdf, cavity.blend, d, rng)
            return d, kept
        if rng() < cavity.specular_fraction:
            return (d[0], d[1], -d[2]), cavity.reflectance
        px, py = disk(rng)
        return (px, py, math.sqrt(1 - px * px - py * py)), cavity.reflectance

    @staticmethod
    def _lamp(cavity, x, z, d, own):
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

    @staticmethod
    def _sheet(sheet, up, place, d, weight, rng):
        radius = math.sqrt(-2 * math.log(1 - rng()))
        angle = 2 * math.pi * rng()
        kx = d[0] + sheet.sigma * radius * math.cos(angle)
        ky = d[1] + sheet.sigma * radius * math.sin(angle)
        accept = rng()
        weight *= sheet.transmission
        if kx * kx + ky * ky < 1:
            kz = math.sqrt(1 - kx * kx - ky * ky)
            r1, r2 = (reflectance(c, 1.0, sheet.index) for c in (abs(d[2]), kz))
            if accept < (1 - r1) * (1 - r2) / (1 - r1 * r2):
                return up, place, (kx, ky, math.copysign(kz, d[2])), weight, 0.0
        return not up, place, (d[0], d[1], -d[2]), weight, 0.0

    @staticmethod
    def _bsdf(sheet, up, place, d, weight, rng):
        passed, d, kept = scatter(sheet.table, sheet.blend, d, rng)
        return passed == up, place, d, weight * kept, 0.0

    @staticmethod
    def _slab(slab, up, place, d, weight, rng):
        x, y, z = place[0], place[1], 0.0 if up else slab.thickness
        if up or not slab.bonded:
            if rng() < reflectance(abs(d[2]), 1.0, slab.index):
                return not up, place, (d[0], d[1], -d[2]), weight, 0.0
            d = refract(d, (0.0, 0.0, -math.copysign(1.0, d[2])), 1.0, slab.index)
        while True:
            face = ((slab.thickness if d[2] > 0 else 0.0) - z) / d[2]
            free = -math.log(1 - rng()) / slab.scattering if slab.scattering else math.inf
            step = min(face, free)
            weight *= math.exp(-slab.absorption * step)
            x, y, z = x + step * d[0], y + step * d[1], z + step * d[2]
            if free < face:
                g, u = slab.asymmetry, rng()
                cosine = 2 * u - 1
                if g:
                    cosine = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
                d = about(d, cosine, 2 * math.pi * rng())
                continue
            up = d[2] > 0
            z = slab.thickness if up else 0.0
            if up and slab.bonded:
                return True, (x, y, 0.0), d, weight, 0.0
            if rng() < reflectance(abs(d[2]), slab.index, 1.0):
                d = (d[0], d[1], -d[2])
                continue
            d = refract(d, (0.0, 0.0, -math.copysign(1.0, d[2])), slab.index, 1.0)
            return up, (x, y, 0.0), d, weight, 0.0

    def _film(self, film, up, place, d, weight, rng):
        width, length, _ = film.mesh.size
        high = max(c[2] for facet in self.facets for c in facet)
        x, y = place[0] - film.offset, place[1]
        inside, z = False, high
        if up:
            z = 0.0
            if rng() < reflectance(abs(d[2]), film.index_below, film.index):
                return False, place, (d[0], d[1], -d[2]), weight, 0.0
            d = refract(d, (0.0, 0.0, -1.0), film.index_below, film.index)
            inside = True
        while True:
            distance, normal = self._first_facet((x, y, z), d, inside, high, width, length)
            if normal is not None:
                x, y, z = x + distance * d[0], y + distance * d[1], z + distance * d[2]
                n_in, n_out = (film.index, 1.0) if inside else (1.0, film.index)
                facing = tuple(-c for c in normal) if inside else normal
                if rng() < reflectance(abs(dot(d, normal)), n_in, n_out):
                    twice = 2 * dot(d, normal)
                    d = tuple(a - twice * b for a, b in zip(d, normal, strict=True))
                else:
                    d = refract(d, facing, n_in, n_out)
                    inside = not inside
                continue
            level = 0.0 if inside else high
            flight = (level - z) / d[2]
            x, y, z = x + flight * d[0], y + flight * d[1], level
            out = (x + film.offset, y, 0.0)
            if not inside:
                return True, out, d, weight, 0.0
            if rng() < reflectance(abs(d[2]), film.index, film.index_below):
                d = (d[0], d[1], -d[2])
                continue
            d = refract(d, (0.0, 0.0, 1.0), film.index, film.index_below)
            return False, out, d, weight, 0.0

    def _first_facet(self, o, d, inside, high, width, length):
        """Return (distance, normal) of the first facet, over all tiles the ray flies past."""
        level = high if d[2] > 0 else 0.0
        reach = (level - o[2]) / d[2]
        tiles_x = _tiles(o[0], o[0] + reach * d[0], width)
        tiles_y = _tiles(o[1], o[1] + reach * d[1], length)
        best, normal = math.inf, None
        for i in tiles_x:
            for j in tiles_y:
                local = (o[0] - i * width, o[1] - j * length, o[2])
                for corners in self.facets:
                    n = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
                    if (dot(d, n) > 0) != inside:
                        continue
                    distance = facet_distance(corners, local, d)
                    if distance is not None and -1e-12 < distance < best:
                        best, size = distance, math.sqrt(dot(n, n))
                        normal = tuple(c / size for c in n)
        return best, normal


def _tiles(start: float, end: float, size: float) -> range:
    """Return the numbers of the tiles of `size` between two positions, one more on each side."""
    low, high = sorted((start, end))
    return range(math.floor(low / size) - 1, math.floor(high / size) + 2)
