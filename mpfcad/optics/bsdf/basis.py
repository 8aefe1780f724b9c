"""Bins of directions over a hemisphere: rings of polar angle, each split evenly in azimuth.

A direction is the (kx, ky) of its way of travel, azimuth 0 along +x. Bin m of a ring of n is
centred at azimuth 2π·m/n. Direct transmission and mirror reflection keep (kx, ky): the diagonal.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError

_KLEMS = {
    "LBNL/Klems Full": (
        (0, 5, 15, 25, 35, 45, 55, 65, 75, 90), (1, 8, 16, 20, 24, 24, 24, 16, 12),
    ),
    "LBNL/Klems Half": ((0, 6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90), (1, 8, 12, 16, 20, 12, 4)),
    "LBNL/Klems Quarter": ((0, 9, 27, 46, 66, 90), (1, 8, 12, 12, 8)),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class AngleBasis:
    """Rings between polar angles `edge`, ring r split into `azimuths[r]` bins.

    Attributes
    ----------
    name
        as it stands in a Klems XML file
    edge
        (r+1,) float64 [rad], from 0 to π/2, rising
    azimuths
        (r,) int64, bins of each ring
    """

    name: str
    edge: NDArray[np.float64]
    azimuths: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number of bins."""
        return int(self.azimuths.sum())

    @property
    def first(self) -> NDArray[np.int64]:
        """First bin of each ring and the number of bins, (r+1,) int64."""
        return np.concatenate([[0], np.cumsum(self.azimuths)])

    @property
    def ring(self) -> NDArray[np.int64]:
        """Ring of each bin, (n,) int64."""
        return np.repeat(np.arange(len(self.azimuths)), self.azimuths)

    @property
    def sin2_edge(self) -> NDArray[np.float64]:
        """Squared sine at the edges, (r+1,) float64; projected solid angle goes as it."""
        return np.sin(self.edge) ** 2

    @property
    def ring_projected(self) -> NDArray[np.float64]:
        """Projected solid angle of each ring, (r,) float64 [sr]: π·(sin²θ₁ - sin²θ₀)."""
        return np.pi * np.diff(self.sin2_edge)

    @property
    def projected(self) -> NDArray[np.float64]:
        """Projected solid angle of each bin, (n,) float64 [sr]."""
        return (self.ring_projected / self.azimuths)[self.ring]

    @property
    def polar(self) -> NDArray[np.float64]:
        """Polar angle at each ring's middle, (r,) float64 [rad]; 0 for an undivided cap."""
        middle = (self.edge[:-1] + self.edge[1:]) / 2
        return np.where((self.edge[:-1] == 0) & (self.azimuths == 1), 0.0, middle)

    @property
    def azimuth(self) -> NDArray[np.float64]:
        """Azimuth of each bin's middle, (n,) float64 [rad]."""
        turns = [np.arange(n) / n for n in self.azimuths]
        return 2 * np.pi * np.concatenate(turns)

    @property
    def opposite(self) -> NDArray[np.int64]:
        """Bin of the reversed direction (-kx, -ky) of each bin, (n,) int64.

        Raises
        ------
        InputError
            when a ring has an odd number of bins (but one).
        """
        odd = (self.azimuths % 2 == 1) & (self.azimuths > 1)
        if odd.any():
            raise InputError(
                f"{self.name}: a ring of {self.azimuths[odd][0]} azimuths: expected 1 or an even "
                f"number"
            )
        turned = [(np.arange(n) + n // 2) % n for n in self.azimuths]
        return np.concatenate([f + t for f, t in zip(self.first, turned, strict=False)])

    def bin_of(self, kx: ArrayLike, ky: ArrayLike) -> NDArray[np.int64]:
        """Return the bin of each direction (kx, ky) in the unit disk."""
        kx, ky = np.asarray(kx, float), np.asarray(ky, float)
        last = len(self.azimuths) - 1
        ring = np.searchsorted(self.sin2_edge, kx**2 + ky**2, "right") - 1
        ring = np.clip(ring, 0, last)
        n = self.azimuths[ring]
        m = np.floor(np.arctan2(ky, kx) / (2 * np.pi) * n + 0.5).astype(np.int64)
        return self.first[ring] + m % n

    def is_same(self, other: "AngleBasis") -> bool:
        """Tell whether both have the same bins."""
        return np.array_equal(self.azimuths, other.azimuths) and np.allclose(
            self.edge, other.edge, rtol=0, atol=1e-9
        )


def klems_basis(name: str) -> AngleBasis:
    """Return a basis of J. H. Klems ("A new method for predicting the solar heat gain", 1994).

    Raises
    ------
    InputError
        when the name is none of `LBNL/Klems Full`, `Half`, `Quarter`.
    """
    for known, (edge_deg, azimuths) in _KLEMS.items():
        if known.lower() == name.lower():
            return AngleBasis(known, np.radians(edge_deg), np.array(azimuths, np.int64))
    raise InputError(f"basis: {name}: expected {', '.join(_KLEMS)}")


def even_basis(rings: int) -> AngleBasis:
    """Return `rings` rings of equal polar angle with bins about as wide as a ring is high."""
    edge = np.linspace(0, np.pi / 2, rings + 1)
    around = 2 * np.pi * np.sin((edge[:-1] + edge[1:]) / 2) / edge[1]
    return AngleBasis(f"mpfcad/{rings}", edge, (4 * np.ceil(around / 4)).astype(np.int64))


def ring_basis(edge: NDArray[np.float64], azimuths: int) -> AngleBasis:
    """Return rings between `edge` [rad], each of `azimuths` bins: the outgoing bins of isotropy."""
    edge = np.asarray(edge, float)
    count = np.full(len(edge) - 1, azimuths, np.int64)
    return AngleBasis(f"rings {len(count)} x {azimuths}", edge, count)


def edges_between(polar: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ring edges [rad] halfway between measured polar angles (n,), from 0 to π/2."""
    return np.concatenate([[0.0], (polar[:-1] + polar[1:]) / 2, [np.pi / 2]])
