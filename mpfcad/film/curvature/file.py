"""Curvature maps on disk: reading CSV and NPZ with every refusal, writing an export's table."""

import csv
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.curvature.csv_columns import read_columns
from mpfcad.film.curvature.map import CurvatureMap, Extent, Repeat, find_bad_curvature
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
#: A step is a gap when it exceeds both: this many median steps, and this many mm.
GAP_STEPS, GAP_LENGTH = 5.0, 1.0
#: Largest jump [1/mm] where a repeated map meets itself: its ends are the same place.
SEAM_JUMP = 0.5


@dataclass(frozen=True)
class _Table:
    """The two columns of a map file, and the name of each row in a message."""

    path: Path
    position: NDArray[np.float64]
    curvature: NDArray[np.float64]
    row_name: Callable[[int], str]

    def refuse(self, index: int, text: str) -> InputError:
        return InputError(f"{self.path}: {self.row_name(index)}: {text}")


def read_curvature_map(
    path: Path,
    *,
    extent: Extent,
    repeat: Repeat,
    profile: Profile,
    groove: Groove,
    lamp_pitch: float,
    panel_width: float,
) -> CurvatureMap:
    """Read a curvature map from a CSV (`position_mm,curvature_per_mm`) or an NPZ of those arrays.

    It has to cover 0 … lamp_pitch (`pitch`, `repeat`), 0 … lamp_pitch/2 (`pitch`, `mirror`) or
    0 … panel_width (`panel`) [mm]; one groove pitch may lack, or be too much, at either end.

    Raises
    ------
    InputError
        one line with file, row, value and allowed range.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file: allowed a curvature map (.csv or .npz)")
    readers = {".csv": _read_csv, ".npz": _read_npz}
    if path.suffix.lower() not in readers:
        raise InputError(f"{path}: suffix {path.suffix!r}: allowed .csv or .npz")
    table = readers[path.suffix.lower()](path)
    if not len(table.position):
        raise InputError(f"{path}: no rows: allowed 2 or more")
    end = panel_width
    if extent == "pitch":
        end = lamp_pitch / 2 if repeat == "mirror" else lamp_pitch
    _check_order(table)
    trouble = find_bad_curvature(table.curvature, groove, profile)
    if trouble:
        raise table.refuse(trouble[0], f"curvature_per_mm {trouble[1]}")
    _check_cover(table, end, groove.pitch, f'extent = "{extent}", repeat = "{repeat}"')
    if extent == "pitch" and repeat == "repeat":
        _check_seam(table)
    return CurvatureMap(table.position, table.curvature, extent, repeat)


def _read_csv(path: Path) -> _Table:
    columns, lines = read_columns(path, COLUMNS)
    return _Table(path, columns[:, 0], columns[:, 1], lambda i: f"row {lines[i]}")


def _read_npz(path: Path) -> _Table:
    columns = []
    try:
        with np.load(path, allow_pickle=False) as arrays:
            for name in COLUMNS:
                if name not in arrays:
                    there = ", ".join(arrays.files)
                    raise InputError(f"{path}: array {name} missing among {there}: allowed both")
                columns.append(np.array(arrays[name]))
    except (OSError, ValueError, zipfile.BadZipFile):
        raise InputError(f"{path}: not an NPZ file of plain number arrays") from None
    for name, values in zip(COLUMNS, columns, strict=True):
        if values.ndim != 1 or values.dtype.kind not in "iuf":
            raise InputError(
                f"{path}: array {name}: {values.dtype} of shape {values.shape}: "
                f"allowed one row of numbers"
            )
    position, curvature = (values.astype(float) for values in columns)
    if len(position) != len(curvature):
        raise InputError(
            f"{path}: array {COLUMNS[1]}: {len(curvature)} values: allowed {len(position)}, "
            f"as many as {COLUMNS[0]}"
        )
    return _Table(path, position, curvature, lambda i: f"entry {i} (counted from 0)")


def _check_order(table: _Table) -> None:
    """Refuse positions that are not finite, double or not increasing."""
    x = table.position
    bad = np.flatnonzero(~np.isfinite(x))
    if bad.size:
        raise table.refuse(int(bad[0]), f"position_mm {x[bad[0]]:g}: allowed a finite number")
    bad = np.flatnonzero(np.diff(x) <= 0)
    if bad.size:
        i = int(bad[0]) + 1
        what = "duplicate of" if x[i] == x[i - 1] else "unsorted after"
        raise table.refuse(
            i,
            f"position_mm {x[i]:.10g}: {what} {table.row_name(i - 1)}: "
            f"allowed more than {x[i - 1]:.10g}",
        )


def _check_cover(table: _Table, end: float, tolerance: float, what: str) -> None:
    """Refuse positions outside 0 … end, ends that are not reached, and gaps between rows [mm]."""
    x, tolerance = table.position, tolerance * (1 + 1e-9)
    allowed = f"allowed 0 … {end:.10g} mm ({what})"
    for i in (0, len(x) - 1):
        if not -tolerance <= x[i] <= end + tolerance:
            raise table.refuse(i, f"position_mm {x[i]:.10g}: outside: {allowed}")
    if x[0] > tolerance:
        raise table.refuse(0, f"position_mm {x[0]:.10g}: gap: the map starts late: {allowed}")
    if x[-1] < end - tolerance:
        raise table.refuse(
            len(x) - 1, f"position_mm {x[-1]:.10g}: gap: the map ends early: {allowed}"
        )
    step = np.diff(x)
    if not step.size:
        return
    limit = max(GAP_STEPS * float(np.median(step)), GAP_LENGTH)
    i = int(np.argmax(step))
    if step[i] > limit * (1 + 1e-9):
        raise table.refuse(
            i + 1,
            f"position_mm {x[i + 1]:.10g}: gap of {step[i]:g} mm after {table.row_name(i)}: "
            f"allowed steps up to {limit:g} mm",
        )


def _check_seam(table: _Table) -> None:
    """Refuse a repeated map that jumps where one lamp pitch meets the next."""
    first, last = table.curvature[0], table.curvature[-1]
    if abs(last - first) > SEAM_JUMP:
        raise table.refuse(
            len(table.curvature) - 1,
            f"curvature_per_mm {last:g}: the map repeats, so its end is its start: "
            f"allowed {first:g} ± {SEAM_JUMP:g} as in {table.row_name(0)}",
        )


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
