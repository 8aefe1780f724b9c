"""Stylus traces: height over position across the grooves, as a profiler measured it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.curvature.csv_columns import read_columns
from mpfcad.film.groove import Groove
from mpfcad.units import um

COLUMNS = ("x_um", "z_um")
#: Points that a trace must have in each prism width; its largest step is the pitch over half of it.
FEWEST_POINTS = 20


@dataclass(frozen=True, eq=False)
class StylusTrace:
    """Heights measured across the grooves; tilt, offset and the place of the grooves are unknown.

    Attributes
    ----------
    position, height
        (n,) float64 [mm]; positions increase
    name
        of the file, for messages
    """

    position: NDArray[np.float64]
    height: NDArray[np.float64]
    name: str

    def middle(self, width: float) -> "StylusTrace":
        """Return the middle `width` [mm] of the trace, its two ends as far from the middle."""
        start = (self.position[0] + self.position[-1] - width) / 2
        inside = (self.position >= start) & (self.position < start + width)
        return StylusTrace(self.position[inside], self.height[inside], self.name)


def read_stylus_trace(path: Path, groove: Groove, prism_widths: int = 2) -> StylusTrace:
    """Read a trace from a CSV `x_um,z_um`, at least `prism_widths` prism widths long.

    Raises
    ------
    InputError
        one line with file, row, value and allowed range.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file: allowed a stylus trace (CSV {','.join(COLUMNS)})")
    columns, lines = read_columns(path, COLUMNS)
    for column, name in enumerate(COLUMNS):
        bad = np.flatnonzero(~np.isfinite(columns[:, column]))
        if bad.size:
            i = int(bad[0])
            raise InputError(
                f"{path}: row {lines[i]}: {name} {columns[i, column]:g}: allowed a finite number"
            )
    x, z = columns[:, 0] * um, columns[:, 1] * um
    bad = np.flatnonzero(np.diff(x) <= 0)
    if bad.size:
        i = int(bad[0]) + 1
        raise InputError(
            f"{path}: row {lines[i]}: x_um {x[i] / um:.10g}: not increasing: "
            f"allowed more than {x[i - 1] / um:.10g} of row {lines[i - 1]}"
        )
    _check_sampling(path, x, lines, groove.pitch, prism_widths)
    return StylusTrace(x, z, path.name)


def _check_sampling(
    path: Path, x: NDArray[np.float64], lines: list[int], pitch: float, prism_widths: int
) -> None:
    """Refuse a trace that is too short or too coarse to tell the shape of a groove."""
    if len(x) < FEWEST_POINTS * prism_widths:
        raise InputError(
            f"{path}: {len(x)} rows: allowed {FEWEST_POINTS * prism_widths} or more, "
            f"{FEWEST_POINTS} a prism width"
        )
    length, step = x[-1] - x[0], np.diff(x)
    if length + np.median(step) < prism_widths * pitch * (1 - 1e-9):
        raise InputError(
            f"{path}: x_um: {length / um:.6g} µm long: allowed {prism_widths * pitch / um:g} µm or "
            f"more, {prism_widths} prism widths of {pitch / um:g} µm"
        )
    i = int(np.argmax(step))
    widest = 2 * pitch / FEWEST_POINTS
    if step[i] > widest:
        raise InputError(
            f"{path}: row {lines[i + 1]}: x_um {x[i + 1] / um:.10g}: gap of {step[i] / um:g} µm: "
            f"allowed steps up to {widest / um:g} µm"
        )
