"""A profile in a file's own numbers, before its units are known."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.tip import StylusTip


@dataclass(frozen=True, eq=False)
class RawProfile:
    """Heights over position as a file gives them.

    Attributes
    ----------
    position, height
        (n,) float64, in the units named, or in unknown ones (None)
    lines
        the file's line of each row; None where rows are not lines
    words
        what was understood, for the line that says so
    tip
        the stylus's, where the file states it
    strange
        columns that state a unit which is none of length, in words
    """

    position: NDArray[np.float64]
    height: NDArray[np.float64]
    position_unit: str | None
    height_unit: str | None
    lines: list[int] | None = None
    words: list[str] = field(default_factory=list)
    tip: StylusTip | None = None
    strange: str = ""


#: Beyond this no unit makes a place on a film of a number; squares of it can be added.
_LARGEST = 1e15


def tidy(path: Path, raw: RawProfile) -> RawProfile:
    """Return a profile of increasing positions: gaps dropped, reversed, equal ones averaged.

    Raises
    ------
    InputError
        when positions go back and forth, or a number is none of a surface.
    """
    x, z, words = raw.position, raw.height, list(raw.words)
    lines = raw.lines or list(range(1, len(x) + 1))
    kept = np.isfinite(x) & np.isfinite(z)
    if not kept.all():
        words.append(f"{np.count_nonzero(~kept)} rows without a number left out")
        lines = [line for line, keep in zip(lines, kept, strict=True) if keep]
        x, z = x[kept], z[kept]
    for name, value in (("position", x), ("height", z)):
        beyond = np.flatnonzero(np.abs(value) > _LARGEST)
        if beyond.size:
            i = int(beyond[0])
            raise InputError(
                f"{path}: row {lines[i]}: {name} {value[i]:.10g}: "
                f"expected a number of a surface, within ± {_LARGEST:g} in any unit"
            )
    if len(x) > 1 and np.count_nonzero(np.diff(x) < 0) > np.count_nonzero(np.diff(x) > 0):
        x, z, lines = x[::-1], z[::-1], lines[::-1]
        words.append("x from the right, turned")
    back = np.flatnonzero(np.diff(x) < 0)
    if back.size:
        i = int(back[0]) + 1
        raise InputError(
            f"{path}: row {lines[i]}: position {x[i]:.10g}: not increasing: "
            f"expected {x[i - 1]:.10g} of row {lines[i - 1]} or more"
        )
    first = np.flatnonzero(np.diff(x, prepend=-np.inf) > 0)
    if len(first) < len(x):
        words.append(f"{len(x)} rows, those of equal position averaged")
        count = np.diff(np.append(first, len(x)))
        z = np.add.reduceat(z, first) / count
        x, lines = x[first], [lines[i] for i in first]
    return replace(raw, position=x, height=z, lines=lines, words=words)
