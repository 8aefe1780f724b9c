"""Zones of a board: the LEDs of each are dimmed together."""

import csv
import io
import math
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.lattice import folder_text
from mpfcad.errors import InputError

_COLUMNS = ("left_mm", "right_mm", "bottom_mm", "top_mm")
_MOST = 100_000
#: Of a CSV: which zones touch is asked of each pair.
_MOST_ROWS = 4096
_NEAR = 1e-6


@dataclass(frozen=True)
class ZoneSpec:
    """What a stack file says of zones.

    Attributes
    ----------
    count
        how many across and along, all equal; None where they are listed
    edge
        rectangles on the panel [mm]: left, right, bottom, top
    """

    count: tuple[int, int] | None = None
    edge: tuple[tuple[float, ...], ...] = ()

    @classmethod
    def restore(cls, document: Any) -> "ZoneSpec | None":
        """Return what was described; None of nothing."""
        if document is None:
            return None
        count = document["count"]
        return cls(count and (count[0], count[1]), tuple(map(tuple, document["edge_mm"])))

    def describe(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {"count": self.count and list(self.count), "edge_mm": [list(e) for e in self.edge]}

    @property
    def words(self) -> str:
        """It in words."""
        return " × ".join(map(str, self.count)) if self.count else f"{len(self.edge)} rectangles"


def read_zones(where: str, folder: Path, entry: object) -> ZoneSpec:
    """Return what `source.zones` states: [across, along], or the rows of a CSV beside `folder`.

    Raises
    ------
    InputError
        naming the row or value and what is expected.
    """
    if isinstance(entry, list):
        good = len(entry) == 2 and all(type(n) is int and n >= 1 for n in entry)
        if not good or entry[0] * entry[1] > _MOST:
            raise InputError(
                f"{where}: {entry}: expected [across, along], whole numbers from 1, at most "
                f"{_MOST} zones"
            )
        return ZoneSpec((entry[0], entry[1]))
    if not isinstance(entry, str):
        raise InputError(f"{where}: {entry!r}: expected [across, along] or a CSV's name")
    return ZoneSpec(edge=_read_rows(f"{where}: {entry}", folder_text(where, folder, entry)))


def _read_rows(where: str, text: str) -> tuple[tuple[float, ...], ...]:
    rows = csv.reader(io.StringIO(text))
    head = [name.strip() for name in next(rows, [])]
    if head != list(_COLUMNS):
        raise InputError(f"{where}: row 1: {','.join(head)}: expected {','.join(_COLUMNS)}")
    found = []
    for number, row in enumerate(rows, 2):
        if not any(cell.strip() for cell in row):
            continue
        try:
            values = tuple(float(cell) for cell in row)
        except ValueError:
            values = ()
        good = len(values) == len(_COLUMNS) and all(map(math.isfinite, values))
        if not good or values[0] >= values[1] or values[2] >= values[3]:
            raise InputError(
                f"{where}: row {number}: {','.join(row)[:60]}: expected four numbers, left_mm "
                "below right_mm and bottom_mm below top_mm"
            )
        found.append(values)
    if not 1 <= len(found) <= _MOST_ROWS:
        raise InputError(f"{where}: {len(found)} rows: expected 1 … {_MOST_ROWS} zones")
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Zones:
    """The zones of a panel.

    Attributes
    ----------
    edge
        (z, 4) float64 [mm] on the panel: left, right, bottom, top
    colour
        (z,) int64, 0 and 1 as on a checkerboard; None where no two colours do
    number
        (l, a, b) int64, the zone of LED l of the panel's cell (a, b)
    middle
        number of the zone nearest to the panel's middle
    """

    edge: NDArray[np.float64]
    colour: NDArray[np.int64] | None
    number: NDArray[np.int64]
    middle: int

    @property
    def leds(self) -> int:
        """LEDs of the middle zone."""
        return int((self.number == self.middle).sum())


def lay_zones(
    where: str,
    spec: ZoneSpec,
    led: NDArray[np.float64],
    panel: tuple[float, float],
    lit: tuple[float, float],
) -> Zones:
    """Return the zones of a panel.

    Parameters
    ----------
    led
        (l, a, b, 2) float64 [mm], places on the panel of LED l of cell (a, b)
    panel, lit
        size [mm] of the panel, and of what its whole cells light, about its middle

    Raises
    ------
    InputError
        when an LED is in no zone or in two, or a zone has no LED.
    """
    colour: NDArray[np.int64] | None
    if spec.count is not None:
        edge, colour = _even(spec.count, panel, lit)
        number = _even_number(edge, led, np.array(spec.count))
    else:
        edge = np.array(spec.edge, np.float64)
        colour, number = _coloured(edge), _listed_number(where, edge, led)
    empty = np.flatnonzero(np.bincount(number.ravel(), minlength=len(edge)) == 0)
    if len(empty):
        raise InputError(f"{where}: zone {empty[0] + 1}: no LED in it: expected one or more")
    centre = np.stack([edge[:, :2].mean(axis=1), edge[:, 2:].mean(axis=1)], axis=1)
    away = np.hypot(*(centre - np.array(panel) / 2).T)
    return Zones(edge, colour, number, int(np.argmin(np.round(away, 6))))


def _even(
    count: tuple[int, int], panel: tuple[float, float], lit: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return edges and colours of equal zones, those along y of one column after another."""
    x, y = (
        p / 2 + (np.arange(n + 1) / n - 0.5) * size
        for n, p, size in zip(count, panel, lit, strict=True)
    )
    i, k = (part.ravel() for part in np.meshgrid(*map(np.arange, count), indexing="ij"))
    return np.stack([x[i], x[i + 1], y[k], y[k + 1]], axis=1), (i + k) % 2


def _even_number(
    edge: NDArray[np.float64], led: NDArray[np.float64], count: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the zone of each LED among equal ones; of one on an edge the next."""
    low, high = edge[:, [0, 2]].min(axis=0), edge[:, [1, 3]].max(axis=0)
    place = np.floor((led - low) / (high - low) * count + _NEAR).astype(np.int64)
    place = np.clip(place, 0, count - 1)
    return np.asarray(place[..., 0] * count[1] + place[..., 1])


def _listed_number(
    where: str, edge: NDArray[np.float64], led: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the zone of each LED among rectangles."""
    flat = led.reshape(-1, 2)
    number = np.empty(len(flat), np.int64)
    for i, (x, y) in enumerate(flat):
        across, along = (edge[:, 0] <= x) & (x < edge[:, 1]), (edge[:, 2] <= y) & (y < edge[:, 3])
        inside = np.flatnonzero(across & along)
        if len(inside) != 1:
            what = "no zone" if not len(inside) else f"zones {inside[0] + 1} and {inside[1] + 1}"
            raise InputError(
                f"{where}: the LED at {x:.4g}, {y:.4g} mm on the panel is in {what}: expected one"
            )
        number[i] = inside[0]
    return number.reshape(led.shape[:-1])


def _coloured(edge: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Return colours 0 and 1 such that zones which share a side differ; None where none do."""
    left, right, bottom, top = edge.T
    beside = np.abs(right[:, None] - left[None]) < _NEAR
    above = np.abs(top[:, None] - bottom[None]) < _NEAR
    x = np.minimum(right[:, None], right) - np.maximum(left[:, None], left) > _NEAR
    y = np.minimum(top[:, None], top) - np.maximum(bottom[:, None], bottom) > _NEAR
    touch = ((beside | beside.T) & y) | ((above | above.T) & x)
    colour = np.full(len(edge), -1)
    for start in range(len(edge)):
        waiting = deque([start] if colour[start] < 0 else [])
        colour[start] = max(colour[start], 0)
        while waiting:
            one = waiting.popleft()
            for other in np.flatnonzero(touch[one]):
                if colour[other] == colour[one]:
                    return None
                if colour[other] < 0:
                    colour[other] = 1 - colour[one]
                    waiting.append(int(other))
    return colour
