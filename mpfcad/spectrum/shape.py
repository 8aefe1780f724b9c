"""The spectrum of a lamp or a phosphor: power by wavelength, on the observer's wavelengths."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.spectrum.cie import LUMENS_PER_WATT, matching_functions, wavelengths

#: Second radiation constant h c / k [nm K] (SI, exact constants).
_SECOND_RADIATION = 1.438776877e7


@dataclass(frozen=True)
class Spectrum:
    """Power a nanometre at each of `cie.wavelengths`, in any unit, and where it comes from.

    Attributes
    ----------
    power
        (471,) values, none below 0
    first, last
        the wavelengths [nm] over which it was stated; beyond them there is no power
    title, tag, source
        what it is, in words; `given`, `sourced` or `assumed`; where it comes from
    """

    power: tuple[float, ...]
    first: float
    last: float
    title: str
    tag: str = "given"
    source: str = "given by the user"

    @property
    def values(self) -> NDArray[np.float64]:
        """The power, (471,) float64."""
        return np.array(self.power)

    @property
    def efficacy(self) -> float:
        """Lumens a watt, 683 ∫ S y / ∫ S."""
        power = self.values
        return float(LUMENS_PER_WATT * (power @ matching_functions()[:, 1]) / power.sum())


def gaussian(peak: float, fwhm: float) -> NDArray[np.float64]:
    """Return exp(-4 ln 2 ((λ - peak)/fwhm)²) [nm], (471,) float64: an LED's or a quantum dot's.

    Each value is the mean over the nanometre about its wavelength.
    """
    rate = 2 * math.sqrt(math.log(2.0)) / fwhm
    below = np.array([math.erf(rate * (edge - peak)) for edge in _edges()])
    return np.asarray(math.sqrt(math.pi) / (2 * rate) * np.diff(below))


def planckian(temperature: float) -> NDArray[np.float64]:
    """Return the power of a black body of so many kelvin, its largest 1, (471,) float64 (Planck).

    S(λ) ∝ λ⁻⁵ / (exp(c₂/(λ T)) - 1), c₂ = 0.01438776877 m K.
    """
    length = wavelengths()
    power = length**-5.0 / np.expm1(_SECOND_RADIATION / (length * temperature))
    return np.asarray(power / power.max())


def interpolated(
    wavelength: NDArray[np.float64], power: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return a table's power, linear between its rows and 0 beyond them, (471,) float64.

    Of rows that are nearer than 1 nm each value is the mean over the nanometre about its
    wavelength, so that no line between two wavelengths is missed.
    """
    if np.diff(wavelength).min() >= 1.0:
        return np.interp(wavelengths(), wavelength, power, left=0.0, right=0.0)
    edge = np.clip(_edges(), wavelength[0], wavelength[-1])
    knot = np.union1d(wavelength, edge)
    value = np.interp(knot, wavelength, power)
    part = np.diff(knot) * (value[1:] + value[:-1]) / 2
    below = np.concatenate([[0.0], np.cumsum(part)])
    return np.asarray(np.diff(below[np.searchsorted(knot, edge)]))


def _edges() -> NDArray[np.float64]:
    """Return where the nanometres about `wavelengths` end, (472,) float64."""
    length = wavelengths()
    return np.append(length - 0.5, length[-1] + 0.5)
