"""Particles in a plate or resin: what Mie's theory makes of radius, index and number density.

Mie, "Beiträge zur Optik trüber Medien, speziell kolloidaler Metallösungen", 1908; Bohren and
Huffman, "Absorption and Scattering of Light by Small Particles", 1983. Computed by miepython.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.quantity import Quantity
from mpfcad.units import nm, um

#: What particles need, and the index around them, by the body that they are in, unless it has its
#: own.
PARTICLE = ("particle_radius_um", "particle_index", "particle_density_per_mm3")
MEDIUM = {"plate": "plate_index", "resin": "film_index"}

#: Angles a width of the forward peak, and at least, at which the phase function is taken.
_ANGLES_PER_SIZE, _LEAST_ANGLES = 40, 2000


@dataclass(frozen=True)
class Particles:
    """Equal spheres in a medium, independent of each other.

    Attributes
    ----------
    radius
        [mm]
    index, medium_index
        refractive indices of the spheres and around them
    density
        number of spheres a volume [1/mm³]
    wavelength
        of the light in vacuum [mm]
    """

    radius: float
    index: float
    medium_index: float
    density: float
    wavelength: float

    @property
    def size(self) -> float:
        """Size parameter x = 2 pi radius medium_index / wavelength."""
        return 2 * math.pi * self.radius * self.medium_index / self.wavelength

    @property
    def efficiency(self) -> float:
        """Scattering cross-section over the sphere's own, Q."""
        return _mie(self.index / self.medium_index, self.size)[0]

    @property
    def scattering(self) -> float:
        """Scattering coefficient [1/mm]: density · pi radius² · Q."""
        return self.density * math.pi * self.radius**2 * self.efficiency

    @property
    def asymmetry(self) -> float:
        """Mean cosine of one scattering, g."""
        return _mie(self.index / self.medium_index, self.size)[1]

    def phase(self) -> NDArray[np.float64]:
        """Return the phase function of unpolarised light as its quantiles (`phase_quantiles`)."""
        return _quantiles(self.index / self.medium_index, self.size)


def build_particles(quantity: dict[str, Quantity], body: str) -> Particles | None:
    """Return the particles in the `plate` or `resin`, or None where none are given."""
    if f"{body}_{PARTICLE[0]}" not in quantity:
        return None
    radius, index, density = (quantity[f"{body}_{name}"].value for name in PARTICLE)
    wavelength = quantity["light_wavelength_nm"].value * nm
    medium = quantity.get(f"{body}_index", quantity[MEDIUM[body]]).value
    return Particles(radius * um, index, medium, density, wavelength)


@lru_cache(maxsize=256)
def _mie(ratio: float, size: float) -> tuple[float, float]:
    """Return (Q of scattering, g) of a sphere of relative index `ratio`."""
    import miepython

    if ratio == 1.0:
        return 0.0, 0.0
    _, scattering, _, asymmetry = miepython.efficiencies_mx(ratio, size)
    return float(scattering), float(asymmetry)


@lru_cache(maxsize=16)
def _quantiles(ratio: float, size: float) -> NDArray[np.float64]:
    import miepython

    from mpfcad.optics.base.phase import phase_quantiles

    count = max(_LEAST_ANGLES, math.ceil(_ANGLES_PER_SIZE * size))
    cosine = np.cos(np.linspace(math.pi, 0, count + 1))
    if ratio == 1.0:
        return phase_quantiles(cosine, np.ones_like(cosine))
    return phase_quantiles(cosine, miepython.i_unpolarized(ratio, size, cosine))
