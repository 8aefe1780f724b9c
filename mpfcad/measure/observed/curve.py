"""A luminance curve from a file: position, luminance, and its standard error where it is stated."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.file.text import read_table
from mpfcad.film.stylus.file.unit import UNITS, find_unit
from mpfcad.measure.observed.unit import strange_luminance

_FEWEST = 16


@dataclass(frozen=True, eq=False)
class ObservedCurve:
    """Luminance across the lamps.

    Attributes
    ----------
    position, luminance, error
        (n,) float64 [mm], [cd/m²], standard errors; positions increase
    reading
        what was understood of the file
    """

    position: NDArray[np.float64]
    luminance: NDArray[np.float64]
    error: NDArray[np.float64]
    reading: str


def read_curve(path: Path, unit: str | None = None) -> ObservedCurve:
    """Read a curve: columns position, luminance and, if there is one, standard error.

    The position's unit is `unit`, or what its column's name states. Without a column of errors the
    noise is that of third differences, which a smooth curve has not.

    Raises
    ------
    InputError
        one line with file, row, value and what was expected.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file: expected a luminance curve or image")
    table = read_table(path)
    count = table.values.shape[1]
    if count not in (2, 3):
        raise InputError(
            f"{path}: row {table.lines[0]}: {count} columns: expected position and luminance, and "
            "a standard error if it is known"
        )
    if count == 3 and "err" not in table.names[2].lower() and "σ" not in table.names[2]:
        raise InputError(
            f"{path}: column 3 ({table.names[2] or 'unnamed'}): could be a second luminance or its "
            "standard error: expected a name with 'error'"
        )
    stated = _position_unit(path, table.names[0].replace("_", " "), unit)
    for number, name in enumerate(table.names[1:], 2):
        strange = strange_luminance(name)
        if strange is not None:
            raise InputError(f"{path}: column {number} ({name}): {strange!r}: expected cd/m²")
    kept = np.isfinite(table.values).all(axis=1)
    values = table.values[kept]
    values = values[np.argsort(values[:, 0], kind="stable")]
    x, luminance = values[:, 0] * UNITS[stated], values[:, 1]
    bad = np.flatnonzero(luminance <= 0)
    if bad.size:
        raise InputError(
            f"{path}: luminance {luminance[bad[0]]:g} at {x[bad[0]]:g} mm: expected above 0"
        )
    if len(x) < _FEWEST or x[-1] == x[0]:
        raise InputError(f"{path}: {len(x)} rows: expected {_FEWEST} or more")
    error = values[:, 2] if count == 3 else np.full(len(x), noise_of(luminance))
    if np.any(error < 0):
        raise InputError(f"{path}: standard error {error.min():g}: expected 0 or more")
    words = [f"{count} columns", stated, *table.words, f"{len(x):,} points"]
    if not kept.all():
        words.append(f"{np.count_nonzero(~kept):,} rows without a number left out")
    words.append(
        "errors stated" if count == 3 else f"noise {error[0]:.3g} cd/m² by its differences"
    )
    return ObservedCurve(x, luminance, error, f"read {path.name}: {', '.join(words)}")


def _position_unit(path: Path, name: str, unit: str | None) -> str:
    """Return the unit of positions, stated by the column's name or by the user, not by both."""
    written = find_unit(name)
    found = unit or written
    if found is None:
        raise InputError(
            f"{path}: column 1 ({name or 'unnamed'}): no unit of position: expected mm, µm … in "
            "its name, or --unit"
        )
    if written not in (None, found):
        raise InputError(f"{path}: column 1 ({name}): {written}: expected {found}, as --unit says")
    return found


def noise_of(value: NDArray[np.float64]) -> float:
    """Return the standard deviation of white noise on a smooth curve (n,), by third differences."""
    third = np.diff(value, 3)
    # 1, -3, 3, -1: twenty variances; the median stands against steps and spikes.
    return float(np.median(np.abs(third)) / 0.6745 / np.sqrt(20))
