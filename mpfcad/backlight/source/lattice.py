"""Where the LEDs of a board stand: lattices, lists, and how binning spreads them."""

import csv
import io
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import TEXT_LIMIT, guarded, named_file, reason_of
from mpfcad.errors import InputError

#: Places of a cell's LEDs in units of the pitches, and the cell's size in them.
LATTICES: dict[str, tuple[tuple[tuple[float, float], ...], tuple[float, float]]] = {
    "square": (((0.0, 0.0),), (1.0, 1.0)),
    "staggered": (((0.0, 0.0), (0.5, 1.0)), (1.0, 2.0)),
    "hexagonal": (((0.0, 0.0), (0.5, math.sqrt(3) / 2)), (1.0, math.sqrt(3))),
    "list": ((), (1.0, 1.0)),
}
_COLUMNS = ("x_mm", "y_mm", "flux_factor")


def read_positions(where: str, text: str) -> NDArray[np.float64]:
    """Return a list's (l, 3) float64: x, y [mm] in the cell, flux as a multiple.

    The CSV has a head of x_mm, y_mm and, if LEDs differ, flux_factor.

    Raises
    ------
    InputError
        naming the row and column.
    """
    with guarded(where, f"{','.join(_COLUMNS)} and rows of numbers"):
        rows = iter(list(csv.reader(io.StringIO(text, newline=None))))
    head = [name.strip() for name in next(rows, [])]
    if head not in (list(_COLUMNS), list(_COLUMNS[:2])):
        raise InputError(f"{where}: row 1: {','.join(head)}: expected {','.join(_COLUMNS)}")
    found = []
    for number, row in enumerate(rows, 2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(head):
            raise InputError(f"{where}: row {number}: {len(row)} values: expected {len(head)}")
        values = [_number(f"{where}: row {number}", *pair) for pair in zip(head, row, strict=True)]
        found.append(values if len(values) == len(_COLUMNS) else [*values, 1.0])
    if not found:
        raise InputError(f"{where}: no LED: expected one row each")
    led = np.array(found)
    if (led[:, 2] < 0).any() or not led[:, 2].any():
        raise InputError(f"{where}: flux_factor: expected 0 or more, and one LED that shines")
    return led


def _number(where: str, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {name}: {text.strip()}: expected a finite number")
    return value


def repeated(
    led: NDArray[np.float64], period: tuple[float, float], repeat: tuple[int, int]
) -> NDArray[np.float64]:
    """Return the LEDs (l, 3) of `repeat` cells together, those of one cell after another."""
    shift = [
        (i * period[0], k * period[1], 0.0) for i in range(repeat[0]) for k in range(repeat[1])
    ]
    return np.concatenate([led + np.array(step) for step in shift])


def binned(
    led: NDArray[np.float64], spread: float, error: float, dead: tuple[int, ...], seed: int
) -> NDArray[np.float64]:
    """Return LEDs as a board has them: flux and place with normal errors, some of them dead.

    spread: standard deviation of the flux over its mean; error: of x and y each [mm]; dead: numbers
    from 1. The draws are fixed by `seed`.
    """
    rng = np.random.Generator(np.random.Philox(seed))
    noise = rng.standard_normal(led.shape)
    made = led.copy()
    made[:, :2] += error * noise[:, :2]
    made[:, 2] *= np.maximum(0.0, 1.0 + spread * noise[:, 2])
    made[[number - 1 for number in dead], 2] = 0.0
    return made


def overlap(
    led: NDArray[np.float64], period: tuple[float, float], size: tuple[float, float]
) -> tuple[int, int] | None:
    """Return the numbers, from 1, of two LEDs that overlap (1, 1: in two cells), or None."""
    if size[0] >= period[0] or size[1] >= period[1]:
        return 1, 1
    return first_pair(led, period, lambda away: np.all(np.abs(away) < size, axis=1))


def first_pair(
    led: NDArray[np.float64],
    period: tuple[float, float],
    meet: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
) -> tuple[int, int] | None:
    """Return the numbers, from 1, of the first two LEDs that meet by their distance, or None.

    `meet` tells it of distances (k, 2) [mm] to the nearest of an LED's repeats.
    """
    for i in range(len(led)):
        away = led[i + 1 :, :2] - led[i, :2]
        away -= np.round(away / period) * period
        hit = np.flatnonzero(meet(away))
        if len(hit):
            return i + 1, i + 2 + int(hit[0])
    return None


def is_mirrored(led: NDArray[np.float64], period: tuple[float, float]) -> bool:
    """Return whether the LEDs are the same when mirrored at x = 0, and at y = 0."""
    places = [_folded(led * np.array(sign), period) for sign in ((1, 1, 1), (-1, 1, 1), (1, -1, 1))]
    return all(np.allclose(places[0], other, atol=1e-6) for other in places[1:])


def _folded(led: NDArray[np.float64], period: tuple[float, float]) -> NDArray[np.float64]:
    """Return LEDs with their places moved into one cell, in order."""
    folded = led.copy()
    folded[:, :2] = np.round(np.mod(led[:, :2] / period + 1e-9, 1.0), 7) * period
    return folded[np.lexsort(folded.T[::-1])]


def folder_text(where: str, folder: Path, name: object) -> str:
    """Return the text of a file beside a stack file.

    Raises
    ------
    InputError
        when it is not there or no text.
    """
    path = named_file(where, folder, str(name), "a text file there", TEXT_LIMIT)
    try:
        return path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{where}: {name}: {reason_of(error)}: expected a text file there"
        ) from None
