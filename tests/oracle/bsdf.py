"""The oracle's thin element with a table: the definition of `bsdf`, searched through plainly."""

import math
from collections.abc import Callable
from itertools import accumulate

import numpy as np

from mpfcad.optics.bsdf.table import BsdfTable

Vector = tuple[float, float, float]


def place_in_faded(u: float, low: float, high: float, fade_low: float, fade_high: float) -> float:
    """Return the place at share u of a box with faded edges: a fade holds what its step would."""
    place = low + (high - low) * u
    for edge, fade, inward in ((low, fade_low, 1), (high, fade_high, -1)):
        depth = inward * (place - edge)
        if depth < fade:
            return edge + inward * (2 * math.sqrt(depth * fade) - fade)
    return place


def fade_width(edge: list[float], e: int, blend: float) -> float:
    """Return the half width of the fade at edge e."""
    if not 0 < e < len(edge) - 1:
        return 0.0
    return blend / 2 * min(edge[e] - edge[e - 1], edge[e + 1] - edge[e])


def neighbour_shares(edge: list[float], blend: float, sin2: float) -> dict[int, float]:
    """Return how much each ring counts at a squared sine, by the definition of the fades."""
    share = {}
    for r in range(len(edge) - 1):
        h = 1.0
        for e, outward in ((r, -1), (r + 1, 1)):
            past = outward * (sin2 - edge[e])
            fade = fade_width(edge, e, blend)
            if fade:
                h *= min(1.0, max(0.0, 0.5 - past / (2 * fade)))
            elif 0 < e < len(edge) - 1 and (past > 0 or (past == 0 and outward > 0)):
                h = 0.0
        if h:
            share[r] = h
    return share


def scatter(
    table: BsdfTable, blend: float, d: Vector, rng: Callable[[], float]
) -> tuple[bool, Vector, float]:
    """Return (transmitted, direction, share kept) of a ray at a thin element with a table."""
    basis = table.basis
    edge = [math.sin(e) ** 2 for e in basis.edge]
    share = neighbour_shares(edge, blend, d[0] ** 2 + d[1] ** 2)
    own = max(share, key=share.get)
    other = next((r for r in share if r != own), own)
    i = other if rng() < 1 - share[own] else own
    azimuth, u = math.atan2(d[1], d[0]), rng()
    if not table.isotropic:
        n = int(basis.azimuths[i])
        place = azimuth / (2 * math.pi) * n + blend * (u - 0.5)
        i, azimuth = int(basis.first[i]) + math.floor(place + 0.5) % n, 0.0
    side = 0 if d[2] > 0 else 1
    sums = list(accumulate(np.concatenate(table.chance[:, side, i]).tolist()))
    wanted = rng() * sums[-1]
    high = next((k for k, s in enumerate(sums) if s > wanted), len(sums) - 1)
    way, o = divmod(high, basis.count)
    r = int(basis.ring[o])
    fades = fade_width(edge, r, blend), fade_width(edge, r + 1, blend)
    sin2 = min(place_in_faded(rng(), edge[r], edge[r + 1], *fades), 1 - 1e-12)
    m = o - int(basis.first[r])
    turn = place_in_faded(rng(), m - 0.5, m + 0.5, blend / 2, blend / 2)
    azimuth += 2 * math.pi * turn / int(basis.azimuths[r])
    kx, ky = math.sqrt(sin2) * math.cos(azimuth), math.sqrt(sin2) * math.sin(azimuth)
    kz = math.copysign(math.sqrt(1 - kx * kx - ky * ky), d[2])
    return way == 0, (kx, ky, kz if way == 0 else -kz), sums[-1]
