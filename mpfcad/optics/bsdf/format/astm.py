"""BSDF tables with the columns of ASTM E1392 and E2387: `theta_i, phi_i, theta_s, phi_s, value`.

A header of `KEY value` lines may stand before `VARS name,name,…`, as in ASTM E1392; else the names
are the first row. The light comes from azimuth `phi_i`, so what goes straight on or is mirrored
leaves at `phi_i` + 180°.
"""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.format.csv import Grid, grid_table
from mpfcad.optics.bsdf.format.source import read_text
from mpfcad.optics.bsdf.missing import Matrices
from mpfcad.optics.bsdf.table import BELOW, REFLECT, SIDES, TRANSMIT

_ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
_VALUES = ("brdf", "btdf", "bsdf", "bsdf_per_sr", "y")
_UNITS = {"deg": 1.0, "degrees": 1.0, "rad": 180 / np.pi, "radians": 180 / np.pi}


def is_astm(path: Path) -> bool:
    """Tell whether a file names the columns of ASTM E1392 and E2387."""
    return "theta_i" in read_text(path)[0][:4000].lower().replace(" ", "_")


def read_astm(path: Path) -> tuple[AngleBasis, bool, Matrices, tuple[str, ...]]:
    """Return (basis, isotropic, matrices (i, o) [1/sr] by (way, side), notes).

    Raises
    ------
    InputError
        when columns, their unit or rows are not as the standard has them.
    """
    text, notes = read_text(path)
    header, names, rows = _split(path, text)
    angle = [_column(path, names, name) for name in _ANGLES]
    column = next((n for n, name in enumerate(names) if name.split("[")[0] in _VALUES), None)
    if column is None:
        raise InputError(
            f"{path}: columns {', '.join(names)}: expected one of {', '.join(_VALUES)}"
        )
    try:
        table = np.array([[float(v) for v in row[: len(names)]] for _, row in rows])
        if table.ndim != 2 or table.shape[1] != len(names):
            raise ValueError
    except ValueError:
        raise InputError(f"{path}: rows: expected {len(names)} numbers each") from None
    angles, value = table[:, [n for n, _ in angle]], table[:, column]
    if not np.isfinite(angles).all() or not (value >= 0).all():
        raise InputError(f"{path}: rows: expected finite angles and values from 0 up")
    factor, unit = _unit(path, header, [u for _, u in angle], angles)
    angles = angles * factor
    if len(np.unique(np.round(angles[:, 1] % 360, 6))) > 1:
        raise InputError(f"{path}: phi_i: several: expected one: only isotropic sheets")
    ways = _ways(names[column], angles[:, 2])
    grid = np.zeros((len(angles), 4))
    grid[:, 0] = angles[:, 0]
    grid[:, 2] = np.where(angles[:, 2] > 90 + 1e-9, 180 - angles[:, 2], angles[:, 2])
    grid[:, 3] = (angles[:, 3] - angles[:, 1] - 180) % 360
    # Radians of four digits are off by a hundredth of a degree at most.
    grid = np.round(grid, 6 if factor == 1 else 2)
    grid[grid[:, 3] == 360, 3] = 0
    side = _side(path, header)
    keys = np.stack([ways, np.full(len(ways), side)], axis=1)
    # 0 and 360 deg are one direction.
    _, first = np.unique(np.column_stack([keys, grid]), axis=0, return_index=True)
    first.sort()
    basis, isotropic, found, more = grid_table(path, Grid(keys[first], grid[first], value[first]))
    said = f"angles in {unit}, light from {SIDES[side]}"
    return basis, isotropic, found, (*notes, said, *more)


def _split(path: Path, text: str) -> tuple[dict[str, str], list[str], list[tuple[int, list[str]]]]:
    """Return header keys, column names and numbered rows."""
    header: dict[str, str] = {}
    names: list[str] = []
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        plain = line.strip()
        if not plain:
            continue
        if names:
            if not plain.startswith("#"):
                rows.append((number, next(csv.reader([plain]))))
        elif "theta_i" in plain.lower().replace(" ", "_"):
            listed = plain[4:] if plain.upper().startswith("VARS") else plain
            names = [n.strip().lower().replace(" ", "_") for n in listed.strip(" :=").split(",")]
        else:
            key, _, value = plain.lstrip("# ").replace(":", " ", 1).partition(" ")
            header[key.lower()] = value.strip().lower()
    if not rows:
        raise InputError(f"{path}: no rows: expected columns {', '.join(_ANGLES)} and a value")
    return header, names, rows


def _column(path: Path, names: list[str], wanted: str) -> tuple[int, str]:
    """Return where an angle's column is, and the unit in its name."""
    for n, name in enumerate(names):
        if name == wanted:
            return n, ""
        rest = name.removeprefix(wanted).strip("_[]()")
        if name.startswith(wanted) and rest in _UNITS:
            return n, rest
    raise InputError(f"{path}: columns {', '.join(names)}: expected {wanted}")


def _unit(
    path: Path, header: dict[str, str], units: list[str], angles: NDArray[np.float64]
) -> tuple[float, str]:
    """Return the factor to degrees, and the unit in words."""
    stated = next(filter(None, (*units, header.get("angle_units"), header.get("units"))), None)
    if stated in _UNITS:
        return _UNITS[stated], stated
    polar, azimuth = np.abs(angles[:, ::2]).max(), np.abs(angles[:, 1::2]).max()
    if polar > np.pi + 0.01 or azimuth > 2 * np.pi + 0.01:
        return 1.0, "degrees"
    if azimuth > 3:
        return 180 / np.pi, "radians"
    raise InputError(
        f"{path}: angles up to {max(polar, azimuth):g}: degrees or radians: expected theta_i_deg "
        "or theta_i_rad in the header"
    )


def _ways(name: str, scatter: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return each row's way: by the value's name, else by the hemisphere of the scatter angle."""
    if name == "brdf":
        return np.full(len(scatter), REFLECT)
    if name == "btdf":
        return np.full(len(scatter), TRANSMIT)
    return np.where(scatter > 90 + 1e-9, TRANSMIT, REFLECT)


def _side(path: Path, header: dict[str, str]) -> int:
    said = header.get("side", SIDES[BELOW])
    if said not in SIDES:
        raise InputError(f"{path}: side: {said}: expected {' or '.join(SIDES)}")
    return SIDES.index(said)
