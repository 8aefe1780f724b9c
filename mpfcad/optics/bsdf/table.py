"""What a BSDF table is: how a thin element scatters light from each bin of directions into each.

`value[way, side, i, o]` is the mean of the BSDF [1/sr] over incidence bin i and outgoing bin o, for
light from `side` (0: from below, travelling up; 1: from above) that is transmitted (way 0) or
reflected (way 1). All directions are those of travel in air, as (kx, ky).

An isotropic table has one incidence bin a ring, and its outgoing azimuths count from the incident
ray's; all its rings have the same number of azimuths.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis

TRANSMIT, REFLECT = range(2)
BELOW, ABOVE = range(2)
SIDES = ("below", "above")
WAYS = ("transmission", "reflection")

#: How far above 1 the light leaving for one incidence may be: rounding of files' digits.
ENERGY_TOLERANCE = 1e-3
#: The largest reciprocity error of a table that is claimed to be reciprocal.
RECIPROCITY_LIMIT = 0.05
#: How far above 1 sums may be for a table that the user wants normalised.
NORMALISE_LIMIT = 1.05
_MOST_SCALINGS = 2000


@dataclass(frozen=True, eq=False)
class BsdfTable:
    """A thin element's BSDF.

    Attributes
    ----------
    name
        for messages; the file's
    basis
        the outgoing bins, and the incidence bins but for isotropic tables
    isotropic
        whether only the ring of the incidence counts
    value
        (2, 2, i, o) float64 [1/sr]
    note
        what was taken for granted on reading, a sentence each
    unknown
        (way, side) that nothing is known of, and that nobody uses: 0 in `value`
    """

    name: str
    basis: AngleBasis
    isotropic: bool
    value: NDArray[np.float64]
    note: tuple[str, ...] = ()
    unknown: frozenset[tuple[int, int]] = frozenset()

    @property
    def incidence_polar(self) -> NDArray[np.float64]:
        """Polar angle of each incidence bin, (i,) float64 [rad]."""
        return self.basis.polar if self.isotropic else self.basis.polar[self.basis.ring]

    @property
    def incidence_projected(self) -> NDArray[np.float64]:
        """Projected solid angle of each incidence bin, (i,) float64 [sr]."""
        return self.basis.ring_projected if self.isotropic else self.basis.projected

    @property
    def chance(self) -> NDArray[np.float64]:
        """Share of the light from bin i that leaves into bin o, (2, 2, i, o) float64."""
        return self.value * self.basis.projected

    @property
    def energy(self) -> NDArray[np.float64]:
        """Share of the light transmitted and reflected, (2, 2, i) float64: way, side, incidence."""
        return self.value @ self.basis.projected

    @property
    def hemispherical(self) -> NDArray[np.float64]:
        """Share of Lambertian light transmitted and reflected, (2, 2) float64: way, side."""
        return self.energy @ self.incidence_projected / np.pi

    def reversed_value(self) -> NDArray[np.float64]:
        """Return the BSDF of the reversed paths, shape of `value`; equal to it where reciprocal.

        Light from i to o backward comes from the direction opposite to o and leaves opposite to i;
        transmitted, it then comes from the other side.
        """
        if self.isotropic:
            back = self._split().swapaxes(2, 3)
            count = back.shape[-1]
            back = back[..., -np.arange(count) % count].reshape(self.value.shape)
        else:
            opposite = self.basis.opposite
            back = self.value[:, :, opposite][..., opposite].swapaxes(2, 3)
        return np.stack([back[TRANSMIT, ::-1], back[REFLECT]])

    def _split(self) -> NDArray[np.float64]:
        """Return `value` of an isotropic table as (2, 2, ring in, ring out, azimuth)."""
        rings = len(self.basis.azimuths)
        return self.value.reshape(2, 2, rings, rings, -1)

    @property
    def reciprocity_error(self) -> float:
        """Σ|A - A'|/Σ(A + A'), 0…1: A the light from i to o under Lambertian light, A' reversed."""
        weight = self.incidence_projected[:, None] * self.basis.projected
        back = self.reversed_value()
        total = ((self.value + back) * weight).sum()
        return float((np.abs(self.value - back) * weight).sum() / total) if total > 0 else 0.0

    def checked(self, *, normalise: bool = False) -> "BsdfTable":
        """Return the table: values from 0 up, energy at most 1.

        With `normalise` sums up to `NORMALISE_LIMIT` are accepted: all values are divided by the
        largest, which keeps reciprocity, and a note says so.

        Raises
        ------
        InputError
            naming the side and angle of the incidence where values are wrong or too much leaves.
        """
        wrong = ~np.isfinite(self.value) | (self.value < 0)
        if wrong.any():
            way, side, i, o = np.argwhere(wrong)[0]
            raise InputError(
                f"{self.name}: {WAYS[way]} from {SIDES[side]}, {self._place(i)}: "
                f"{self.value[way, side, i, o]:g}: expected a number from 0 up"
            )
        total = self.energy.sum(axis=0)
        side, i = np.unravel_index(np.argmax(total), total.shape)
        most = float(total[side, i])
        if most <= 1 + ENERGY_TOLERANCE:
            return self
        if normalise and most <= NORMALISE_LIMIT:
            note = f"sums up to {most:.4f} leave: all values divided by it (normalise = true)"
            return replace(self, value=self.value / most, note=(*self.note, note))
        expected = "at most 1"
        if most <= NORMALISE_LIMIT:
            expected += f"; normalise = true accepts up to {NORMALISE_LIMIT:g}"
        elif normalise:
            expected = f"at most {NORMALISE_LIMIT:g} to normalise"
        raise InputError(
            f"{self.name}: light from {SIDES[side]}, {self._place(int(i))}: reflected and "
            f"transmitted {most:.4f}: expected {expected}"
        )

    def summary(self) -> str:
        """Return in a line what was read: file, bins, and what was taken for granted."""
        kind = "isotropic" if self.isotropic else "anisotropic"
        read = f"read {self.name}: {self.basis.name}, {self.basis.count} bins, {kind}"
        return "; ".join((read, *self.note))

    def _place(self, i: int) -> str:
        text = f"incidence {np.degrees(self.incidence_polar[i]):.4g} deg"
        if self.isotropic:
            return text
        return f"{text}, azimuth {np.degrees(self.basis.azimuth[i]):.4g} deg"

    def claimed_reciprocal(self) -> "BsdfTable":
        """Return the table made exactly reciprocal, after checking that it nearly is.

        Raises
        ------
        InputError
            when the reciprocity error is above `RECIPROCITY_LIMIT`.
        """
        error = self.reciprocity_error
        if error > RECIPROCITY_LIMIT:
            raise InputError(
                f"{self.name}: claimed reciprocal: error {error:.4f}: expected at most "
                f"{RECIPROCITY_LIMIT:g}"
            )
        return self.made_reciprocal()

    def made_reciprocal(self) -> "BsdfTable":
        """Return a reciprocal table near this one, with this one's energy for each incidence.

        The mean with the reversed table, then each bin scaled in both roles until all energies are
        as they were (Sinkhorn and Knopp, 1967, in its symmetric form). What scaling cannot give is
        added as d_i d_o / Σd, d the light that is missing: reciprocal too.
        """
        mean = (self.value + self.reversed_value()) / 2
        target = self.energy.sum(axis=0)
        scale = np.ones_like(target)
        for _ in range(_MOST_SCALINGS):
            now = scale * self._gathered(mean, scale)
            ratio = np.where(now > 0, target / np.maximum(now, 1e-300), 1.0)
            if np.abs(ratio - 1).max() < 1e-12:
                break
            scale *= np.sqrt(ratio)
        now = scale * self._gathered(mean, scale)
        most = np.max(now / np.maximum(target, 1e-300), initial=1.0, where=target > 0)
        value = mean * scale[None, :, :, None] * self._leaving(scale)[:, :, None, :] / most
        missing = np.maximum(0.0, target - now / most)
        total = (missing * self.incidence_projected).sum()
        if total > 0:
            value += missing[None, :, :, None] * self._leaving(missing)[:, :, None, :] / total
        return replace(self, value=value)

    def _leaving(self, factor: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (2, i) factors of incidence bins for the bins where the reversed light comes from.

        (2, 2, o): way, side, outgoing bin.
        """
        outgoing = factor[:, self.basis.ring if self.isotropic else self.basis.opposite]
        return np.stack([outgoing[::-1], outgoing])

    def _gathered(self, value: NDArray, factor: NDArray) -> NDArray[np.float64]:
        """Return the light (2, i) leaving when each outgoing bin has its factor."""
        weight = self._leaving(factor) * self.basis.projected
        return np.einsum("wsio,wso->si", value, weight, optimize=True)
