"""The oracle in bands: a weight is one number for each band, beside that which draws the path."""

import copy
import math

import numpy as np

from mpfcad.optics.element import Cavity, Converter
from mpfcad.optics.stokes.plane import PlaneLayer
from oracle.ray import Philox, about, disk, refract, roulette, scattering_cosine
from oracle.tracer import ReferenceTracer


class Weights:
    """A number for each band; comparisons are those of the first, by which the path is drawn."""

    def __init__(self, lead, bands):
        self.lead, self.bands = lead, np.asarray(bands, float)

    @classmethod
    def of(cls, value):
        return value if isinstance(value, cls) else cls(value, value)

    def _with(self, other, do):
        other = Weights.of(other)
        return Weights(do(self.lead, other.lead), do(self.bands, other.bands))

    def __mul__(self, other):
        return self._with(other, lambda a, b: a * b)

    def __add__(self, other):
        return self._with(other, lambda a, b: a + b)

    def __rsub__(self, other):
        return Weights.of(other)._with(self, lambda a, b: a - b)

    def __neg__(self):
        return Weights(-self.lead, -self.bands)

    __rmul__, __radd__ = __mul__, __add__

    def exp(self):
        return Weights(math.exp(self.lead), np.exp(self.bands))

    def __gt__(self, other):
        return self.lead > other

    def __ge__(self, other):
        return self.lead >= other

    def __eq__(self, other):
        return self.lead == other

    __hash__ = None


def in_bands(variants):
    """Return the elements of several bands as one list whose numbers are `Weights`."""
    joined = []
    for same in zip(*variants, strict=True):
        element = copy.copy(same[0])
        if getattr(element, "resin", None) is not None:
            object.__setattr__(element, "resin", in_bands([[one.resin] for one in same])[0])
        for name, best in (
            ("absorption", min), ("depth", min), ("transmission", max), ("reflectance", max),
            ("lamp_reflectance", max),
        ):  # fmt: skip
            values = [getattr(one, name, None) for one in same]
            if None not in values and len(set(values)) > 1:
                object.__setattr__(element, name, Weights(best(values), values))
        joined.append(element)
    return joined


class Drawn:
    """One of all the conversions that a path has passed: their weight, and the one."""

    def __init__(self):
        self.total, self.one = 0.0, None

    def offer(self, rng, chance, one):
        if chance > 0:
            self.total += chance
            if rng() * self.total < chance:
                self.one = one


