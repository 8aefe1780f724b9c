"""Sample rotations of Zemax files: where the light comes from, and sets completed by symmetry.

The vendor (R. Rykowski, "Zemax Tabular BSDF data file format", OpticStudio knowledge base) defines
`SampleRotation` as the angle between the normal of the plane of incidence and the sample's +X. At 0
the light travels in the plane of Y and Z, at ρ its azimuth is ρ ± 90°. A plane has two normals, so
the sign is open: where turning the sample by half makes a difference the file, or the user, must
say which is meant.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.format.lobe import LobeData

_ZERO = {"+x": 0.0, "+y": np.pi / 2, "-x": np.pi, "-y": -np.pi / 2}
_SENSE = {"counterclockwise": 1.0, "clockwise": -1.0}
#: Σ|A - A'|/Σ(A + A') up to which two lobes are the same but for noise.
_SAME = 0.05
_WIDEST = np.radians(90) + 1e-6


@dataclass(frozen=True)
class Rotation:
    """How a sample rotation ρ reads: the way of travel has azimuth `zero` + `sense`·ρ [rad]."""

    zero: float
    sense: float


#: As the vendor says it, with the normal that makes the light travel along +y at rotation 0.
VENDOR = Rotation(np.pi / 2, 1.0)


def read_rotation(where: str, text: str) -> Rotation:
    """Return the reading of words such as `+y counterclockwise`.

    Raises
    ------
    InputError
        when they are not of that form.
    """
    words = text.lower().split()
    if len(words) != 2 or words[0] not in _ZERO or words[1] not in _SENSE:
        raise InputError(
            f"{where}: rotation: {text}: expected the way of travel at SampleRotation 0 "
            f"({', '.join(_ZERO)}) and its sense ({' or '.join(_SENSE)}): '+y counterclockwise'"
        )
    return Rotation(_ZERO[words[0]], _SENSE[words[1]])


def completed(data: LobeData) -> LobeData:
    """Return the data of one file with sample rotations all around, 0 … below 2π.

    A set that ends at 90° or 180° is that of a sample with mirror planes, and is mirrored; one of
    even steps that ends a step before 180° repeats after half a turn.

    Raises
    ------
    InputError
        when the set allows no reading, or two, or is not as symmetric as its range says.
    """
    turn, end = data.rotation, data.rotation[-1]
    if len(turn) == 1:
        return data
    step = np.diff(turn).max()
    if abs(end - 2 * np.pi) < 1e-6:
        data = _kept(data, slice(0, -1))
    elif end > np.pi + 1e-6 and 2 * np.pi - end <= _WIDEST:
        pass
    elif abs(end - np.pi) < 1e-6:
        data = _mirrored(data, np.pi, "mirror symmetry")
    elif abs(end - np.pi / 2) < 1e-6:
        data = _mirrored(_mirrored(data, np.pi / 2, "two mirror planes"), np.pi, "")
    elif abs(end + step - np.pi) < 1e-6 and np.ptp(np.diff(turn)) < 1e-6:
        data = _joined(data, turn + np.pi, data.value, data.tis, "a twofold axis")
    else:
        raise InputError(
            f"{data.path}: SampleRotation: {_degrees(turn)}: neither all around nor half or a "
            "quarter of it: expected 0 … 90 or 0 … 180 (mirrored), even steps below 180 (turned "
            "by half), or steps of at most 90 over 360 deg"
        )
    gap = np.diff(np.append(data.rotation, data.rotation[0] + 2 * np.pi))
    if data.rotation[0] > 1e-6 or gap.max() > _WIDEST:
        raise InputError(
            f"{data.path}: SampleRotation: {_degrees(data.rotation)}: expected from 0 in steps of "
            "at most 90 deg"
        )
    return data


def placed(data: LobeData, given: Rotation | None) -> LobeData:
    """Return the data with its rotations as azimuths [rad] of the way of travel, rising from ≥ 0.

    Raises
    ------
    InputError
        when nothing says where the light comes from and turning the sample by half matters.
    """
    if len(data.rotation) == 1:
        return data
    if given is None and _difference(data) > _SAME:
        raise InputError(
            f"{data.path}: SampleRotation: counts from a normal of the plane of incidence, and a "
            "plane has two; turned by half the sheet is another: expected rotation = "
            "'+y counterclockwise' or '-y counterclockwise' (way of travel at 0)"
        )
    chosen = given or VENDOR
    azimuth = (chosen.zero + chosen.sense * data.rotation) % (2 * np.pi)
    azimuth[azimuth > 2 * np.pi - 1e-9] = 0.0
    order = np.argsort(azimuth)
    return replace(data, rotation=azimuth[order], value=data.value[order], tis=data.tis[order])


def _difference(data: LobeData) -> float:
    """Return how much a file changes when the sample is turned by half, 0 … 1."""
    turned = (data.rotation + np.pi) % (2 * np.pi)
    other = np.empty_like(data.value)
    whole = np.append(data.rotation, 2 * np.pi)
    for n, angle in enumerate(turned):
        after = int(np.searchsorted(whole, angle, "right"))
        part = (angle - whole[after - 1]) / (whole[after] - whole[after - 1])
        last = data.value[after % len(data.rotation)]
        other[n] = data.value[after - 1] * (1 - part) + last * part
    weight = np.sin(data.radial)
    total = ((data.value + other) * weight).sum()
    return float((np.abs(data.value - other) * weight).sum() / total) if total > 0 else 0.0


def _mirrored(data: LobeData, end: float, why: str) -> LobeData:
    """Return rotations 0 … `end` continued to below 2·`end` by a mirror plane at each end."""
    for at in (0, len(data.rotation) - 1):
        one = data.value[at]
        other = _mirror(data, one)
        total = (one + other).sum()
        if total > 0 and np.abs(one - other).sum() > 2 * _SAME * total:
            raise InputError(
                f"{data.path}: SampleRotation: ends at {np.degrees(data.rotation[-1]):g} deg, but "
                f"the lobe at {np.degrees(data.rotation[at]):g} deg is not its own mirror image: "
                "expected rotations over 360 deg"
            )
    inner = slice(-2, None, -1) if end < 3 else slice(-2, 0, -1)
    value = np.stack([_mirror(data, one) for one in data.value[inner]])
    turn = 2 * end - data.rotation[inner]
    return _joined(data, turn, value, data.tis[inner], why)


def _mirror(data: LobeData, value: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values (i, a, r) at the mirrored azimuths."""
    place = np.interp(2 * np.pi - data.azimuth, data.azimuth, np.arange(len(data.azimuth)))
    low = np.minimum(place.astype(np.int64), len(data.azimuth) - 2)
    part = (place - low)[:, None]
    return value[:, low] * (1 - part) + value[:, low + 1] * part


def _joined(data: LobeData, turn: NDArray, value: NDArray, tis: NDArray, why: str) -> LobeData:
    note = data.note
    if why:
        note = (*note, f"rotations {_degrees(data.rotation)} completed by {why}")
    return replace(
        data,
        rotation=np.concatenate([data.rotation, turn]),
        value=np.concatenate([data.value, value]),
        tis=np.concatenate([data.tis, tis]),
        note=note,
    )


def _kept(data: LobeData, part: slice) -> LobeData:
    return replace(data, rotation=data.rotation[part], value=data.value[part], tis=data.tis[part])


def _degrees(angle: NDArray[np.float64]) -> str:
    listed = [f"{a:.4g}" for a in np.degrees(angle)]
    return ", ".join(listed if len(listed) < 6 else [*listed[:2], "…", listed[-1]]) + " deg"
