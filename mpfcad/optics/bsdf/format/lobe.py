"""Values measured around the direct or mirrored ray, brought into bins around the normal.

Scatter angles: radial from the direct or mirrored ray, azimuth 0 from it towards the normal.
Between measured incidences the lobe moves with its ray.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis

_AGREEMENT = 0.2
#: The largest share of light that may lie where nothing was measured.
_MOST_BEYOND = 0.5


@dataclass(frozen=True, eq=False)
class LobeData:
    """One file: angles [rad], tis (s, i; 0: not stated), value (s, i, a, r) [1/sr], notes."""

    path: Path
    way: int
    side: int
    rotation: NDArray[np.float64]
    incidence: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    radial: NDArray[np.float64]
    tis: NDArray[np.float64]
    value: NDArray[np.float64]
    note: tuple[str, ...] = ()


def settled(data: LobeData) -> LobeData:
    """Return the data with a TIS everywhere and values up to 180° from the ray, with notes.

    Values end at the last radial angle. Beyond it, where light can still leave, they go on as they
    are at the edge, unless the TIS says that nothing does. A TIS of 0 with values is not stated:
    the light is what the values integrate to.

    Raises
    ------
    InputError
        when a stated TIS is not that of the values within 20 %, or most light would be beyond.
    """
    ends = data.radial[-1] < np.pi - 1e-9
    if ends:
        edge = data.value[..., -1:]
        radial = np.concatenate([data.radial, [data.radial[-1] + 1e-6, np.pi]])
        data = replace(data, radial=radial, value=np.concatenate([data.value, edge, edge], -1))
    tis, value = data.tis.copy(), data.value.copy()
    furthest, place, unstated = 0.0, 0.0, False
    most = np.maximum(tis, 0.02) * _AGREEMENT
    for s, i in np.ndindex(tis.shape):
        inside, beyond = _integrals(data, s, i, ends)
        stated, total = tis[s, i] > 0, inside + beyond
        cut = beyond > 1e-3 * total and abs(inside - tis[s, i]) < abs(total - tis[s, i])
        if stated and cut:
            value[s, i, :, -2:], beyond, total = 0.0, 0.0, inside
        theta = float(np.degrees(data.incidence[i]))
        if stated and abs(total - tis[s, i]) > most[s, i]:
            raise InputError(
                f"{data.path}: incidence {theta:g} deg: the values "
                f"integrate to {total:.4f}: expected within 20 % of the TIS {tis[s, i]:g}"
            )
        if not stated:
            tis[s, i], unstated = total, unstated or total > 0
        share = beyond / total if total > 0 else 0.0
        if not stated and share > _MOST_BEYOND:
            raise InputError(
                f"{data.path}: ScatterRadial: ends at {np.degrees(data.radial[-3]):g} deg, and "
                f"at incidence {theta:g} deg {100 * share:.0f} % of the light would be beyond: "
                "expected radial angles to the horizon, or a TIS"
            )
        if share > furthest:
            furthest, place = share, theta
    notes = ["TIS 0 is not stated: the values' integral taken"] if unstated else []
    if furthest > 1e-6:
        notes.append(
            f"values beyond {np.degrees(data.radial[-3]):g} deg from the ray taken as at that "
            "edge: "
            f"{100 * furthest:.2g} % of the light at incidence {place:g} deg"
        )
    return replace(data, tis=tis, value=value, note=(*data.note, *notes))


def _integrals(data: LobeData, s: int, i: int, ends: bool) -> tuple[float, float]:
    """Return the light [share of 1] within the last measured radial angle, and beyond it."""
    radial, azimuth = _refined(data.radial, 0.5), _refined(data.azimuth, 5.0)
    a, r = np.meshgrid(azimuth, radial, indexing="ij")
    cosine = leaving_direction(data.incidence[i], a, r)[2]
    value = _interpolated(data, data.value[s, i], a.ravel(), r.ravel()).reshape(a.shape)
    ring = np.trapezoid(value * np.maximum(0, cosine) * np.sin(r), azimuth, axis=0)
    whole = float(np.trapezoid(ring, radial))
    if not ends:
        return whole, 0.0
    inside = radial <= data.radial[-3]
    part = float(np.trapezoid(ring[inside], radial[inside]))
    return part, whole - part


def _refined(angle: NDArray[np.float64], step_deg: float) -> NDArray[np.float64]:
    """Return the angles with steps of at most `step_deg` between them."""
    parts = [
        np.linspace(a, b, max(1, int(np.ceil(np.degrees(b - a) / step_deg))), endpoint=False)
        for a, b in pairwise(angle)
    ]
    return np.append(np.concatenate(parts), angle[-1])


def _frame(incidence: float) -> NDArray[np.float64]:
    """Return the axes (3, 3) of scatter angles: to the normal, counterclockwise, direct ray."""
    c, s = np.cos(incidence), np.sin(incidence)
    return np.array([[-c, 0.0, s], [0.0, -1.0, 0.0], [s, 0.0, c]])


def leaving_direction(incidence: float, azimuth: NDArray, radial: NDArray) -> NDArray:
    """Return the directions (3, …) at scatter angles, for incidence in azimuth 0, kz positive."""
    axes = _frame(incidence)
    local = np.stack(
        [np.sin(radial) * np.cos(azimuth), np.sin(radial) * np.sin(azimuth), np.cos(radial)]
    )
    return np.einsum("ij,i...->j...", axes, local)


def _interpolated(data: LobeData, grid: NDArray, azimuth: NDArray, radial: NDArray) -> NDArray:
    """Return values between the grid's points (a, r)."""
    a = np.clip(np.searchsorted(data.azimuth, azimuth, "right") - 1, 0, len(data.azimuth) - 2)
    r = np.clip(np.searchsorted(data.radial, radial, "right") - 1, 0, len(data.radial) - 2)
    p = (azimuth - data.azimuth[a]) / (data.azimuth[a + 1] - data.azimuth[a])
    q = (radial - data.radial[r]) / (data.radial[r + 1] - data.radial[r])
    inside = grid[a, r] * (1 - q) + grid[a, r + 1] * q
    return inside * (1 - p) + (grid[a + 1, r] * (1 - q) + grid[a + 1, r + 1] * q) * p


