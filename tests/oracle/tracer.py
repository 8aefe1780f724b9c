"""The oracle: the same physics as the kernels in plain, slow Python, for tests to compare with.

No tree, no chain, no numba: every facet of the tile is tried for every ray by the textbook formula
(Möller and Trumbore, 1997), and each element is a few readable lines. It draws the same random
numbers in the same order as `engine`, so that single paths can be compared, not only means.
"""

import math

from mpfcad.optics.cavity.board import Board
from mpfcad.optics.element import BsdfSheet, Cavity, Element, Film, Sheet, Slab
from mpfcad.optics.stokes.plane import PlaneLayer
from oracle.board import board_passage
from oracle.bsdf import scatter
from oracle.cavity import cavity_passage
from oracle.film import ReferenceFilm
from oracle.ray import (
    Philox,
    Vector,
    about,
    cross,
    disk,
    dot,
    exp,
    reflectance,
    refract,
    roulette,
    scattering_cosine,
)


class ReferenceTracer:
    """Traces paths backward from a meter through elements given from the bottom up."""

    def __init__(self, elements: list[Element], *, below: float = 0.0, above: float = 0.0) -> None:
        self.elements = elements
        self.below, self.above = below, above
        self.panel = getattr(elements[0], "panel", None)
        self.films = {id(e): ReferenceFilm(e) for e in elements if isinstance(e, Film)}
        self.length = max((film.length for film in self.films.values()), default=1.0)
        if self.panel:
            self.length = min(self.length, 2.0)

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
        rng.start(d)
        number, up = len(self.elements) - 1, False
        while True:
            if number < 0:
                return total + rng.seen(weight * self.below)
            if number == len(self.elements):
                return total + rng.seen(weight * self.above)
            element = self.elements[number]
            pass_through = {
                Board: board_passage, Cavity: cavity_passage, Slab: self._slab,
                Sheet: self._sheet, Film: self._film, BsdfSheet: self._bsdf,
                PlaneLayer: self._plane,
            }[type(element)]  # fmt: skip
            up, place, d, weight, found = pass_through(element, up, place, d, weight, rng)
            total += rng.seen(found)
            if self.panel and not self._is_over(place):
                return total
            weight = roulette(weight, rng)
            if weight == 0:
                return total
            number += 1 if up else -1

    def _is_over(self, place: Vector) -> bool:
        """Return whether a place is on the panel."""
        panel = self.panel
        return panel.left <= place[0] <= panel.right and panel.near <= place[1] <= panel.far

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
    def _sheet(sheet, up, place, d, weight, rng):
        # Of a covariance matrix's two axes, drawn one by one; the wide lobe is round.
        widths = [sheet.sigma, sheet.sigma if sheet.sigma_across is None else sheet.sigma_across]
        if sheet.wide_share and rng() < sheet.wide_share:
            widths = [sheet.wide_sigma] * 2
        radius = math.sqrt(-2 * math.log(1 - rng()))
        angle = 2 * math.pi * rng()
        u, v = widths[0] * radius * math.cos(angle), widths[1] * radius * math.sin(angle)
        turned = complex(math.cos(sheet.axis), math.sin(sheet.axis)) * complex(u, v)
        if sheet.sigma_across in (None, sheet.sigma):
            turned = complex(u, v)
        kx, ky = d[0] + turned.real, d[1] + turned.imag
        accept = rng()
        weight *= sheet.transmission
        _tell_sheet(sheet, rng, u, v)
        if kx * kx + ky * ky < 1:
            kz = math.sqrt(1 - kx * kx - ky * ky)
            r1, r2 = (reflectance(c, 1.0, sheet.index) for c in (abs(d[2]), kz))
            passes = accept < (1 - r1) * (1 - r2) / (1 - r1 * r2)
            rng.happens(sheet, "index", lambda n: _chance(n, abs(d[2]), kz, passes))
            if passes:
                k = (kx, ky, math.copysign(kz, d[2]))
                rng.scatter(d, k, True, 1 - sheet.depolarisation)
                return up, place, k, weight, 0.0
        k = (d[0], d[1], -d[2])
        rng.scatter(d, k, False, 1 - sheet.depolarisation)
        return not up, place, k, weight, 0.0

    @staticmethod
    def _plane(layer, up, place, d, weight, rng):
        passed, left = rng.splits(layer, d)
        return passed == up, place, (d if passed else (d[0], d[1], -d[2])), weight * left, 0.0

    @staticmethod
    def _bsdf(sheet, up, place, d, weight, rng):
        passed, d, kept = scatter(sheet.table, sheet.blend, d, rng)
        rng.depolarise()
        return passed == up, place, d, weight * kept, 0.0

    @staticmethod
    def _slab(slab, up, place, d, weight, rng):
        x, y, z = place[0], place[1], 0.0 if up else slab.thickness
        if up or not slab.bonded:
            outside = slab.index_below if up else 1.0
            if rng.reflects(d, (0.0, 0.0, 1.0), outside, slab.index):
                return not up, place, (d[0], d[1], -d[2]), weight, 0.0
            d = refract(d, (0.0, 0.0, -math.copysign(1.0, d[2])), outside, slab.index)
        while True:
            face = ((slab.thickness if d[2] > 0 else 0.0) - z) / d[2]
            free = -math.log(1 - rng()) / slab.scattering if slab.scattering else math.inf
            step = min(face, free)
            weight *= exp(-slab.absorption * step)
            rng.happens(slab, "absorption", lambda a, step=step: -a * step)
            meets = free < face
            rng.happens(
                slab, "scattering",
                lambda s, step=step, meets=meets: (math.log(s) if meets else 0.0) - s * step,
            )  # fmt: skip
            x, y, z = x + step * d[0], y + step * d[1], z + step * d[2]
            rng.delay(slab, d, step)
            if free < face:
                cosine = scattering_cosine(slab.phase, slab.asymmetry, rng())
                rng.happens(
                    slab, "asymmetry",
                    lambda g, c=cosine: math.log((1 - g * g) / (1 + g * g - 2 * g * c) ** 1.5),
                )  # fmt: skip
                d = about(d, cosine, 2 * math.pi * rng())
                rng.depolarise()
                continue
            up = d[2] > 0
            z = slab.thickness if up else 0.0
            if up and slab.bonded:
                return True, (x, y, 0.0), d, weight, 0.0
            outside = 1.0 if up else slab.index_below
            if rng.reflects(d, (0.0, 0.0, 1.0), slab.index, outside):
                d = (d[0], d[1], -d[2])
                continue
            d = refract(d, (0.0, 0.0, -math.copysign(1.0, d[2])), slab.index, outside)
            return up, (x, y, 0.0), d, weight, 0.0

    def _film(self, film, up, place, d, weight, rng):
        return self.films[id(film)].passage(up, place, d, weight, rng)


