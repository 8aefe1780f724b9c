"""How an LED emits over direction: a table of intensity, its value and exact samples of it.

Intensity is tabulated at polar angles of equal steps over 0 … 90° and at azimuths of equal steps
round; between them it is linear in the cosine of the polar angle and in the azimuth. A sample
chooses a piece by its flux, then the place in it by inversion, so its density is the table itself.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform

#: Pieces over 0 … 90°.
STEPS = 180


class EmissionArrays(NamedTuple):
    """What the kernels read of an `Emission`.

    Attributes
    ----------
    cosine
        (STEPS+1,) float64, of the polar angles, from 1 down to 0
    intensity
        (m+1, STEPS+1) float64 [1/sr], of a flux of 1; the last azimuth repeats the first
    cumulative
        (m · STEPS,) float64, share of the flux up to and with each piece
    """

    cosine: NDArray[np.float64]
    intensity: NDArray[np.float64]
    cumulative: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Emission:
    """Relative intensity of an emitter over the upper half-space.

    Attributes
    ----------
    intensity
        (m, STEPS+1) float64, at m azimuths 2π i/m from x and polar angles π/2 · j/STEPS
    """

    intensity: NDArray[np.float64]

    @classmethod
    def of_polar(cls, angle: NDArray[np.float64], intensity: NDArray[np.float64]) -> "Emission":
        """Return the emission that is the same all round, linear between polar angles [rad]."""
        return cls(np.interp(polar_angles(), angle, intensity)[None])

    @classmethod
    def cosine_power(cls, exponent: float) -> "Emission":
        """Return I = cos^m θ, m = `exponent` (1: Lambertian)."""
        return cls(np.clip(np.cos(polar_angles()), 0.0, 1.0)[None] ** exponent)

    def arrays(self) -> EmissionArrays:
        """Return the tables for a flux of 1."""
        cosine = np.cos(polar_angles())
        cosine[-1] = 0.0
        value = np.concatenate([self.intensity, self.intensity[:1]])
        corner = value[:-1, :-1] + value[:-1, 1:] + value[1:, :-1] + value[1:, 1:]
        solid = -np.diff(cosine) * 2 * np.pi / len(self.intensity)
        flux = np.cumsum((corner / 4 * solid).ravel())
        return EmissionArrays(cosine, value / flux[-1], flux / flux[-1])

    @classmethod
    def none(cls) -> EmissionArrays:
        """Return the tables of a scene without LEDs."""
        return EmissionArrays(np.zeros(0), np.zeros((0, 0)), np.zeros(0))


def polar_angles() -> NDArray[np.float64]:
    """Return the table's polar angles [rad], (STEPS+1,) float64."""
    return np.linspace(0, np.pi / 2, STEPS + 1)


@kernel
def emitted_intensity(emission, dx, dy, dz):
    """Return the intensity [1/sr] of a flux of 1 in a direction, dz ≥ 0."""
    cosine, intensity = emission.cosine, emission.intensity
    j = min(STEPS - 1, int(math.acos(min(dz, 1.0)) * (2.0 * STEPS / math.pi)))
    t = (dz - cosine[j]) / (cosine[j + 1] - cosine[j])
    azimuths = len(intensity) - 1
    turn = math.atan2(dy, dx) / (2.0 * math.pi) * azimuths
    i = math.floor(turn)
    s = turn - i
    i = int(i) % azimuths
    first = intensity[i, j] * (1.0 - t) + intensity[i, j + 1] * t
    second = intensity[i + 1, j] * (1.0 - t) + intensity[i + 1, j + 1] * t
    return first * (1.0 - s) + second * s


@kernel
def _linear(a, b, u):
    """Return where in 0 … 1 a density that goes straight from a to b has passed the share u."""
    root = math.sqrt(a * a + (b * b - a * a) * u)
    return min(1.0, u * (a + b) / (a + root)) if a + root > 0.0 else 0.0


@kernel
def emitted_direction(emission, rng):
    """Return a direction drawn with the intensity as density."""
    cumulative, cosine, intensity = emission.cumulative, emission.cosine, emission.intensity
    share = uniform(rng)
    low, high = 0, len(cumulative) - 1
    while low < high:
        middle = (low + high) // 2
        if cumulative[middle] > share:
            high = middle
        else:
            low = middle + 1
    i, j = low // STEPS, low % STEPS
    a, b = intensity[i, j], intensity[i, j + 1]
    c, d = intensity[i + 1, j], intensity[i + 1, j + 1]
    t = _linear(a + c, b + d, uniform(rng))
    s = _linear(a * (1.0 - t) + b * t, c * (1.0 - t) + d * t, uniform(rng))
    dz = cosine[j] + t * (cosine[j + 1] - cosine[j])
    azimuth = 2.0 * math.pi * (i + s) / (len(intensity) - 1)
    sine = math.sqrt(max(0.0, 1.0 - dz * dz))
    return sine * math.cos(azimuth), sine * math.sin(azimuth), dz
