"""A thin sheet of phosphor or quantum dots: it takes light at some wavelengths and emits at others.

Of light at an angle θ' within it, it passes exp(-depth / cos θ') straight on (Bouguer and Lambert),
and takes the rest. Of the photons taken a share, its yield, is emitted anew with one spectrum
whatever was taken (Kasha, "Characterization of electronic transitions in complex molecules", 1950),
half to each side, Lambertian. Its faces reflect nothing. With the photons N of each band this is

    emitted N_m = q_m · yield · Σ_b A_b(θ') N_b,   A_b = 1 - exp(-depth_b / cos θ'), Σ_m q_m = 1,

and with a photon's energy ∝ 1/λ, of power: P_m = (q_m/λ_m) · yield · Σ_b λ_b A_b P_b.

Backward, light of band m that leaves the sheet was either passed, or taken at any band b from a
direction with Lambertian density of either side: then P_b counts (q_m/λ_m) · yield · λ_b A_b(θ'),
the same matrix, transposed (the adjoint; Coveyou, Cain and Yost, "Adjoint and importance in Monte
Carlo application", 1967). The matrix is a product of one vector of m and one of b, so a path goes
on with a vector of weights. A path passes every sheet, and of all that it passed one is drawn, with
the probability of what it may give, from which a second path starts where the first has ended, with
the weight of all of them (sampling a reservoir: Chao, "A general purpose unequal probability
sampling plan", Biometrika 69, 1982). So light that is not converted has no noise from conversion.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.mirror import Mirrored
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.spectral.hue import MATERIAL, OWN
from mpfcad.sound import refuse_unsound

#: The columns of a converter in `Scene.parameter`.
INDEX, DEPTH = range(2)
#: Wavelength [nm] by which photons' energies are counted: numbers stay near 1.
_UNIT_NM = 550.0


@dataclass(frozen=True)
class Converter(Mirrored):
    """A converting sheet at one wavelength.

    Attributes
    ----------
    depth
        optical depth along the normal: -ln of what passes
    index
        refractive index within, which bends the ray and with it its path
    quantum_yield
        photons emitted for one taken, 0…1
    """

    depth: float
    index: float = 1.5
    quantum_yield: float = 1.0
    name: str = "converter"

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.depth", self.depth, 0.0)
        refuse_unsound(f"{self.name}.index", self.index, 1.0)
        refuse_unsound(f"{self.name}.quantum_yield", self.quantum_yield, 0.0, 1.0)


def conversion(
    quantum_yield: float, wavelength: NDArray[np.float64], photons: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the vectors (taken, emitted), (b,) float64 each, whose product converts power.

    wavelength: (b,) [nm], by which photons are counted; photons: (b,), the share of the emitted
    photons in each band.
    """
    return quantum_yield * wavelength / _UNIT_NM, photons * _UNIT_NM / wavelength


@kernel
def slant(index, dz):
    """Return 1/cos θ' of a ray within the sheet, by its cosine `dz` outside."""
    square = 1.0 - (1.0 - dz * dz) / (index * index)
    return 1.0 / math.sqrt(max(square, 1e-12))


@kernel
def offer(hue, e, depth, length, x, y, weight, rng):
    """Let a path that passes a converter have come from there: one of all it passes is drawn.

    `depth` is that of the scene, by which the path is drawn; `length` its 1/cos θ' within.
    """
    if hue is not None:
        _offer(hue, e, depth, length, x, y, weight, rng)


@kernel
def _offer(hue, e, depth, length, x, y, weight, rng):
    slot, tables = hue.at[0], hue.tables
    kind, chance = tables.species[e], 0.0
    for b in range(hue.tint.shape[1]):
        part = hue.tint[slot, b]
        if tables.forward[0] == 0:
            part *= tables.emitted[kind, b]
        else:
            part *= emitted_for(tables, e, kind, b, depth, length)
            if hue.stage[slot] == OWN:
                part *= tables.source[b]
        chance += part
    if chance > 0.0 and weight > 0.0:
        hue.chance[slot] += weight * chance
        if uniform(rng) * hue.chance[slot] < weight * chance:
            hue.place[slot, 0], hue.place[slot, 1] = x, y
            hue.element[slot] = e
            for b in range(hue.tint.shape[1]):
                hue.offered[slot, b] = hue.tint[slot, b] * tables.emitted[kind, b] / chance


@kernel
def emitted_for(tables, e, kind, b, depth, length):
    """Return how much a converter emits of a power of 1 that comes at a band."""
    depth += tables.soak[e, MATERIAL, b]
    return tables.taken[kind, b] * -math.expm1(-depth * length)
