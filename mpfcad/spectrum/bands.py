"""Light in bands: what a lamp sends in each, and the colour that light of each makes.

Paths are followed at one wavelength a band. A band reaches halfway to its neighbours, the first and
the last to the ends of the observer's range, so that no light is left out: a lamp seen through what
treats all wavelengths alike has its own colour exactly. Within a band a lamp's or phosphor's light
keeps its own spectrum, and with it its own colour (`colour`).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.spectrum.cie import matching_functions, wavelengths
from mpfcad.spectrum.shape import Spectrum

LEAST, MOST = 3, 31
DISPERSION = ("traced", "neglected")


@dataclass(frozen=True)
class Bands:
    """The bands of a stack's light, and what in it depends on them.

    Attributes
    ----------
    wavelength
        [nm], rising
    spectrum
        of the lamps
    dispersion
        one of `DISPERSION`: whether indices and scattering that depend on the wavelength are traced
        so, or taken at the stack's one wavelength
    emission
        by the name of a layer that converts light, what it emits
    value
        by its name, a value of the stack at each band, where it is not the same at all
    neglected
        names of the values whose dispersion is neglected
    """

    wavelength: tuple[float, ...]
    spectrum: Spectrum
    dispersion: str = "traced"
    emission: dict[str, Spectrum] = field(default_factory=dict)
    value: dict[str, tuple[float, ...]] = field(default_factory=dict)
    neglected: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """How many bands there are."""
        return len(self.wavelength)

    @property
    def of_nm(self) -> NDArray[np.int64]:
        """The band of each of `cie.wavelengths`, (471,) int64; halfway belongs to the upper."""
        middle = np.array(self.wavelength)
        return np.searchsorted((middle[1:] + middle[:-1]) / 2, wavelengths(), side="right")

    def sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sums within each band of values at `cie.wavelengths`, (471, …) to (b, …)."""
        found = np.zeros((self.count, *values.shape[1:]))
        np.add.at(found, self.of_nm, values)
        return found

    def share(self, spectrum: Spectrum) -> NDArray[np.float64]:
        """Return the share of a spectrum's power in each band, (b,) float64."""
        power = self.sums(spectrum.values)
        return power / power.sum()

    def colour(self, spectrum: Spectrum) -> NDArray[np.float64]:
        """Return X, Y, Z of a spectrum's light in each band for a power of 1 there, (b, 3) float64.

        0 where it has none.
        """
        power = self.sums(spectrum.values)
        xyz = self.sums(spectrum.values[:, None] * matching_functions())
        return xyz / np.where(power > 0, power, 1.0)[:, None]

    @property
    def source_power(self) -> NDArray[np.float64]:
        """The lamps' power in each band for a luminance of 1, (b,) float64: Σ power · Y = 1."""
        share = self.share(self.spectrum)
        return share / float(share @ self.colour(self.spectrum)[:, 1])

    @property
    def mean_wavelength(self) -> NDArray[np.float64]:
        """The wavelength [nm] by which a band's photons are counted, (b,) float64.

        The mean of all light there, the lamps' and each phosphor's counting alike.
        """
        every = [self.spectrum, *self.emission.values()]
        power = sum(one.values / one.values.sum() for one in every)
        here = self.sums(power)
        mean = self.sums(power * wavelengths()) / np.where(here > 0, here, 1.0)
        return np.where(here > 0, mean, self.wavelength)

    def photons(self, spectrum: Spectrum) -> NDArray[np.float64]:
        """Return the share of a spectrum's photons in each band, (b,) float64."""
        number = self.sums(spectrum.values * wavelengths())
        return number / number.sum()

    @property
    def channel_colour(self) -> NDArray[np.float64]:
        """X, Y, Z of what each channel of a trace counts, (b · (1 + converters), 3) float64.

        First the lamps' own light, a band each, over that which the lamps would send to the meter
        if it saw nothing else; then, a band each, the power that each converter has emitted.
        """
        own = self.source_power[:, None] * self.colour(self.spectrum)
        return np.concatenate([own, *(self.colour(one) for one in self.emission.values())])

    @property
    def separate(self) -> tuple[str, ...]:
        """Names of the values by which light of one band takes another way than of the next."""
        return tuple(key for key in self.value if not weighs_only(key))


def weighs_only(name: str) -> bool:
    """Return whether a value of a stack only weakens light, and so leaves its way as it is."""
    ends = ("absorption_per_mm", "absorptance", "reflectance", "transmission")
    return name.endswith(ends)