def _tell_sheet(sheet, rng, u, v):
    """Tell what a sheet draws and takes, by each of its values; (u, v) in its own axes."""

    def normal(a, b):
        return math.exp(-(u * u / a**2 + v * v / b**2) / 2) / (2 * math.pi * a * b)

    def density(a, b, wide, share):
        return math.log((1 - share) * normal(a, b) + (share * normal(wide, wide) if share else 0))

    a, wide, share = sheet.sigma, sheet.wide_sigma, sheet.wide_share
    b = a if sheet.sigma_across is None else sheet.sigma_across
    if sheet.sigma_across is None:
        rng.happens(sheet, "sigma", lambda s: density(s, s, wide, share))
    else:
        rng.happens(sheet, "sigma", lambda s: density(s, b, wide, share))
        rng.happens(sheet, "sigma_across", lambda s: density(a, s, wide, share))
    if share:
        rng.happens(sheet, "wide_sigma", lambda s: density(a, b, s, share))
        rng.happens(sheet, "wide_share", lambda s: density(a, b, wide, s))
    rng.happens(sheet, "transmission", math.log)


def _chance(index, cos_in, cos_out, passes):
    """Return ln of the chance that a sheet's faces pass a ray, or that they reflect it."""
    r1, r2 = (reflectance(c, 1.0, index) for c in (cos_in, cos_out))
    passed = (1 - r1) * (1 - r2) / (1 - r1 * r2)
    return math.log(passed if passes else 1 - passed)
