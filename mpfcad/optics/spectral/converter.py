"""Phosphor or quantum dots: what takes light at some wavelengths and emits at others.

A sheet is thin and has no faces; a film (`film`) has an index, faces, and light within it.

Of light at an angle θ' within it, a sheet passes exp(-depth / cos θ') straight on (Bouguer and
Lambert), and takes the rest. Of the photons taken a share, its yield, is emitted anew with one
spectrum whatever was taken (Kasha, "Characterization of electronic transitions in complex
molecules", 1950), half to each side, Lambertian. Its faces reflect nothing. With the photons N of
each band this is

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
from mpfcad.optics.stokes.state import keep_rows
from mpfcad.sound import refuse_unsound

#: The columns of a converter in `Scene.parameter`.
INDEX, DEPTH, THICKNESS, SCATTERING, ASYMMETRY = range(5)
#: Wavelength [nm] by which photons' energies are counted: numbers stay near 1.
_UNIT_NM = 550.0


@dataclass(frozen=True)
class Converter(Mirrored):
    """A converting sheet or film at one wavelength.

    Attributes
    ----------
    depth
        optical depth along the normal: -ln of what passes
    index
        refractive index within, which bends the ray and with it its path
    thickness
        [mm] of a film with faces of its own; 0: a thin sheet without any
    scattering, asymmetry
        coefficient within a film [1/mm], and mean cosine of one scattering
    quantum_yield
        photons emitted for one taken, 0…1
    """

    depth: float
    index: float = 1.5
    quantum_yield: float = 1.0
    name: str = "converter"
    thickness: float = 0.0
    scattering: float = 0.0
    asymmetry: float = 0.0

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.depth", self.depth, 0.0)
        refuse_unsound(f"{self.name}.index", self.index, 1.0)
        refuse_unsound(f"{self.name}.quantum_yield", self.quantum_yield, 0.0, 1.0)
        refuse_unsound(f"{self.name}.thickness", self.thickness, 0.0)
        refuse_unsound(f"{self.name}.scattering", self.scattering, 0.0)
        refuse_unsound(f"{self.name}.asymmetry", self.asymmetry, -1.0, 1.0)


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
def offer(hue, light, e, depth, length, x, y, weight, rng):
    """Let a path that passes a converting sheet have come from there: one of all is drawn.

    `depth` is that of the scene, by which the path is drawn; `length` its 1/cos θ' within.
    """
    if hue is not None:
        _offer(hue, light, e, depth, length, x, y, weight, rng)


@kernel
def _offer(hue, light, e, depth, length, x, y, weight, rng):
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
    if draws(hue, weight * chance, rng):
        hue.place[slot, 0], hue.place[slot, 1] = x, y
        hue.element[slot] = e
        keep_rows(light, hue.kept[slot])
        for b in range(hue.tint.shape[1]):
            hue.offered[slot, b] = hue.tint[slot, b] * tables.emitted[kind, b] / chance


@kernel
def draws(hue, chance, rng):
    """Return whether a conversion of so much weight is drawn of all that the path has passed."""
    slot, drawn = hue.at[0], False
    if chance > 0.0:
        hue.chance[slot] += chance
        drawn = uniform(rng) * hue.chance[slot] < chance
    return drawn


@kernel
def emitted_for(tables, e, kind, b, depth, length):
    """Return how much a converter emits of a power of 1 that comes at a band."""
    depth += tables.soak[e, MATERIAL, b]
    return tables.taken[kind, b] * -math.expm1(-depth * length)
