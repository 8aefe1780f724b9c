"""Zemax tabular `.bsdf` files: values around the direct or mirrored ray, one way and side a file.

Radial 0 is the direct or mirrored direction, azimuth 0 points from it to the surface normal and
turns counterclockwise seen against the light leaving. TIS is the share of light that leaves: it
sets the energy, the values the shape. A comment `# side: above` or `# side: below` (taken where
there is none) says where the light comes from, `# rotation: +y counterclockwise` what a sample
rotation means where the vendor leaves it open.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis, even_basis, ring_basis
from mpfcad.optics.bsdf.format.lobe import LobeData, lobe_matrix, settled
from mpfcad.optics.bsdf.format.rotation import completed, placed, read_rotation
from mpfcad.optics.bsdf.format.source import read_text
from mpfcad.optics.bsdf.missing import Matrices
from mpfcad.optics.bsdf.table import REFLECT, SIDES, TRANSMIT, WAYS

ANGLES = ("SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial")
_WORDS = {
    "Source": None,
    "Symmetry": ("planesymmetrical", "asymmetrical", "asymmetrical4d"),
    "SpectralContent": ("monochrome", "xyz"),
    "ScatterType": ("btdf", "brdf"),
}
_RINGS, _AZIMUTHS, _TURNED_RINGS = 36, 72, 18


def read_zemax(
    paths: list[Path], rotation: str | None = None
) -> tuple[AngleBasis, bool, Matrices, tuple[str, ...]]:
    """Return (basis, isotropic, matrices (i, o) [1/sr] by (way, side), notes) of files together.

    `rotation` says what sample rotations mean (`read_rotation`), in place of a comment's word.

    Raises
    ------
    InputError
        when a file breaks the format, its values integrate to something else than its TIS, or two
        files hold the same way and side.
    """
    files = [read_zemax_file(path, rotation) for path in paths]
    isotropic = len(files[0].rotation) == 1
    basis = ring_basis(np.linspace(0, np.pi / 2, _RINGS + 1), _AZIMUTHS)
    if not isotropic:
        basis = even_basis(_TURNED_RINGS)
    found: Matrices = {}
    notes = []
    for data in files:
        if (len(data.rotation) == 1) != isotropic:
            raise InputError(f"{data.path}: SampleRotation: expected one or many in all files")
        if (data.way, data.side) in found:
            raise InputError(
                f"{data.path}: {WAYS[data.way]} from {SIDES[data.side]}: is in another file too; "
                "a line '# side: above' or '# side: below' tells the side"
            )
        data = settled(data)
        found[data.way, data.side] = lobe_matrix(data, basis, isotropic)
        notes += [note for note in data.note if note not in notes]
    first, last = np.degrees(files[0].incidence[[0, -1]])
    notes.append(
        f"incidence measured at {first:g} … {last:g} deg: linear between, the nearest beyond"
    )
    return basis, isotropic, found, tuple(notes)


def read_zemax_file(path: Path, rotation: str | None = None) -> LobeData:
    """Return what one file holds.

    Raises
    ------
    InputError
        naming the line or number that is not as the format says.
    """
    text, notes = read_text(path)
    lines = text.splitlines()
    side = _side(path, lines)
    said = rotation or _comment(lines, "rotation")
    rows = [line.split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    words = {}
    for at, (name, allowed) in enumerate(_WORDS.items()):
        row = rows[at] if at < len(rows) else []
        word = row[1].lower() if len(row) > 1 and row[0].lower() == name.lower() else ""
        if not word or (allowed and word not in allowed):
            raise InputError(
                f"{path}: {name}: {' '.join(row) or 'missing'}: expected {name} and "
                f"{' or '.join(allowed or ('Measured',))}"
            )
        words[name] = word
    angles = [_angles(path, name, rows, 4 + 2 * at) for at, name in enumerate(ANGLES)]
    shape = [len(a) for a in angles]
    tis, value = _data(path, rows[12:], words["SpectralContent"], shape)
    _check_angles(path, angles)
    turn, incidence, azimuth, radial = map(np.radians, angles)
    azimuth, value = _around(path, words["Symmetry"], azimuth, value)
    way = TRANSMIT if words["ScatterType"] == "btdf" else REFLECT
    if words["Symmetry"] == "asymmetrical4d" and len(turn) == 1:
        notes = (*notes, "one sample rotation: taken as isotropic")
    data = LobeData(path, way, side, turn, incidence, azimuth, radial, tis, value, notes)
    return placed(completed(data), read_rotation(str(path), said) if said else None)


def _comment(lines: list[str], key: str) -> str | None:
    """Return what a comment `# key: text` says, or None."""
    for line in lines:
        name, _, text = line.lstrip().removeprefix("#").partition(":")
        if line.lstrip().startswith("#") and name.strip().lower() == key:
            return text.strip()
    return None


def _side(path: Path, lines: list[str]) -> int:
    said = _comment(lines, "side")
    if said is None:
        return 0
    if said not in SIDES:
        raise InputError(f"{path}: # side: {said}: expected {' or '.join(SIDES)}")
    return SIDES.index(said)


def _angles(path: Path, name: str, rows: list[list[str]], at: int) -> NDArray[np.float64]:
    """Return the angles [deg] listed under a key."""
    row = rows[at] if at < len(rows) else []
    try:
        if row[0].lower() != name.lower():
            raise ValueError
        values = np.array(rows[at + 1], float)
        if len(values) != int(row[1]) or not (np.diff(values) > 0).all():
            raise ValueError
        if not np.isfinite(values).all():
            raise ValueError
    except (ValueError, IndexError):
        raise InputError(
            f"{path}: {name}: {' '.join(row) or 'missing'}: expected {name} and a number, then as "
            "many rising angles on the next line"
        ) from None
    return values


def _check_angles(path: Path, angles: list[NDArray[np.float64]]) -> None:
    for name, values, high in zip(ANGLES, angles, (360, 90, 360, 180), strict=True):
        if values[0] < 0 or values[-1] > high or (name == "AngleOfIncidence" and values[-1] >= 90):
            raise InputError(f"{path}: {name}: {values[0]:g} … {values[-1]:g}: expected 0 … {high}")
    if len(angles[3]) < 2 or angles[3][0] != 0:
        raise InputError(f"{path}: ScatterRadial: expected 2 or more angles from 0")


def _data(path: Path, rows: list[list[str]], spectral: str, shape: list[int]):
    """Return (tis, value) of the luminous data."""
    wanted = "monochrome" if spectral == "monochrome" else "tristimulusy"
    flat = [" ".join(row).replace(" ", "").lower() for row in rows]
    if wanted not in flat:
        raise InputError(f"{path}: {wanted}: missing before DataBegin")
    rows = rows[flat.index(wanted) + 1 :]
    if not rows or rows[0][0].lower() != "databegin":
        raise InputError(f"{path}: DataBegin: missing")
    rotations, incidences, azimuths, radials = shape
    tis = np.empty((rotations, incidences))
    value = np.empty(shape)
    tokens = iter([token for row in rows[1:] for token in row])
    try:
        for s in range(rotations):
            for i in range(incidences):
                if next(tokens).lower() != "tis":
                    raise ValueError("TIS expected")
                tis[s, i] = next(tokens)
                block = [float(next(tokens)) for _ in range(azimuths * radials)]
                value[s, i] = np.reshape(block, (azimuths, radials))
        if next(tokens).lower() != "dataend":
            raise ValueError("DataEnd expected")
    except (ValueError, StopIteration) as error:
        raise InputError(
            f"{path}: data of rotation {s + 1}, incidence {i + 1}: {error or 'too few numbers'}: "
            f"expected TIS, a number, then {azimuths} x {radials} values"
        ) from None
    wrong = ~np.isfinite(value) | (value < 0)
    if wrong.any() or not (tis >= 0).all():
        raise InputError(f"{path}: data: TIS and values expected numbers from 0 up")
    return tis, value


def _around(path: Path, symmetry: str, azimuth: NDArray, value: NDArray) -> tuple[NDArray, NDArray]:
    """Return azimuths all around, from 0 to 2π inclusive, with their values."""
    if symmetry == "planesymmetrical":
        if abs(azimuth[0]) > 1e-9 or abs(azimuth[-1] - np.pi) > 1e-6:
            raise InputError(f"{path}: ScatterAzimuth: PlaneSymmetrical: expected from 0 to 180")
        mirrored = value[:, :, -2::-1]
        return (
            np.concatenate([azimuth, 2 * np.pi - azimuth[-2::-1]]),
            np.concatenate([value, mirrored], axis=2),
        )
    if abs(azimuth[0]) > 1e-9:
        raise InputError(f"{path}: ScatterAzimuth: {np.degrees(azimuth[0]):g}: expected 0 first")
    if abs(azimuth[-1] - 2 * np.pi) < 1e-6:
        return azimuth, value
    closed = np.concatenate([value, value[:, :, :1]], axis=2)
    return np.append(azimuth, 2 * np.pi), closed
