"""The oracle's film: every facet tried for every ray, in plain Python."""

import math
from itertools import pairwise

from mpfcad.optics.element import Film
from oracle.ray import (
    Philox,
    Vector,
    about,
    cross,
    dot,
    exp,
    facet_distance,
    minus,
    refract,
    scattering_cosine,
)
from oracle.rough import rough_interface


class ReferenceFilm:
    """A film as it lies in the stack: turned about z, upside down or not."""

    def __init__(self, film: Film) -> None:
        self.film = film
        vertex = [tuple(map(float, v)) for v in film.mesh.vertex]
        self.facets = [[vertex[i] for i in facet] for facet in film.mesh.top]
        if film.resin:
            prism = film.resin.prism
            points = prism.vertex[sorted({i for facet in prism.top for i in facet})]
            self.profile = sorted({(float(p[0]), float(p[2])) for p in points})
            self.valley = min(z for _, z in self.profile)
        self.high = max(corner[2] for facet in self.facets for corner in facet)

    @property
    def length(self) -> float:
        """Over which length [mm] along y it repeats."""
        width, length, _ = self.film.mesh.size
        quarters = self.film.rotation / (math.pi / 2)
        if abs(quarters - round(quarters)) > 1e-12:
            return max(width, length)
        return (length, width)[round(quarters) % 2]

    def passage(
        self, up: bool, place: Vector, d: Vector, weight: float, rng: Philox
    ) -> tuple[bool, Vector, Vector, float, float]:
        """Follow a ray until it leaves the film: (up, place, direction, weight, found)."""
        up, place, d = self._to_film(up, place, d)
        rng.turn(-self.film.rotation)
        rng.turn(0.0, self.film.flipped)
        self.path = {False: 0.0, True: 0.0}
        up, place, d = self._inside(up, place, d, rng)
        rng.turn(0.0, self.film.flipped)
        rng.turn(self.film.rotation)
        up, place, d = self._to_stack(up, place, d)
        depth = self.film.absorption * self.path[False] + self._resin_absorption * self.path[True]
        return up, place, d, weight * exp(-depth), 0.0

    def _index(self, resin: bool) -> float:
        """Return the index of the prisms, or of the resin."""
        own = self.film.resin.index if resin else None
        return self.film.index if own is None else own

    @property
    def _resin_absorption(self) -> float:
        own = self.film.resin.absorption if self.film.resin else None
        return self.film.absorption if own is None else own

    def _to_film(self, up: bool, place: Vector, d: Vector) -> tuple[bool, Vector, Vector]:
        """Return a ray in the film's own axes, its left edge at x = 0."""
        place, d = (_turned(v, -self.film.rotation) for v in (place, d))
        x = place[0] - self.film.offset
        if not self.film.flipped:
            return up, (x, place[1], 0.0), d
        return not up, (self.film.mesh.size[0] - x, place[1], 0.0), (-d[0], d[1], -d[2])

    def _to_stack(self, up: bool, place: Vector, d: Vector) -> tuple[bool, Vector, Vector]:
        x = place[0]
        if self.film.flipped:
            up, x, d = not up, self.film.mesh.size[0] - x, (-d[0], d[1], -d[2])
        place = (x + self.film.offset, place[1], 0.0)
        return up, _turned(place, self.film.rotation), _turned(d, self.film.rotation)

    def _inside(
        self, up: bool, place: Vector, d: Vector, rng: Philox
    ) -> tuple[bool, Vector, Vector]:
        film = self.film
        inside, o = False, (place[0], place[1], self.high)
        if up:
            o = (place[0], place[1], 0.0)
        if up and film.mesh.underside:
            if rng.reflects(d, (0.0, 0.0, 1.0), film.index_below, film.index):
                return False, o, (d[0], d[1], -d[2])
            d = refract(d, (0.0, 0.0, -1.0), film.index_below, film.index)
            inside = True
        two, in_resin = film.shows_prism, False
        scattering = film.resin.scattering if film.resin else 0.0
        while True:
            distance, normal = self._first_facet(o, d, inside)
            reach, flown, prism = 0.0, math.inf, None
            if inside:
                reach = distance if normal else o[2] / -d[2]
            if inside and two:
                met, n = self._prism_ahead(o, d, in_resin)
                if (reach - met) * (abs(dot(d, normal)) if normal else 1) > film.resin.thinnest:
                    reach, prism = met, n
                if scattering and in_resin:
                    flown = -math.log(1 - rng()) / scattering
            elif inside and scattering:
                flown = self._collision(o, d, reach, rng)
            self.path[in_resin] += min(reach, flown)
            if flown < reach:
                o = tuple(a + flown * b for a, b in zip(o, d, strict=True))
                cosine = scattering_cosine(film.resin.phase, film.resin.asymmetry, rng())
                d = about(d, cosine, 2 * math.pi * rng())
                rng.depolarise()
                continue
            if prism is not None:
                o = tuple(a + reach * b for a, b in zip(o, d, strict=True))
                there = not in_resin
                n_in, n_out = self._index(in_resin), self._index(there)
                passed, d = self._interface(n_in, n_out, film.roughness, prism, d, rng)
                in_resin = there if passed else in_resin
                continue
            if normal is not None:
                o = tuple(a + distance * b for a, b in zip(o, d, strict=True))
                if two:
                    in_resin = o[2] - self._prism_height(o[0]) > film.resin.thinnest
                n_in, n_out = self._index(in_resin), 1.0
                if not inside:
                    n_in, n_out = n_out, n_in
                rough = 0.0 if in_resin else film.roughness
                passed, d = self._interface(n_in, n_out, rough, normal, d, rng)
                inside = inside != passed
                continue
            level = self.high if d[2] > 0 else 0.0
            flight = (level - o[2]) / d[2]
            o = (o[0] + flight * d[0], o[1] + flight * d[1], level)
            if not inside:
                return d[2] > 0, o, d
            in_resin = False
            if rng.reflects(d, (0.0, 0.0, 1.0), film.index, film.index_below):
                d = (d[0], d[1], -d[2])
                continue
            return False, o, refract(d, (0.0, 0.0, 1.0), film.index, film.index_below)

    def _prism_ahead(self, o: Vector, d: Vector, in_resin: bool) -> tuple[float, Vector]:
        """Return (distance, normal) of the prisms' surface ahead, over all walls flown past."""
        width = self.film.mesh.size[0]
        level = 0.0 if d[2] < 0 else self.high
        end = o[0] + (level - o[2]) / d[2] * d[0]
        best, normal = math.inf, (0.0, 0.0, 1.0)
        for tile in _tiles(o[0], end, width):
            for (x0, z0), (x1, z1) in pairwise(self.profile):
                size = math.hypot(x1 - x0, z1 - z0)
                n = ((z0 - z1) / size, 0.0, (x1 - x0) / size)
                rate = dot(d, n)
                if rate == 0 or (rate > 0) == in_resin:
                    continue
                distance = ((x0 + tile * width - o[0]) * n[0] + (z0 - o[2]) * n[2]) / rate
                hit = o[0] + distance * d[0] - tile * width
                if -1e-12 < distance < best and x0 <= hit <= x1:
                    best, normal = distance, n
        return best, normal

    def _collision(self, o: Vector, d: Vector, reach: float, rng: Philox) -> float:
        """Return how far a ray flies in the film until the resin scatters it, or infinity."""
        flown = 0.0
        if o[2] < self.valley:
            if d[2] <= 0:
                return math.inf
            flown = (self.valley - o[2]) / d[2]
        elif d[2] < 0:
            reach = min(reach, (self.valley - o[2]) / d[2])
        while True:
            flown -= math.log(1 - rng()) / self.film.resin.scattering
            if flown >= reach:
                return math.inf
            if o[2] + flown * d[2] > self._prism_height(o[0] + flown * d[0]):
                return flown

    def _prism_height(self, x: float) -> float:
        """Return the height of the prisms' surface under the resin."""
        x %= self.film.mesh.size[0]
        for (x0, z0), (x1, z1) in pairwise(self.profile):
            if x0 <= x <= x1:
                return z0 + (z1 - z0) * (x - x0) / (x1 - x0)
        raise ValueError(x)

    @staticmethod
    def _interface(
        n_in: float, n_out: float, slope: float, normal: Vector, d: Vector, rng: Philox
    ) -> tuple[bool, Vector]:
        """Pass or reflect a ray at a surface, rough where it has a slope: (passed, direction)."""
        if slope > 0 and n_in != n_out:
            return rough_interface(n_in, n_out, slope, normal, d, rng)
        facing = normal if dot(d, normal) < 0 else tuple(-c for c in normal)
        if rng.reflects(d, normal, n_in, n_out):
            twice = 2 * dot(d, normal)
            return False, tuple(a - twice * b for a, b in zip(d, normal, strict=True))
        return True, refract(d, facing, n_in, n_out)

    def _first_facet(self, o: Vector, d: Vector, inside: bool) -> tuple[float, Vector | None]:
        """Return (distance, normal) of the first facet, over all tiles the ray flies past."""
        width, length, _ = self.film.mesh.size
        level = self.high if d[2] > 0 else 0.0
        reach = (level - o[2]) / d[2]
        best, normal = math.inf, None
        for i in _tiles(o[0], o[0] + reach * d[0], width):
            for j in _tiles(o[1], o[1] + reach * d[1], length):
                local = (o[0] - i * width, o[1] - j * length, o[2])
                if not _flies_over(local, d, width, length):
                    continue
                for corners in self.facets:
                    n = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
                    if (dot(d, n) > 0) != inside:
                        continue
                    distance = facet_distance(corners, local, d)
                    if distance is not None and -1e-12 < distance < best:
                        best, size = distance, math.sqrt(dot(n, n))
                        normal = tuple(c / size for c in n)
        return best, normal


def _turned(v: Vector, angle: float) -> Vector:
    """Return a vector turned about z."""
    c, s = math.cos(angle), math.sin(angle)
    return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])


def _flies_over(o: Vector, d: Vector, width: float, length: float) -> bool:
    """Return whether a ray comes near a tile, seen from above."""
    x, y = width / 2 - o[0], length / 2 - o[1]
    return abs(d[0] * y - d[1] * x) <= math.hypot(d[0], d[1]) * math.hypot(width, length) + 1e-300


def _tiles(start: float, end: float, size: float) -> range:
    """Return the numbers of the tiles of `size` between two positions, one more on each side."""
    low, high = sorted((start, end))
    return range(math.floor(low / size) - 1, math.floor(high / size) + 2)
