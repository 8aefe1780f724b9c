"""BSDF tables as CSV, a row a pair of directions.

Columns `side,way,incidence_deg,incidence_azimuth_deg,scatter_deg,scatter_azimuth_deg,bsdf_per_sr`.
Azimuths are of the way of travel; without `incidence_azimuth_deg` the table is isotropic and
`scatter_azimuth_deg` counts from the incident ray's: 0 is where direct and mirrored light goes.
Lines `# edges_deg: …` and `# azimuths: …` before the header give the bins; without them bins end
halfway between the angles measured.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis, edges_between, ring_basis
from mpfcad.optics.bsdf.format.source import read_text
from mpfcad.optics.bsdf.missing import Matrices
from mpfcad.optics.bsdf.table import SIDES, WAYS, BsdfTable

_ISOTROPIC = ["side", "way", "incidence_deg", "scatter_deg", "scatter_azimuth_deg", "bsdf_per_sr"]
_COLUMNS = [*_ISOTROPIC[:3], "incidence_azimuth_deg", *_ISOTROPIC[3:]]
_LEAST_AZIMUTHS = 4

#: More bins than any instrument resolves: a matrix of as many squared is 800 MB.
_MOST_BINS = 10_000


@dataclass(frozen=True, eq=False)
class Grid:
    """Rows of an isotropic measurement.

    Attributes
    ----------
    keys
        (n, 2) int64: way, side
    angles
        (n, 4) float64 [deg]: incidence, 0, scatter, azimuth from the direct or mirrored ray
    value
        (n,) float64 [1/sr]
    """

    keys: NDArray[np.int64]
    angles: NDArray[np.float64]
    value: NDArray[np.float64]


def read_bsdf_csv(path: Path) -> tuple[AngleBasis, bool, Matrices, tuple[str, ...]]:
    """Return (basis, isotropic, matrices (i, o) [1/sr] by (way, side), notes).

    Raises
    ------
    InputError
        when a row, angle or value is wrong, missing or there twice.
    """
    remarks, header, rows = _read(path)
    isotropic = header == _ISOTROPIC
    keys, angles, value = _parsed(path, header, rows)
    if "edges_deg" in remarks or "azimuths" in remarks:
        basis = _given_basis(path, remarks)
        return basis, isotropic, _by_bin(path, basis, isotropic, keys, angles, value), ()
    if not isotropic:
        raise InputError(
            f"{path}: column incidence_azimuth_deg: needs lines '# edges_deg:' and '# azimuths:' "
            "before the header"
        )
    return grid_table(path, Grid(keys, angles, value))


def _read(path: Path) -> tuple[dict[str, str], list[str], list[tuple[int, list[str]]]]:
    """Return the remarks, the header and the numbered rows."""
    lines = list(enumerate(read_text(path)[0].splitlines(), 1))
    remarks = {}
    for _, line in lines:
        if line.startswith("#") and ":" in line:
            name, _, text = line[1:].partition(":")
            remarks[name.strip()] = text.strip()
    kept = [(n, line) for n, line in lines if line.strip() and not line.startswith("#")]
    # Each line by itself: a stray quote must not swallow those after it.
    parsed = [(n, next(csv.reader([line]))) for n, line in kept]
    if not parsed or parsed[0][1] not in (_ISOTROPIC, _COLUMNS):
        raise InputError(
            f"{path}: header: expected {','.join(_ISOTROPIC)}, with incidence_azimuth_deg after "
            "incidence_deg where not isotropic"
        )
    return remarks, parsed[0][1], parsed[1:]


def _parsed(path: Path, header: list[str], rows: list[tuple[int, list[str]]]):
    """Return (way, side) (n, 2), angles (n, 4) [deg] and values (n,) of the rows."""
    keys = np.empty((len(rows), 2), np.int64)
    numbers = np.empty((len(rows), len(header) - 2))
    for at, (line, row) in enumerate(rows):
        try:
            keys[at] = WAYS.index(row[1]), SIDES.index(row[0])
            numbers[at] = row[2:]
        except (ValueError, IndexError):
            raise InputError(
                f"{path}: row {line}: {','.join(row)!r}: expected side ({' or '.join(SIDES)}), way "
                f"({' or '.join(WAYS)}) and {len(header) - 2} numbers"
            ) from None
    if not len(rows):
        raise InputError(f"{path}: no rows: expected 1 or more")
    value = numbers[:, -1]
    angles = numbers[:, :-1]
    if len(header) == len(_ISOTROPIC):
        angles = np.insert(angles, 1, 0.0, axis=1)
    polar = angles[:, [0, 2]]
    wrong = ~np.isfinite(numbers).all(axis=1) | ((polar < 0) | (polar > 90)).any(axis=1)
    wrong |= ~(value >= 0)
    if wrong.any():
        line, row = rows[int(np.argmax(wrong))]
        raise InputError(
            f"{path}: row {line}: {','.join(row)!r}: expected angles of 0 … 90 deg, values from 0"
        )
    return keys, angles, value


def _given_basis(path: Path, remarks: dict[str, str]) -> AngleBasis:
    try:
        edge = np.array(remarks["edges_deg"].split(), float)
        azimuths = np.array(remarks["azimuths"].split(), np.int64)
    except (KeyError, ValueError) as error:
        raise InputError(f"{path}: # edges_deg, # azimuths: {error}: expected numbers") from None
    rising = (
        len(edge) > 1 and edge[0] == 0 and abs(edge[-1] - 90) < 1e-9 and (np.diff(edge) > 0).all()
    )
    if not rising:
        raise InputError(
            f"{path}: # edges_deg: {remarks['edges_deg']}: expected to rise from 0 to 90"
        )
    if len(azimuths) != len(edge) - 1 or azimuths.min() < 1:
        raise InputError(f"{path}: # azimuths: expected {len(edge) - 1} numbers from 1 up")
    if azimuths.astype(float).sum() > _MOST_BINS:
        raise InputError(
            f"{path}: # azimuths: {azimuths.astype(float).sum():.4g} bins: expected at most "
            f"{_MOST_BINS}"
        )
    return AngleBasis(remarks.get("basis", path.stem), np.radians(edge), azimuths)


def _by_bin(path, basis, isotropic, keys, angles, value) -> Matrices:
    """Return the matrices of rows that name bins by a direction in them."""
    if isotropic and (len(set(basis.azimuths.tolist())) > 1 or basis.azimuths[0] % 2):
        raise InputError(f"{path}: # azimuths: expected all the same and even where isotropic")
    sine, turn = np.sin(np.radians(angles)), np.radians(angles)
    leaving = basis.bin_of(sine[:, 2] * np.cos(turn[:, 3]), sine[:, 2] * np.sin(turn[:, 3]))
    coming = basis.bin_of(sine[:, 0] * np.cos(turn[:, 1]), sine[:, 0] * np.sin(turn[:, 1]))
    count = len(basis.azimuths) if isotropic else basis.count
    if isotropic:
        coming = basis.ring[coming]
    found: Matrices = {}
    for way, side in sorted(set(map(tuple, keys.tolist()))):
        mine = (keys == (way, side)).all(axis=1)
        number = np.zeros((count, basis.count), np.int64)
        np.add.at(number, (coming[mine], leaving[mine]), 1)
        if (number != 1).any():
            i, o = np.argwhere(number != 1)[0]
            polar = basis.polar if isotropic else basis.polar[basis.ring]
            raise InputError(
                f"{path}: {WAYS[way]} from {SIDES[side]}: {number[i, o]} rows from incidence "
                f"{np.degrees(polar[i]):.4g} deg to scatter "
                f"{np.degrees(basis.polar[basis.ring[o]]):.4g} deg, azimuth "
                f"{np.degrees(basis.azimuth[o]):.4g} deg: expected 1"
            )
        matrix = np.zeros(number.shape)
        matrix[coming[mine], leaving[mine]] = value[mine]
        found[way, side] = matrix
    return found


def grid_table(path: Path, grid: Grid) -> tuple[AngleBasis, bool, Matrices, tuple[str, ...]]:
    """Return (basis, isotropic, matrices, notes) of values at the points of a grid of angles.

    Raises
    ------
    InputError
        when a point is missing or there twice, or azimuths are not even.
    """
    keys, angles, value = grid.keys, grid.angles, grid.value
    incidence, scatter, azimuth = (np.unique(angles[:, c]) for c in (0, 2, 3))
    azimuths = _azimuths(path, azimuth)
    if len(scatter) < 2:
        raise InputError(f"{path}: scatter_deg: {len(scatter)} angle: expected 2 or more")
    basis = ring_basis(edges_between(np.radians(scatter)), azimuths)
    found: Matrices = {}
    for way, side in sorted(set(map(tuple, keys.tolist()))):
        mine = (keys == (way, side)).all(axis=1)
        at = tuple(
            np.searchsorted(axis, angles[mine, c])
            for axis, c in ((incidence, 0), (scatter, 2), (azimuth, 3))
        )
        number = np.zeros((len(incidence), len(scatter), len(azimuth)), np.int64)
        np.add.at(number, at, 1)
        if (number != 1).any():
            i, s, a = np.argwhere(number != 1)[0]
            raise InputError(
                f"{path}: {WAYS[way]} from {SIDES[side]}: {number[i, s, a]} rows at incidence "
                f"{incidence[i]:g}, scatter {scatter[s]:g}, azimuth {azimuth[a]:g} deg: expected 1"
            )
        cube = np.zeros(number.shape)
        cube[at] = value[mine]
        if azimuth[-1] <= 180 and azimuths > len(azimuth):
            cube = np.concatenate([cube, cube[:, :, -2:0:-1]], axis=2)
        rows = _rows_between(incidence, scatter, cube.reshape(len(incidence), -1))
        found[way, side] = rows
    note = []
    if not np.array_equal(incidence, scatter):
        note.append(
            f"incidence measured at {incidence[0]:g} … {incidence[-1]:g} deg: linear between, the "
            "nearest beyond"
        )
    if azimuth[-1] <= 180:
        note.append("scatter azimuths 0 … 180 deg mirrored")
    return basis, True, found, tuple(note)


def _azimuths(path: Path, azimuth: NDArray[np.float64]) -> int:
    """Return the number of azimuths around, from angles evenly over 0…180 or 0…360 deg."""
    step = np.diff(azimuth)
    even = len(azimuth) > 1 and azimuth[0] == 0 and np.ptp(step) < 1e-6
    around = 360 / step[0] if even else 0.0
    half, whole = abs(azimuth[-1] - 180) < 1e-6, even and abs(azimuth[-1] + step[0] - 360) < 1e-6
    if not even or not (half or whole) or around < _LEAST_AZIMUTHS or round(around) % 2:
        raise InputError(
            f"{path}: scatter_azimuth_deg: {azimuth[0]:g} … {azimuth[-1]:g}: expected even steps "
            f"of at most 90 over 0 … 180 (mirrored) or, an even number, 0 … below 360"
        )
    return round(around)


def _rows_between(incidence, scatter, rows) -> NDArray[np.float64]:
    """Return a row for each scatter angle, linear between the measured incidences."""
    if np.array_equal(incidence, scatter):
        return rows
    place = np.interp(scatter, incidence, np.arange(len(incidence)))
    low = np.minimum(place.astype(np.int64), max(0, len(incidence) - 2))
    part = (place - low)[:, None]
    return rows[low] * (1 - part) + rows[np.minimum(low + 1, len(incidence) - 1)] * part


def bsdf_csv(table: BsdfTable) -> str:
    """Return a table as CSV; numbers read back as the same bits."""
    basis = table.basis
    degrees = [f"{a:.10g}" for a in np.degrees(basis.polar)]
    turn = [f"{a:.10g}" for a in np.degrees(basis.azimuth)]
    leaving = [f"{degrees[r]},{t}" for r, t in zip(basis.ring, turn, strict=True)]
    coming = degrees if table.isotropic else leaving
    lines = [
        f"# basis: {basis.name}",
        "# edges_deg: " + " ".join(f"{e:.10g}" for e in np.degrees(basis.edge)),
        "# azimuths: " + " ".join(map(str, basis.azimuths)),
        ",".join(_ISOTROPIC if table.isotropic else _COLUMNS),
    ]
    for side, side_name in enumerate(SIDES):
        for way, way_name in enumerate(WAYS):
            for i, row in enumerate(table.value[way, side].tolist()):
                start = f"{side_name},{way_name},{coming[i]},"
                lines += [f"{start}{o},{v!r}" for o, v in zip(leaving, row, strict=True)]
    return "\n".join(lines) + "\n"
