"""The BSDF table of a film mesh, by tracing rays through it from every incidence bin."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics.base.kernel import allocating_entry
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE, start_path, uniform
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.element import Film
from mpfcad.optics.passage import pass_element
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import FilmMesh

_STREAM = 12
_MOST_LOST = 1e-6


@dataclass(frozen=True, eq=False)
class FilmBsdf:
    """A film's table and how sure it is.

    Attributes
    ----------
    table
        reciprocal, nothing lost
    rays
        traced for each incidence bin and side
    traced
        the table as traced, before it was made reciprocal
    """

    table: BsdfTable
    rays: int
    traced: BsdfTable

    @property
    def energy_error(self) -> NDArray[np.float64]:
        """Standard error of the traced shares transmitted, (2, i) float64: √(T(1-T)/rays)."""
        share = self.traced.energy[0]
        return np.sqrt(share * (1 - share) / self.rays)

    @property
    def noise(self) -> float:
        """Expected share of an incidence's light in wrong bins, before reciprocity halves it.

        Mean of Σ|p̂ - p|/2 with E|p̂ - p| = √(2p(1-p)/(π·rays)), over Lambertian incidence.
        """
        p = self.traced.chance
        away = np.sqrt(2 * p * (1 - p) / (np.pi * self.rays)).sum(axis=(0, 3)) / 2
        return float((away @ self.traced.incidence_projected).mean() / np.pi)


def trace_film_bsdf(
    mesh: FilmMesh,
    index: float,
    basis: AngleBasis,
    *,
    name: str = "film",
    rays: int = 20_000,
    seed: int = 1,
    threads: int = 1,
    after_bin: Callable[[int, int], None] | None = None,
) -> FilmBsdf:
    """Return the table of a film of refractive index `index` in air, averaged over its tile.

    From each incidence bin, from below and above, `rays` rays start evenly over the tile and the
    bin's projected solid angle. The same seed gives the same bits at any number of threads.
    `after_bin(done, all)` is called as each bin comes in.

    Raises
    ------
    TraceError
        when more than 1e-6 of the rays are lost.
    """
    scene = build_scene([Film(mesh, index)])
    width, length, _ = mesh.size
    count = basis.count
    number = np.zeros((2, count, 2 * count + 1), np.int64)
    bins = (basis.sin2_edge, basis.azimuths, basis.first, basis.ring)

    def one(start: tuple[int, int]) -> None:
        side, i = start
        rng, flow = np.zeros(RNG_SIZE, np.uint64), np.zeros(len(FLOWS) + 1)
        _trace_bin(
            scene, (width, length), bins, side, i, rays, np.uint64(seed), rng, flow, number[side, i]
        )

    def come_in(done: int, _: None) -> int:
        if after_bin:
            after_bin(done + 1, 2 * count)
        return done + 1

    each = [(side, i) for side in (0, 1) for i in range(count)]
    add_in_order(one, each, come_in, 0, threads=threads)
    lost = number[:, :, -1].sum() / number.sum()
    if lost > _MOST_LOST:
        raise TraceError(f"{name}: {lost:.2e} of the rays were lost; expected {_MOST_LOST:g}")
    kept = number[:, :, :-1].reshape(2, count, 2, count).transpose(2, 0, 1, 3)
    chance = kept / kept.sum(axis=(0, 3))[None, :, :, None]
    traced = BsdfTable(name, basis, False, chance / basis.projected)
    return FilmBsdf(traced.made_reciprocal(), rays, traced)


@allocating_entry
def _trace_bin(scene, size, bins, side, i, rays, seed, rng, flow, number):
    """Trace rays from incidence bin i; number (2n+1,) gets how many left where, lost ones last."""
    edge, azimuths, first, ring_of = bins
    ring = ring_of[i]
    count = first[-1]
    up = side == 0
    for ray in range(rays):
        start_path(rng, seed, uint64(_STREAM), uint64((2 * i + side) * rays + ray))
        x, y = uniform(rng) * size[0], uniform(rng) * size[1]
        sin2 = edge[ring] + (edge[ring + 1] - edge[ring]) * uniform(rng)
        place = i - first[ring] - 0.5 + uniform(rng)
        angle = 2.0 * math.pi * place / azimuths[ring]
        kx, ky = math.sqrt(sin2) * math.cos(angle), math.sqrt(sin2) * math.sin(angle)
        kz = math.sqrt(max(1e-12, 1.0 - sin2))
        way, x, y, dx, dy, _, _, _ = pass_element(
            scene,
            0,
            up,
            x,
            y,
            0.0,
            kx,
            ky,
            kz if up else -kz,
            NO_LAMP,
            1.0,
            flow,
            None,
            None,
            None,
            rng,
        )
        if way == 0:
            number[2 * count] += 1
            continue
        k = 0
        while k < len(azimuths) - 1 and dx * dx + dy * dy >= edge[k + 1]:
            k += 1
        m = math.floor(math.atan2(dy, dx) / (2.0 * math.pi) * azimuths[k] + 0.5)
        o = first[k] + int(m) % azimuths[k]
        number[o if (way > 0) == up else count + o] += 1
