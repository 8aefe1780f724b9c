"""The same scattering in other bins; energy and reciprocity are kept."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.table import BsdfTable


def expand_isotropic(table: BsdfTable) -> BsdfTable:
    """Return an isotropic table with an incidence bin for every azimuth too; others as they are."""
    if not table.isotropic:
        return table
    rings, count = len(table.basis.azimuths), int(table.basis.azimuths[0])
    ring = table.value.reshape(2, 2, rings, rings, count)
    turned = [np.roll(ring, m, axis=-1) for m in range(count)]
    value = np.stack(turned, axis=3).reshape(2, 2, rings * count, rings * count)
    return replace(table, isotropic=False, value=value)


def rebin(table: BsdfTable, basis: AngleBasis) -> BsdfTable:
    """Return the table's mean over the bins of another basis; isotropic tables are expanded."""
    table = expand_isotropic(table)
    if table.basis.is_same(basis):
        return replace(table, basis=basis)
    share = overlap(basis, table.basis) / basis.projected[:, None]
    return replace(table, basis=basis, value=share @ table.value @ share.T)


def overlap(first: AngleBasis, second: AngleBasis) -> NDArray[np.float64]:
    """Return the projected solid angle that two bases' bins share, (n1, n2) float64 [sr]."""
    low = np.maximum(first.sin2_edge[:-1, None], second.sin2_edge[None, :-1])
    high = np.minimum(first.sin2_edge[1:, None], second.sin2_edge[None, 1:])
    rings = np.maximum(0.0, high - low)
    n1, n2 = first.azimuths[first.ring], second.azimuths[second.ring]
    apart = first.azimuth[:, None] - second.azimuth[None, :]
    apart = np.abs((apart + np.pi) % (2 * np.pi) - np.pi)
    half1, half2 = np.pi / n1[:, None], np.pi / n2[None, :]
    arc = np.minimum(half1 + half2 - apart, 2 * np.minimum(half1, half2))
    # A bin wider than half a turn meets the other on both sides.
    around = np.minimum(half1 + half2 - (2 * np.pi - apart), 2 * np.minimum(half1, half2))
    arc = np.minimum(np.maximum(0.0, arc) + np.maximum(0.0, around), 2 * np.minimum(half1, half2))
    return rings[np.ix_(first.ring, second.ring)] * arc / 2


def bin_shares(
    basis: AngleBasis, kx: ArrayLike, ky: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the bins that count at directions (n,), linear between middles, and their shares.

    Both (n, 4): the h of `bsdf` at `blend` 1, two rings by two azimuths.
    """
    kx, ky = np.atleast_1d(np.asarray(kx, float)), np.atleast_1d(np.asarray(ky, float))
    sin2, edge = kx**2 + ky**2, basis.sin2_edge
    last = len(basis.azimuths) - 1
    own = np.clip(np.searchsorted(edge, sin2, "right") - 1, 0, last)
    width = np.diff(edge)
    fade = np.concatenate([[0.0], np.minimum(width[:-1], width[1:]) / 2, [0.0]])
    bins, shares = [], []
    lower = _faded_share(sin2 - edge[own], fade[own])
    upper = _faded_share(edge[own + 1] - sin2, fade[own + 1])
    other = np.where(lower < 1, own - 1, np.where(upper < 1, own + 1, own))
    mine = np.minimum(lower, upper)
    for ring, share in ((own, mine), (other, 1 - mine)):
        n = basis.azimuths[ring]
        place = np.arctan2(ky, kx) / (2 * np.pi) * n
        m = np.floor(place).astype(np.int64)
        part = place - m
        for step, weight in ((0, 1 - part), (1, part)):
            bins.append(basis.first[ring] + (m + step) % n)
            shares.append(share * weight)
    return np.stack(bins, axis=-1), np.stack(shares, axis=-1)


def _faded_share(depth: NDArray[np.float64], fade: NDArray[np.float64]) -> NDArray[np.float64]:
    inside = (fade > 0) & (depth < fade)
    return np.where(inside, 0.5 + 0.5 * depth / np.where(fade > 0, fade, 1.0), 1.0)


def bsdf_at(
    table: BsdfTable, way: int, side: int, incident: ArrayLike, leaving: ArrayLike
) -> NDArray[np.float64]:
    """Return the BSDF (n,) [1/sr] from one direction (2,) to others (n, 2), all (kx, ky)."""
    into, out_of = np.asarray(incident, float), np.asarray(leaving, float)
    rows = table.value[way, side]
    if table.isotropic:
        azimuth = np.arctan2(into[1], into[0])
        c, s = np.cos(azimuth), np.sin(azimuth)
        out_of = out_of @ np.array([[c, -s], [s, c]])
        rings = AngleBasis("", table.basis.edge, np.ones_like(table.basis.azimuths))
        bins, shares = bin_shares(rings, *into)
    else:
        bins, shares = bin_shares(table.basis, *into)
    row = shares[0] @ rows[bins[0]]
    out, weight = bin_shares(table.basis, out_of[:, 0], out_of[:, 1])
    return (row[out] * weight).sum(axis=-1)
