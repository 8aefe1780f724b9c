"""The oracle in bands: a weight is one number for each band, beside that which draws the path."""

import copy
import math

import numpy as np

from mpfcad.optics.element import Cavity, Converter
from oracle.ray import Philox, disk, roulette
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


class BandTracer(ReferenceTracer):
    """Traces paths at all bands at once, with converters; scores a channel a band and converter."""

    def __init__(self, variants, source, wavelength, photons, *, below=0.0, above=0.0):
        super().__init__(in_bands(variants), below=below, above=above)
        self.source, self.wavelength, self.photons = source, wavelength, photons
        self.kinds = [e for e in self.elements if isinstance(e, Converter)]

    def channels(self, x, spot, acceptance, rng: Philox, *, y=0.0, spot_along=0.0):
        """Return what one path adds to each channel, (b · (1 + converters),)."""
        bands = len(self.source)
        score = np.zeros((1 + len(self.kinds), bands))
        x += (rng() - 0.5) * spot
        y += (rng() - 0.5) * (spot_along or self.length)
        start = (x, y, 0.0), self._look((0.0, 0.0), acceptance, disk(rng)), False
        number, weight, head, kind = len(self.elements) - 1, Weights(1.0, np.ones(bands)), None, 0
        while True:
            found, total, kept = self._follow(number, *start, weight, rng, head)
            found = found * Weights(1.0, np.ones(bands))
            if head is None:
                score[0] += found.bands
            else:
                score[kind] += (found.bands @ self.source) * head
            lead = roulette(total, rng) if total > 0 else 0.0
            if lead == 0:
                return score.ravel()
            place, number, offered = kept
            element = self.elements[number]
            if head is None:
                head, kind = offered, 1 + self.kinds.index(element)
            px, py = disk(rng)
            dz = math.sqrt(1 - px * px - py * py)
            took = 1 - np.exp(
                -Weights.of(element.depth).bands * np.ones(bands) * slant(element, dz)
            )
            took = element.quantum_yield * self.wavelength / 550.0 * took
            if took.max() <= 0:
                return score.ravel()
            up = rng() < 0.5
            start = place, (px, py, dz if up else -dz), up
            number += 1 if up else -1
            most = lead * took.max()
            kept = roulette(most, rng) / most
            if kept == 0:
                # What ends has passed no other sheet: nothing is drawn from.
                return score.ravel()
            weight = Weights(kept * most, kept * lead * took)

    def _follow(self, number, place, d, up, weight, rng, head):
        """Follow a path to its end: (light found, weight of all conversions, the one drawn)."""
        found, total, kept = Weights.of(0.0), 0.0, None
        while True:
            if number < 0:
                return found + weight * self.below, total, kept
            if number == len(self.elements):
                return found + weight * self.above, total, kept
            element = self.elements[number]
            if isinstance(element, Converter):
                shares = self.photons[self.kinds.index(element)] * 550.0 / self.wavelength
                offered = weight.bands * np.ones(len(shares)) * shares
                chance = offered.sum()
                if chance > 0:
                    total += chance
                    if rng() * total < chance:
                        kept = place, number, offered / chance
                passed = -(Weights.of(element.depth) * slant(element, d[2]))
                weight = weight * passed.exp()
            else:
                up, place, d, weight, seen = self._through(element, up, place, d, weight, rng)
                found = found + seen
            weight = Weights.of(weight)
            factor = roulette(weight.lead, rng) / weight.lead if weight.lead else 0.0
            if factor == 0:
                return found, total, kept
            weight = weight * factor
            number += 1 if up else -1

    def _through(self, element, up, place, d, weight, rng):
        from oracle.cavity import cavity_passage

        if isinstance(element, Cavity):
            return cavity_passage(element, up, place, d, weight, rng)
        name = f"_{type(element).__name__.lower()}"
        return getattr(self, name)(element, up, place, d, weight, rng)


def slant(element, dz):
    """Return 1/cos of the refracted direction within a converting sheet."""
    return 1 / math.cos(math.asin(min(1.0, math.sqrt(1 - dz * dz) / element.index)))
