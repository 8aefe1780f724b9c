"""Scattering by a table: drawn from it exactly, with energy and reciprocity kept.

The BSDF between two directions is Σ h_i(k) f_io h_o(k'): each bin's h is 1 inside, 0 outside, and
at its edges fades linearly into its neighbours', over `blend` times the half width of the narrower
of the two. Fades are symmetric about the edge in sin²θ and azimuth, where projected solid angle is
even: all h together are 1 everywhere, and each has its bin's projected solid angle. Hence for any
`blend` the light leaving is a mean of the table's energies, a reciprocal table scatters
reciprocally, and an even table makes even light. 0 is a table of steps, 1 goes linearly from middle
to middle.

To draw: the incidence bin by chance with h_i at the ray, the outgoing bin by the inverse of the
row's cumulative sum, the direction in it from h_o.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.bsdf.table import BsdfTable

_TWO_PI = 2.0 * math.pi
_LARGEST_SIN2 = 1.0 - 1e-12


class BsdfArrays(NamedTuple):
    """All tables of a scene, one behind the other.

    Attributes
    ----------
    head
        (t, 5) int64 a table: first edge, first ring, rings, incidence bins a side,
        outgoing bins
    isotropic, blend
        (t,) bool; (t,) float64, 0…1
    edge, fade
        (e,) float64, sin²θ of the rings' edges; half width of the fade there
    azimuths, first
        (r,) int64, bins of a ring; its first bin
    ring_of
        (b,) int64, ring of each outgoing bin, from `bins[t]` on
    bins, start
        (t,) int64, where a table's `ring_of` and `cumulative` begin
    cumulative
        (c,) float64, running sums of each row's chances: rows by side and incidence bin,
        transmitted bins first
    """

    head: NDArray[np.int64]
    isotropic: NDArray[np.bool_]
    blend: NDArray[np.float64]
    edge: NDArray[np.float64]
    fade: NDArray[np.float64]
    azimuths: NDArray[np.int64]
    first: NDArray[np.int64]
    ring_of: NDArray[np.int64]
    bins: NDArray[np.int64]
    start: NDArray[np.int64]
    cumulative: NDArray[np.float64]


def build_bsdf(tables: list[BsdfTable], blends: list[float]) -> BsdfArrays:
    """Return tables, each with its `blend`, as the kernels read them."""
    parts: dict[str, list] = {name: [] for name in BsdfArrays._fields}
    edge = ring = bins = cell = 0
    for table, blend in zip(tables, blends, strict=True):
        basis = table.basis
        rings, count = len(basis.azimuths), basis.count
        sin2 = basis.sin2_edge
        fade = np.zeros(rings + 1)
        fade[1:-1] = blend / 2 * np.minimum(np.diff(sin2)[:-1], np.diff(sin2)[1:])
        rows = table.chance.transpose(1, 2, 0, 3).reshape(-1, 2 * count)
        parts["head"].append([edge, ring, rings, table.value.shape[2], count])
        parts["isotropic"].append(table.isotropic)
        parts["blend"].append(blend)
        parts["edge"].append(sin2)
        parts["fade"].append(fade)
        parts["azimuths"].append(basis.azimuths)
        parts["first"].append(basis.first[:-1])
        parts["ring_of"].append(basis.ring)
        parts["bins"].append(bins)
        parts["start"].append(cell)
        parts["cumulative"].append(np.cumsum(rows, axis=1).ravel())
        edge, ring, bins = edge + rings + 1, ring + rings, bins + count
        cell += rows.size
    return BsdfArrays(
        np.array(parts["head"], np.int64).reshape(-1, 5),
        np.array(parts["isotropic"], np.bool_),
        np.array(parts["blend"], np.float64),
        _joined(parts["edge"], np.float64),
        _joined(parts["fade"], np.float64),
        _joined(parts["azimuths"], np.int64),
        _joined(parts["first"], np.int64),
        _joined(parts["ring_of"], np.int64),
        np.array(parts["bins"], np.int64),
        np.array(parts["start"], np.int64),
        _joined(parts["cumulative"], np.float64),
    )


def _joined(arrays: list[NDArray], kind: type) -> NDArray:
    return np.concatenate([np.asarray(a, kind) for a in arrays]) if arrays else np.zeros(0, kind)


@kernel
def _faded(u, low, high, fade_low, fade_high):
    """Return the place drawn by u in [0, 1) between two faded edges.

    Uniform inside; within a fade the density rises as (place - low + fade)/(2·fade), which holds as
    much as the step that it stands for, so u maps zone to zone.
    """
    place = low + (high - low) * u
    if place < low + fade_low:
        return low - fade_low + 2.0 * fade_low * math.sqrt((place - low) / fade_low)
    if place > high - fade_high:
        return high + fade_high - 2.0 * fade_high * math.sqrt((high - place) / fade_high)
    return place


@kernel
def _incidence_ring(tables, edge, rings, sin2, u):
    """Return the ring chosen by u for a ray of squared sine `sin2`."""
    low, high = 0, rings
    while high - low > 1:
        middle = (low + high) // 2
        if sin2 >= tables.edge[edge + middle]:
            low = middle
        else:
            high = middle
    above = sin2 - tables.edge[edge + low]
    fade = tables.fade[edge + low]
    if fade > 0.0 and above < fade:
        return low - 1 if u < 0.5 - 0.5 * above / fade else low
    under = tables.edge[edge + low + 1] - sin2
    fade = tables.fade[edge + low + 1]
    if fade > 0.0 and under < fade:
        return low + 1 if u < 0.5 - 0.5 * under / fade else low
    return low


@kernel
def bsdf_scatter(tables, t, side, dx, dy, rng):
    """Scatter a ray by table t: (transmitted, kx, ky, survival).

    `side` is 0 for a ray from below, 1 from above; `survival` the share of its weight that the
    table leaves it (0 where all is absorbed).
    """
    edge, first_ring, rings = tables.head[t, 0], tables.head[t, 1], tables.head[t, 2]
    incidences, count = tables.head[t, 3], tables.head[t, 4]
    blend = tables.blend[t]
    i = _incidence_ring(tables, edge, rings, dx * dx + dy * dy, uniform(rng))
    azimuth = math.atan2(dy, dx)
    u = uniform(rng)
    if not tables.isotropic[t]:
        n = tables.azimuths[first_ring + i]
        m = math.floor(azimuth / _TWO_PI * n + 0.5 + blend * (u - 0.5))
        i = tables.first[first_ring + i] + int(m) % n
        azimuth = 0.0
    row = tables.start[t] + (side * incidences + i) * 2 * count
    survival = tables.cumulative[row + 2 * count - 1]
    wanted = uniform(rng) * survival
    low, high = -1, 2 * count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if tables.cumulative[row + middle] > wanted:
            high = middle
        else:
            low = middle
    transmitted = high < count
    o = high if transmitted else high - count
    ring = tables.ring_of[tables.bins[t] + o]
    n = tables.azimuths[first_ring + ring]
    k = edge + ring
    sin2 = _faded(
        uniform(rng), tables.edge[k], tables.edge[k + 1], tables.fade[k], tables.fade[k + 1]
    )
    m = o - tables.first[first_ring + ring]
    turn = _faded(uniform(rng), m - 0.5, m + 0.5, 0.5 * blend, 0.5 * blend)
    azimuth += _TWO_PI * turn / n
    sine = math.sqrt(min(sin2, _LARGEST_SIN2))
    return transmitted, sine * math.cos(azimuth), sine * math.sin(azimuth), survival


@kernel
def bsdf_passage(tables, t, dx, dy, dz, rng):
    """Scatter a ray at a thin element: (passed, dx, dy, dz, survival)."""
    passed, kx, ky, survival = bsdf_scatter(tables, t, 0 if dz > 0.0 else 1, dx, dy, rng)
    kz = math.copysign(math.sqrt(1.0 - kx * kx - ky * ky), dz)
    return passed, kx, ky, kz if passed else -kz, survival
