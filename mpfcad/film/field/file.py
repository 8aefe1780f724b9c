"""Curvature fields on disk: an NPZ of two positions and a table."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary.npz import has_array, read_arrays
from mpfcad.errors import InputError
from mpfcad.film.curvature.map import find_bad_curvature
from mpfcad.film.field.field import CurvatureField, PanelField
from mpfcad.film.field.repeated import CurvatureCell
from mpfcad.film.groove import Groove, Profile

FIELD_ARRAYS = ("position_across_mm", "position_along_mm", "curvature_per_mm")
#: Of cells with two curvatures: C along y, on the same positions.
ALONG_ARRAY = "curvature_along_per_mm"


def is_field_file(path: Path) -> bool:
    """Return whether a file is an NPZ with the three arrays of a field."""
    return has_array(path, FIELD_ARRAYS[0])


def read_curvature_field(
    path: Path, *, profile: Profile, groove: Groove, panel_width: float, panel_length: float
) -> CurvatureField:
    """Read a field from an NPZ of position_across_mm, position_along_mm, curvature_per_mm.

    The table has one row a position along and one column a position across, and has to cover the
    panel [mm]; one groove pitch may lack at either end.

    Raises
    ------
    InputError
        one line with file, array, entry, value and expected range.
    """
    path = Path(path)
    across, along, curvature = _read_field(path, profile, groove)
    _check_position(path, FIELD_ARRAYS[0], across, panel_width, groove.pitch)
    _check_position(path, FIELD_ARRAYS[1], along, panel_length, groove.pitch)
    return CurvatureField(across, along, curvature)


def _read_field(
    path: Path, profile: Profile, groove: Groove, table: str = FIELD_ARRAYS[2]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return positions across and along, and curvatures along by across, that a film can have."""
    names = (*FIELD_ARRAYS[:2], table)
    across, along, curvature = read_arrays(path, names)
    for name, values, dimension in zip(names, (across, along, curvature), (1, 1, 2), strict=True):
        if values.ndim != dimension or values.dtype.kind not in "iuf":
            raise InputError(
                f"{path}: array {name}: {values.dtype} of shape {values.shape}: "
                f"expected numbers in {dimension} dimension{'s' * (dimension > 1)}"
            )
    if curvature.shape != (len(along), len(across)):
        raise InputError(
            f"{path}: array {table}: shape {curvature.shape}: expected "
            f"{(len(along), len(across))}, along by across"
        )
    trouble = find_bad_curvature(curvature.astype(float).ravel(), groove, profile)
    if trouble:
        row, column = divmod(trouble[0], len(across))
        raise InputError(f"{path}: {table}[{row}, {column}] (counted from 0): {trouble[1]}")
    return across, along, curvature


def write_curvature_field(
    path: Path, field: PanelField, along: NDArray[np.float64] | None = None
) -> None:
    """Write a field so that it reads back bit for bit; same field, same bytes.

    Of one that repeats it is the cell, positions from its LED. `along` is C along y [1/mm], along
    by across, of cells with two curvatures.
    """
    named: dict[str, Any] = dict(zip(FIELD_ARRAYS, field.stored, strict=True))
    if along is not None:
        named[ALONG_ARRAY] = along
    np.savez(path, **named)


def _check_position(path: Path, name: str, x: NDArray, end: float, tolerance: float) -> None:
    """Refuse positions that do not increase or do not cover 0 … end [mm]."""
    if len(x) < 2:
        raise InputError(f"{path}: array {name}: {len(x)} values: expected 2 or more")
    bad = np.flatnonzero(~np.isfinite(x) | (np.diff(x, prepend=-np.inf) <= 0))
    if bad.size:
        raise InputError(
            f"{path}: {name}[{bad[0]}] (counted from 0): {x[bad[0]]:g}: "
            f"expected finite and increasing"
        )
    if x[0] > tolerance or x[-1] < end - tolerance * (1 + 1e-9):
        raise InputError(
            f"{path}: array {name}: {x[0]:g} … {x[-1]:g}: expected to cover 0 … {end:.10g} mm"
        )


def has_along(path: Path) -> bool:
    """Return whether a file is an NPZ that holds C along y as well."""
    return has_array(path, ALONG_ARRAY)


def read_curvature_cell(
    path: Path,
    *,
    profile: Profile,
    groove: Groove,
    size: tuple[float, float],
    table: str = FIELD_ARRAYS[2],
) -> CurvatureCell:
    """Read a map over a cell of LEDs from an NPZ with the arrays of a field.

    Positions are from the LED at the cell's corner and within the cell, `size` [mm]; the map
    repeats, so no node has to stand at the cell's end. `table` names the array of curvatures.

    Raises
    ------
    InputError
        one line with file, array, entry, value and expected range.
    """
    across, along, curvature = _read_field(Path(path), profile, groove, table)
    for name, x, end in zip(FIELD_ARRAYS, (across, along), size, strict=False):
        bad = np.flatnonzero(
            ~np.isfinite(x) | (np.diff(x, prepend=-np.inf) <= 0) | (x < 0) | (x > end * (1 + 1e-9))
        )
        if bad.size:
            raise InputError(
                f"{path}: {name}[{bad[0]}] (counted from 0): {x[bad[0]]:g}: expected increasing, "
                f"0 … {end:.10g} mm from the LED"
            )
    return CurvatureCell(across / size[0], along / size[1], curvature.astype(float))
