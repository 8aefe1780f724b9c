"""Resin in the grooves of a prism film that scatters, or is of another material than the prisms.

The resin is what lies above the prisms' surface, which is read from a mesh of the prisms alone.

* Of one index and absorption with the prisms, light does not see the surface between them. Free
  paths are drawn as if the whole zone of the prisms scattered, and collisions that fall into a
  prism are passed over (delta tracking; Woodcock et al., "Techniques used in the GEM code for Monte
  Carlo neutronics calculations in reactors and other systems of complex geometry", 1965).
* Of its own index or absorption, the surface between them reflects and refracts (`passage`).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.sound import refuse_unsound

#: Roundings of a corner that may lie between two facets of one wall, at slopes of up to 2.
_ROUNDINGS = 4


@dataclass(frozen=True, eq=False)
class Resin:
    """What lies in the grooves: it scatters, or has its own index or absorption, or both.

    Attributes
    ----------
    prism
        the film without resin, drawn along y, on the same underside and as wide as the film
    scattering
        coefficient [1/mm]
    asymmetry
        g, mean cosine of one scattering (Henyey and Greenstein, 1941)
    phase
        (STEPS+1,) float64, cosines at equal steps of probability in place of `asymmetry`
    index, absorption
        its refractive index; its coefficient [1/mm]; None: the prisms'
    """

    prism: FilmMesh
    scattering: float = 0.0
    asymmetry: float = 0.0
    phase: NDArray[np.float64] | None = None
    index: float | None = None
    absorption: float | None = None

    def __post_init__(self) -> None:
        refuse_unsound("resin.scattering", self.scattering, 0.0)
        refuse_unsound("resin.asymmetry", self.asymmetry, -1.0, 1.0)
        if self.index is not None:
            refuse_unsound("resin.index", self.index, 1.0)
        if self.absorption is not None:
            refuse_unsound("resin.absorption", self.absorption, 0.0)

    @property
    def thinnest(self) -> float:
        """Thickness [mm] below which there is no resin: what the file's float32 cannot tell.

        A facet of the film without resin lies on the prism's, each with corners rounded by itself.
        """
        largest = float(np.abs(self.prism.vertex).max())
        return _ROUNDINGS * float(np.spacing(np.float32(largest)))


@kernel
def segment_over(chain, x):
    """Return the segment of a chain that lies over x [mm]; beyond its ends, the first or last."""
    low, high = 0, len(chain.segment)
    while high - low > 1:
        middle = (low + high) >> 1
        if chain.segment[middle, 0] <= x:
            low = middle
        else:
            high = middle
    return low


@kernel
def collision_distance(prism, scattering, x, z, dx, dz, reach, rng):
    """Return how far a ray inside the film flies until the resin scatters it, or infinity.

    The ray starts at (x, z) [mm] and meets the film's surface after `reach` [mm].
    """
    low, chain = prism.low, prism.chain
    flown = 0.0
    if dz > 0.0 and z < low:
        flown = (low - z) / dz
    elif dz <= 0.0:
        if z <= low:
            return math.inf
        if dz < 0.0:
            reach = min(reach, (low - z) / dz)
    while True:
        flown -= math.log(1.0 - uniform(rng)) / scattering
        if not flown < reach:
            return math.inf
        at = x + flown * dx
        at -= math.floor(at / prism.width) * prism.width
        k = segment_over(chain, at)
        line = chain.segment[k]
        x0, z0, x1, z1 = line[0], line[1], line[2], line[3]
        if z + flown * dz > z0 + (at - x0) / (x1 - x0) * (z1 - z0):
            return flown


@kernel
def is_resin(prism, x, z, thinnest):
    """Return whether more than `thinnest` [mm] of resin lies under a place (x, z) of the film."""
    x -= math.floor(x / prism.width) * prism.width
    line = prism.chain.segment[segment_over(prism.chain, x)]
    return z - (line[1] + line[4] * (x - line[0])) > thinnest


@kernel
def segment_amid(tile, x, y, z, dx, dy, dz, under):
    """Return what `next_facet` does over a chain, for a ray that starts anywhere.

    The ray starts below the chain (`under`), or else above it.
    """
    chain, width = tile.chain, tile.width
    count = len(chain.segment)
    side = 1.0 if under else -1.0
    # Free flight to the zone of the top, for a ray from beyond it.
    free = 0.0
    level = tile.low if under else tile.high
    if (z - level) * side < 0.0:
        if dz * side <= 0.0:
            return (-1 if dz * side < 0.0 else -2), x, y, z, 0.0, 0.0, 1.0, 0.0, 0.0
        free = (level - z) / dz
    entry = x + free * dx
    shift = math.floor(entry / width) * width
    x -= shift
    k = segment_over(chain, min(max(entry - shift, 0.0), width))
    right = dx > 0.0
    sign = 1.0 if right else -1.0
    speed = abs(dx)
    for _ in range(64 * count + 64):
        v = 2 if right else 0
        ahead = (chain.segment[k, v] - x) * sign
        if speed == 0.0 and dz * side <= 0.0:
            break
        if ((chain.segment[k, v + 1] - z) * speed - ahead * dz) * side <= 0.0:
            line = chain.segment[k]
            x0, z0, x1, z1, nz = line[0], line[1], line[2], line[3], line[5]
            nx = -line[4] * nz
            approach = dx * nx + dz * nz
            distance = 0.0
            if approach != 0.0:
                distance = max(0.0, ((x0 - x) * nx + (z0 - z) * nz) / approach)
            hit = min(max(x + distance * dx, x0), x1)
            hit_z = z0 + (z1 - z0) * ((hit - x0) / (x1 - x0))
            return k, hit, y + distance * dy, hit_z, nx, 0.0, nz, shift, 0.0
        if dz * side < 0.0 and (ahead * dz - (level - z) * speed) * side < 0.0:
            break
        if right:
            k += 1
            if k == count:
                k, x, shift = 0, x - width, shift + width
        else:
            k -= 1
            if k < 0:
                k, x, shift = count - 1, x + width, shift - width
    else:
        return -2, x, y, z, 0.0, 0.0, 1.0, shift, 0.0
    return -1, x, y, z, 0.0, 0.0, 1.0, shift, 0.0
