"""Curvature maps on disk: reading CSV and NPZ with every refusal, writing an export's table."""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mpfcad.boundary import reads
from mpfcad.boundary.npz import read_arrays
from mpfcad.errors import InputError
from mpfcad.film.curvature.csv_columns import read_columns
from mpfcad.film.curvature.table import CurvatureTable
from mpfcad.film.groove import Groove, Profile

COLUMNS = ("position_mm", "curvature_per_mm")
EXPORT_COLUMNS = (
    "groove",
    "position_mm",
    "curvature_per_mm",
    "fitted_curvature_per_mm",
    "fill_fraction",
    "aperture_ratio",
)


@reads("a curvature map (.csv or .npz)")
def read_curvature_table(path: Path) -> CurvatureTable:
    """Read the rows of a map from a CSV (`position_mm,curvature_per_mm`) or an NPZ of those arrays.

    Raises
    ------
    InputError
        one line with file, row, value and what was expected.
    """
    path = Path(path)
    readers = {".csv": _read_csv, ".npz": _read_npz}
    if path.suffix.lower() not in readers:
        raise InputError(f"{path}: suffix {path.suffix!r}: expected .csv or .npz")
    return readers[path.suffix.lower()](path)


def _read_csv(path: Path) -> CurvatureTable:
    columns, lines = read_columns(path, COLUMNS)
    return CurvatureTable(str(path), columns[:, 0], columns[:, 1], lambda i: f"row {lines[i]}")


def _read_npz(path: Path) -> CurvatureTable:
    columns = read_arrays(path, COLUMNS)
    for name, values in zip(COLUMNS, columns, strict=True):
        if values.ndim != 1 or values.dtype.kind not in "iuf":
            raise InputError(
                f"{path}: array {name}: {values.dtype} of shape {values.shape}: "
                f"expected one row of numbers"
            )
    position, curvature = (values.astype(float) for values in columns)
    if len(position) != len(curvature):
        raise InputError(
            f"{path}: array {COLUMNS[1]}: {len(curvature)} values: expected {len(position)}, "
            f"as many as {COLUMNS[0]}"
        )
    return CurvatureTable(str(path), position, curvature, lambda i: f"entry {i} (counted from 0)")


def write_curvature_map(
    path: Path,
    position: ArrayLike,
    curvature: ArrayLike,
    *,
    groove: Groove,
    profile: Profile,
    aperture_ratio: ArrayLike | None = None,
) -> None:
    """Write the table of an export, one row a groove, grooves counted from 0.

    Parameters
    ----------
    path
        the CSV to make
    position
        (n,) float64 [mm], groove centres on the panel
    curvature
        (n,) float64 [1/mm], C through the tips
    groove, profile
        of the film, for the fitted curvature and the fill fraction
    aperture_ratio
        (n,) float64 of the mask; None (an ideal film has no mask) leaves the column empty
    """
    curvature = np.asarray(curvature, float)
    columns = [
        [f"{x:.6f}" for x in np.asarray(position, float)],
        [f"{c:.9g}" for c in curvature],
        [f"{c:.9g}" for c in groove.fitted_curvature(curvature, profile)],
        [f"{f:.9g}" for f in groove.fill_fraction(curvature)],
        [""] * len(curvature)
        if aperture_ratio is None
        else [f"{a:.9g}" for a in np.asarray(aperture_ratio, float)],
    ]
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    with part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(EXPORT_COLUMNS)
        writer.writerows(zip(map(str, range(len(curvature))), *columns, strict=True))
    part.replace(path)
