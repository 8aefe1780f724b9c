"""Rows of a curvature map, wherever they come from, checked and made into the map."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.curvature.map import CurvatureMap, Extent, Repeat, find_bad_curvature
from mpfcad.film.groove import Groove, Profile

#: A step is a gap when it exceeds both: this many median steps, and this many mm.
GAP_STEPS, GAP_LENGTH = 5.0, 1.0
#: Largest jump [1/mm] where a repeated map meets itself: its ends are the same place.
SEAM_JUMP = 0.5


@dataclass(frozen=True)
class CurvatureTable:
    """Position and curvature in rows, not checked yet.

    Attributes
    ----------
    where
        the file, or the place in a job, for messages
    position
        (m,) float64 [mm]
    curvature
        (m,) float64 [1/mm]
    row_name
        the name of a row in a message, by its index
    """

    where: str
    position: NDArray[np.float64]
    curvature: NDArray[np.float64]
    row_name: Callable[[int], str]

    def refuse(self, index: int, text: str) -> InputError:
        """Return the error that names a row."""
        return InputError(f"{self.where}: {self.row_name(index)}: {text}")


def build_curvature_map(
    table: CurvatureTable,
    *,
    extent: Extent,
    repeat: Repeat,
    profile: Profile,
    groove: Groove,
    lamp_pitch: float,
    panel_width: float,
) -> CurvatureMap:
    """Return the map that a table states.

    It has to cover 0 … lamp_pitch (`pitch`, `repeat`), 0 … lamp_pitch/2 (`pitch`, `mirror`) or
    0 … panel_width (`panel`) [mm]; one groove pitch may lack, or be too much, at either end.

    Raises
    ------
    InputError
        one line with file, row, value and what was expected.
    """
    if not len(table.position):
        raise InputError(f"{table.where}: no rows: expected 2 or more")
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


def _check_order(table: CurvatureTable) -> None:
    """Refuse positions that are not finite, double or not increasing."""
    x = table.position
    bad = np.flatnonzero(~np.isfinite(x))
    if bad.size:
        raise table.refuse(int(bad[0]), f"position_mm {x[bad[0]]:g}: expected a finite number")
    bad = np.flatnonzero(np.diff(x) <= 0)
    if bad.size:
        i = int(bad[0]) + 1
        what = "duplicate of" if x[i] == x[i - 1] else "unsorted after"
        raise table.refuse(
            i,
            f"position_mm {x[i]:.10g}: {what} {table.row_name(i - 1)}: "
            f"expected more than {x[i - 1]:.10g}",
        )


def _check_cover(table: CurvatureTable, end: float, tolerance: float, what: str) -> None:
    """Refuse positions outside 0 … end, ends that are not reached, and gaps between rows [mm]."""
    x, tolerance = table.position, tolerance * (1 + 1e-9)
    expected = f"expected 0 … {end:.10g} mm ({what})"
    for i in (0, len(x) - 1):
        if not -tolerance <= x[i] <= end + tolerance:
            raise table.refuse(i, f"position_mm {x[i]:.10g}: outside: {expected}")
    if x[0] > tolerance:
        raise table.refuse(0, f"position_mm {x[0]:.10g}: gap: the map starts late: {expected}")
    if x[-1] < end - tolerance:
        raise table.refuse(
            len(x) - 1, f"position_mm {x[-1]:.10g}: gap: the map ends early: {expected}"
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
            f"expected steps up to {limit:g} mm",
        )


def _check_seam(table: CurvatureTable) -> None:
    """Refuse a repeated map that jumps where one lamp pitch meets the next."""
    first, last = table.curvature[0], table.curvature[-1]
    if abs(last - first) > SEAM_JUMP:
        raise table.refuse(
            len(table.curvature) - 1,
            f"curvature_per_mm {last:g}: the map repeats, so its end is its start: "
            f"expected {first:g} ± {SEAM_JUMP:g} as in {table.row_name(0)}",
        )