class BandTracer(ReferenceTracer):
    """Traces paths at all bands at once, with converters; scores a channel a band and converter."""

    def __init__(self, variants, source, wavelength, photons, *, below=0.0, above=0.0):
        super().__init__(in_bands(variants), below=below, above=above)
        self.source, self.wavelength, self.photons = source, wavelength, photons
        self.kinds = [e for e in self.elements if isinstance(e, Converter)]

    def channels(self, x, spot, acceptance, rng: Philox, *, y=0.0, spot_along=0.0):
        """Return what one path adds to each meter's channels, (meters, b · (1 + converters))."""
        bands = len(self.source)
        x += (rng() - 0.5) * spot
        y += (rng() - 0.5) * (spot_along or self.length)
        start = (x, y, 0.0), self._look((0.0, 0.0), acceptance, disk(rng)), False
        rng.start(start[1])
        score = np.zeros((len(rng.meters), 1 + len(self.kinds), bands))
        number, weight, head, kind = len(self.elements) - 1, Weights(1.0, np.ones(bands)), None, 0
        drawn = Drawn()
        while True:
            found = self._follow(number, *start, weight, rng, drawn) if weight.lead else 0.0
            if head is None:
                score[:, 0] += found
            else:
                score[:, kind] += (found @ self.source)[:, None] * head if weight.lead else 0.0
            lead = roulette(drawn.total, rng) if drawn.total > 0 else 0.0
            if lead == 0:
                return score.reshape(len(score), -1)
            place, number, offered, meters = drawn.one
            drawn = Drawn()
            element = self.elements[number]
            if head is None:
                head, kind = offered, 1 + self.kinds.index(element)
            taken = element.quantum_yield * self.wavelength / 550.0
            depth = Weights.of(element.depth).bands * np.ones(bands)
            if element.thickness:
                z = 2 * rng() - 1
                angle = 2 * math.pi * rng()
                d = (*(math.sqrt(1 - z * z) * f(angle) for f in (math.cos, math.sin)), z)
                took = taken * depth
            else:
                px, py = disk(rng)
                d = (px, py, math.sqrt(1 - px * px - py * py))
                took = taken * (1 - np.exp(-depth * slant(element, d[2])))
            if took.max() <= 0:
                return score.reshape(len(score), -1)
            rng.begin_again(meters)
            weight = Weights(lead * took.max(), lead * took)
            if element.thickness:
                up, place, d, weight = self._within(number, place, d, weight, rng, drawn)
            else:
                up = rng() < 0.5
                d = d if up else (d[0], d[1], -d[2])
            start = place, d, up
            number += 1 if up else -1
            weight = thinned(weight, rng)

    def _follow(self, number, place, d, up, weight, rng, drawn):
        """Follow a path to its end; return the light that each meter finds, (meters, b)."""
        found = np.zeros((len(rng.meters), len(self.source)))
        one = Weights(1.0, np.ones(len(self.source)))
        while True:
            if not 0 <= number < len(self.elements):
                radiance = self.below if number < 0 else self.above
                return found + np.outer(rng.meters, (weight * one * radiance).bands)
            element = self.elements[number]
            if isinstance(element, Converter):
                passing = self._film_of_dots if element.thickness else self._sheet_of_dots
                up, place, d, weight = passing(number, up, place, d, weight, rng, drawn)
            else:
                up, place, d, weight, seen = self._through(element, up, place, d, weight, rng)
                found = found + np.outer(rng.meters, (seen * one).bands)
            weight = thinned(Weights.of(weight), rng)
            if weight.lead == 0:
                return found
            number += 1 if up else -1

    def _emitted(self, number):
        shares = self.photons[self.kinds.index(self.elements[number])]
        return shares * 550.0 / self.wavelength

    def _sheet_of_dots(self, number, up, place, d, weight, rng, drawn):
        element = self.elements[number]
        offered = weight.bands * self._emitted(number)
        chance = offered.sum()
        drawn.offer(rng, chance, (place, number, offered / max(chance, 1e-300), rng.meters))
        return up, place, d, weight * (-(Weights.of(element.depth) * slant(element, d[2]))).exp()

    def _film_of_dots(self, number, up, place, d, weight, rng, drawn):
        element = self.elements[number]
        if rng.reflects(d, (0.0, 0.0, 1.0), 1.0, element.index):
            return not up, place, (d[0], d[1], -d[2]), weight
        d = refract(d, (0.0, 0.0, -math.copysign(1.0, d[2])), 1.0, element.index)
        place = (*place[:2], 0.0 if up else element.thickness)
        return self._within(number, place, d, weight, rng, drawn)

    def _within(self, number, place, d, weight, rng, drawn):
        """Follow a path within a film: step, take, scatter or meet a face."""
        film = self.elements[number]
        thick, depth, dead = film.thickness, Weights.of(film.depth), Weights(0.0, 0.0 * self.source)
        x, y, z = place
        while True:
            face = ((thick if d[2] > 0 else 0.0) - z) / d[2]
            free = -math.log(1 - rng()) / film.scattering if film.scattering else math.inf
            step = min(face, free)
            guided = not film.scattering and math.hypot(d[0], d[1]) >= 1 / film.index
            rates = (depth.bands * np.ones(len(self.source)))[weight.bands > 0]
            if guided and not (rates > 0).any():
                return True, (x, y, z), d, dead
            if guided:
                # Lengths in thicknesses; the way goes on for good between the faces.
                rate = rates[rates > 0].min()
                length = -math.log(1 - rng()) / rate
                span = math.exp(rate * length) / rate
            else:
                span = step / thick
                length = rng() * span
            offered = (weight * (-(depth * length)).exp()).bands * self._emitted(number) * span
            s, chance = length * thick, offered.sum()
            at = abs((z + s * d[2] + thick) % (2 * thick) - thick)
            drawn.offer(
                rng, chance, ((x + s * d[0], y + s * d[1], at), number,
                              offered / max(chance, 1e-300), rng.meters),
            )  # fmt: skip
            if guided:
                return True, (x, y, z), d, dead
            weight = weight * (-(depth * (step / thick))).exp()
            if isinstance(film.depth, Weights):
                weight = Weights(weight.bands.max(), weight.bands)
            weight = thinned(weight, rng)
            if weight.lead == 0:
                return True, (x, y, z), d, weight
            x, y, z = x + step * d[0], y + step * d[1], z + step * d[2]
            if free < face:
                cosine = scattering_cosine(None, film.asymmetry, rng())
                d = about(d, cosine, 2 * math.pi * rng())
                rng.depolarise()
                continue
            up = d[2] > 0
            z = thick if up else 0.0
            if rng.reflects(d, (0.0, 0.0, 1.0), film.index, 1.0):
                d = (d[0], d[1], -d[2])
                continue
            d = refract(d, (0.0, 0.0, -math.copysign(1.0, d[2])), film.index, 1.0)
            return up, (x, y, 0.0), d, weight

    def _through(self, element, up, place, d, weight, rng):
        from oracle.cavity import cavity_passage

        if isinstance(element, Cavity):
            return cavity_passage(element, up, place, d, weight, rng)
        name = "_plane" if isinstance(element, PlaneLayer) else f"_{type(element).__name__.lower()}"
        return getattr(self, name)(element, up, place, d, weight, rng)


def thinned(weight, rng):
    """Return the weight that the roulette leaves."""
    factor = roulette(weight.lead, rng) / weight.lead if weight.lead else 0.0
    return weight * factor


def slant(element, dz):
    """Return 1/cos of the refracted direction within a converting sheet."""
    return 1 / math.cos(math.asin(min(1.0, math.sqrt(1 - dz * dz) / element.index)))
