"""Values measured around the direct or mirrored ray, brought into bins around the normal.

Scatter angles: radial from the direct or mirrored ray, azimuth 0 from it towards the normal.
Between measured incidences the lobe moves with its ray.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis

_AGREEMENT = 0.2


@dataclass(frozen=True, eq=False)
class LobeData:
    """One file: angles [rad], tis (s, i), value (s, i, a, r) [1/sr]."""

    path: Path
    way: int
    side: int
    rotation: NDArray[np.float64]
    incidence: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    radial: NDArray[np.float64]
    tis: NDArray[np.float64]
    value: NDArray[np.float64]


def check_total(data: LobeData) -> None:
    """Raise unless the values integrate to about the TIS at each incidence."""
    radial, azimuth = _refined(data.radial, 0.5), _refined(data.azimuth, 5.0)
    a, r = np.meshgrid(azimuth, radial, indexing="ij")
    for s, i in np.ndindex(data.tis.shape):
        cosine = leaving_direction(data.incidence[i], a, r)[2]
        value = _interpolated(data, data.value[s, i], a.ravel(), r.ravel()).reshape(a.shape)
        integrand = value * np.maximum(0, cosine) * np.sin(r)
        integral = np.trapezoid(np.trapezoid(integrand, radial, axis=1), azimuth)
        tis = data.tis[s, i]
        if abs(integral - tis) > _AGREEMENT * max(tis, 0.02):
            raise InputError(
                f"{data.path}: incidence {np.degrees(data.incidence[i]):g} deg: the values "
                f"integrate to {integral:.4f}: must be within 20 % of the TIS {tis:g}"
            )


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
    """Return values between the grid's points (a, r), 0 beyond its radial angles."""
    a = np.clip(np.searchsorted(data.azimuth, azimuth, "right") - 1, 0, len(data.azimuth) - 2)
    r = np.clip(np.searchsorted(data.radial, radial, "right") - 1, 0, len(data.radial) - 2)
    p = (azimuth - data.azimuth[a]) / (data.azimuth[a + 1] - data.azimuth[a])
    q = (radial - data.radial[r]) / (data.radial[r + 1] - data.radial[r])
    inside = grid[a, r] * (1 - q) + grid[a, r + 1] * q
    value = inside * (1 - p) + (grid[a + 1, r] * (1 - q) + grid[a + 1, r + 1] * q) * p
    return np.where(radial > data.radial[-1] + 1e-9, 0.0, value)


def lobe_matrix(data: LobeData, basis: AngleBasis, isotropic: bool) -> NDArray[np.float64]:
    """Return the mean BSDF (i, o) in the bins; between incidences the lobe moves with its ray."""
    places = max(4, min(12, int(np.ceil(2.5 / np.degrees(np.diff(data.radial).min())))))
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
    turn = phi / (2 * np.pi) * turns % turns
    s, q = int(turn) % turns, turn % 1
    shares = ((s, i, (1 - q) * (1 - p)), (s, j, (1 - q) * p),
              ((s + 1) % turns, i, q * (1 - p)), ((s + 1) % turns, j, q * p))  # fmt: skip
    grid = sum(w * data.value[a, b] for a, b, w in shares)
    return grid, float(sum(w * data.tis[a, b] for a, b, w in shares))