def lobe_matrix(data: LobeData, basis: AngleBasis, isotropic: bool) -> NDArray[np.float64]:
    """Return the mean BSDF (i, o) in the bins; between incidences the lobe moves with its ray."""
    finest = np.degrees(np.diff(data.radial[data.radial < np.pi - 1e-9][:-1]).min())
    places = max(4, min(12, int(np.ceil(2.5 / finest))))
    points = _points(basis, places)
    polar = basis.polar if isotropic else basis.polar[basis.ring]
    turned = np.zeros(len(polar)) if isotropic else basis.azimuth
    matrix = np.empty((len(polar), basis.count))
    for n, (theta, phi) in enumerate(zip(polar, turned, strict=True)):
        grid, tis = _mixed(data, theta, phi)
        c, s = np.cos(phi), np.sin(phi)
        kx, ky = points[0] * c + points[1] * s, points[1] * c - points[0] * s
        local = _frame(theta) @ np.stack([kx, ky, np.sqrt(1 - kx**2 - ky**2)])
        radial = np.arccos(np.clip(local[2], -1, 1))
        azimuth = np.arctan2(local[1], local[0]) % (2 * np.pi)
        value = _interpolated(data, grid, azimuth, radial).reshape(basis.count, -1).mean(axis=1)
        total = value @ basis.projected
        if tis > 0 and total == 0:
            raise InputError(
                f"{data.path}: incidence {np.degrees(theta):.4g} deg: TIS {tis:g} but no values"
            )
        matrix[n] = value * (tis / total) if total > 0 else 0.0
    return matrix


def _points(basis: AngleBasis, places: int) -> NDArray[np.float64]:
    """Return (kx, ky) of places² points in each bin, even in projected solid angle: (2, n·p²)."""
    part = (np.arange(places) + 0.5) / places
    low, high = basis.sin2_edge[:-1][basis.ring], basis.sin2_edge[1:][basis.ring]
    sine = np.sqrt(low[:, None] + (high - low)[:, None] * part)
    turn = 2 * np.pi / basis.azimuths[basis.ring]
    angle = basis.azimuth[:, None] + turn[:, None] * (part - 0.5)
    kx = sine[:, :, None] * np.cos(angle)[:, None, :]
    ky = sine[:, :, None] * np.sin(angle)[:, None, :]
    return np.stack([kx.ravel(), ky.ravel()])


def _mixed(data: LobeData, theta: float, phi: float) -> tuple[NDArray, float]:
    """Return (values (a, r), tis) at an incidence, linear between the measured ones."""
    place = np.interp(theta, data.incidence, np.arange(len(data.incidence)))
    i = min(int(place), max(0, len(data.incidence) - 2))
    j = min(i + 1, len(data.incidence) - 1)
    p = place - i
    turns = len(data.rotation)
    whole = np.concatenate(
        [[data.rotation[-1] - 2 * np.pi], data.rotation, [data.rotation[0] + 2 * np.pi]]
    )
    after = int(np.clip(np.searchsorted(whole, phi % (2 * np.pi), "right"), 1, turns + 1))
    q = (phi % (2 * np.pi) - whole[after - 1]) / (whole[after] - whole[after - 1])
    s = (after - 2) % turns
    shares = ((s, i, (1 - q) * (1 - p)), (s, j, (1 - q) * p),
              ((s + 1) % turns, i, q * (1 - p)), ((s + 1) % turns, j, q * p))  # fmt: skip
    grid = sum(w * data.value[a, b] for a, b, w in shares)
    return grid, float(sum(w * data.tis[a, b] for a, b, w in shares))
