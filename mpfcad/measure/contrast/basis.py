"""Functions that a luminance curve is made of: waves, each of a prior variance by its frequency."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Largest frequency [1/pitch]: points stand 1/32 apart.
_HIGHEST = 16
#: How far beyond its ends [pitch] a curve without period is described.
_MARGIN = 0.5
#: A curve repeats visibly over so many pitches.
_LEAST_PITCHES = 3


class Spectrum(NamedTuple):
    """How the variance of a curve's waves falls with frequency f [1/pitch].

    `roughness` ν: (1 + (f/cutoff)²)^(-ν-1/2), of Matérn's process; inf: exp(-(f/cutoff)²/2).
    """

    roughness: float
    cutoff: float

    @property
    def is_rough(self) -> bool:
        """Whether curves of it have kinks."""
        return not np.isinf(self.roughness)

    def density(self, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the relative variance at frequencies (p,)."""
        square = (frequency / self.cutoff) ** 2
        if np.isinf(self.roughness):
            return np.exp(-square / 2)
        return (1 + square) ** (-self.roughness - 0.5)


#: Rough ones, from what has kinks to what changes from point to point, and smooth ones.
SPECTRA = tuple(
    [Spectrum(1.5, f) for f in (0.5, 2.0, 8.0)]
    + [Spectrum(np.inf, f) for f in (0.75, 1.25, 2.0, 3.0)]
)


class Choice(NamedTuple):
    """The prior of one group of waves: number in `SPECTRA`, variance over that of the noise."""

    spectrum: int
    variance: float


@dataclass(frozen=True, eq=False)
class Basis:
    """Waves at the points and where the curve is read.

    Attributes
    ----------
    at_points, at_reading
        (n, p), (k, p) float64, the waves' values
    at_lines
        (k, p) float64, the same on straight lines from point to point
    frequency
        (p,) float64 [1/pitch]
    groups
        of bool (p,): waves that share a spectrum
    """

    at_points: NDArray[np.float64]
    at_reading: NDArray[np.float64]
    at_lines: NDArray[np.float64]
    frequency: NDArray[np.float64]
    groups: tuple[NDArray[np.bool_], ...]

    def variance(
        self, choices: tuple[Choice, ...], noise: float, rough: float = 1.0
    ) -> NDArray[np.float64]:
        """Return the prior variance of each wave, (p,), in units of `noise`; of rough ones more."""
        found = np.zeros(len(self.frequency))
        for group, (spectrum, variance) in enumerate(choices):
            more = rough if SPECTRA[spectrum].is_rough else 1.0
            found += self._unit(group, spectrum) * (noise * variance * more)
        return found

    def _unit(self, group: int, spectrum: int) -> NDArray[np.float64]:
        """Return a group's variances so that the points' own is 1 in the mean."""
        if (group, spectrum) not in self._units:
            density = np.where(self.groups[group], SPECTRA[spectrum].density(self.frequency), 0.0)
            mean = np.mean(self.at_points**2 @ density)
            self._units[group, spectrum] = density / mean
        return self._units[group, spectrum]

    @cached_property
    def _units(self) -> dict[tuple[int, int], NDArray[np.float64]]:
        return {}


def build_basis(
    position: NDArray[np.float64], reading: NDArray[np.float64], *, periodic: bool
) -> Basis:
    """Return the waves of a curve; positions in pitches, ascending.

    A curve that repeats with the pitch has its harmonics. One that does not has cosines over its
    length and a margin ("Hilbert space methods for reduced-rank Gaussian process regression", Solin
    and Särkkä, 2020); over three pitches and more also the harmonics that all of it shares.
    """
    ends = float(position[0]) - _MARGIN, float(np.ptp(position)) + 2 * _MARGIN
    shared = periodic or np.ptp(position) > _LEAST_PITCHES - 0.5

    def waves(x: NDArray[np.float64]) -> NDArray[np.float64]:
        parts = [_harmonics(x)] if shared else []
        return np.hstack(parts if periodic else [*parts, _cosines(x, *ends)])

    order = np.arange(1, _HIGHEST + 1).astype(float)
    number = np.arange(1, _cosine_count(ends[1]) + 1)
    frequency = [order, order] if shared else []
    frequency += [] if periodic else [number / (2 * ends[1])]
    found = np.concatenate(frequency)
    is_shared = np.arange(len(found)) < (2 * _HIGHEST if shared else 0)
    groups = tuple(group for group in (is_shared, ~is_shared) if group.any())
    at_points = waves(position)
    lines = np.stack([np.interp(reading, position, one) for one in np.eye(len(position))], 1)
    return Basis(at_points, waves(reading), lines @ at_points, found, groups)


def _harmonics(x: NDArray[np.float64]) -> NDArray[np.float64]:
    angle = 2 * np.pi * x[:, None] * np.arange(1, _HIGHEST + 1)
    return np.hstack([np.cos(angle), np.sin(angle)])


def _cosine_count(length: float) -> int:
    return round(2 * _HIGHEST * length)


def _cosines(x: NDArray[np.float64], first: float, length: float) -> NDArray[np.float64]:
    number = np.arange(1, _cosine_count(length) + 1)
    return np.cos(np.pi * (x[:, None] - first) / length * number)
