"""Columns of equal rectangles, as read from a mask file: area a groove, apertures, webs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of rectangles along y, sorted by left, right, bottom; all (m,) int64 [grid steps].

    Attributes
    ----------
    left, right
        extent of each column across
    bottom
        of each column's first rectangle
    height
        of each column's rectangles
    step, count
        distance and number of each column's rectangles; step 0 for a single one
    """

    left: NDArray[np.int64]
    right: NDArray[np.int64]
    bottom: NDArray[np.int64]
    height: NDArray[np.int64]
    step: NDArray[np.int64]
    count: NDArray[np.int64]

    @classmethod
    def build(cls, arrays: list[tuple[int, ...]]) -> "Columns":
        """Return the columns of arrays (left, bottom, width, height, nx, step x, ny, step y)."""
        table = np.array(arrays, dtype=np.int64).reshape(-1, 8)
        repeats = table[:, 4]
        table = np.repeat(table, repeats, axis=0)
        number = np.arange(len(table)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
        left = table[:, 0] + number * table[:, 5]
        right, bottom = left + table[:, 2], table[:, 1]
        order = np.lexsort((bottom, right, left))
        columns = (left, right, bottom, table[:, 3], table[:, 7], table[:, 6])
        return cls(*(column[order] for column in columns))

    @property
    def aperture_count(self) -> int:
        """Number of rectangles."""
        return int(self.count.sum())

    @property
    def top(self) -> NDArray[np.int64]:
        """Upper edge of each column's last rectangle, (m,) int64 [grid steps]."""
        return self.bottom + (self.count - 1) * self.step + self.height


def column_area(columns: Columns, edge: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the open area over each groove, (n,) int64 [grid steps²], between the tips `edge`."""
    area = np.zeros(len(edge) - 1, dtype=np.int64)
    first = np.searchsorted(edge, columns.left, side="right") - 1
    last = np.searchsorted(edge, columns.right, side="left") - 1
    open_length = columns.height * columns.count
    for k in range(int((last - first).max(initial=-1)) + 1):
        groove = np.minimum(first + k, last)
        overlap = np.minimum(columns.right, edge[groove + 1]) - np.maximum(
            columns.left, edge[groove]
        )
        np.add.at(area, groove, np.where(first + k <= last, overlap * open_length, 0))
    return area


def measure_webs(path: str, columns: Columns, pitch: float) -> tuple[int | None, int | None]:
    """Return the smallest aperture and the smallest web [grid steps], None where there is none.

    Columns that touch are one opening where their rectangles overlap along y.

    Raises
    ------
    ExportError
        when rectangles overlap; the groove is named from `pitch` [grid steps].
    """
    if not len(columns.left):
        return None, None

    def refuse(bad: NDArray[np.int64]) -> None:
        if bad.size:
            groove = int(columns.left[bad[0]] // pitch)
            raise ExportError(f"{path}: groove {groove} (counted from 0): apertures overlap")

    many = columns.count > 1
    webs = [(columns.step - columns.height)[many]]
    refuse(np.flatnonzero(many & (columns.step < columns.height)))
    columns = _unravel(columns)
    # Columns over each other across are one strip; in it they stand on top of each other.
    reach = np.maximum.accumulate(columns.right)
    strip = np.concatenate([[0], np.cumsum(columns.left[1:] >= reach[:-1])])
    order = np.lexsort((columns.bottom, strip))
    strip, bottom, top = strip[order], columns.bottom[order], columns.top[order]
    stacked = strip[1:] == strip[:-1]
    gap = bottom[1:] - top[:-1]
    refuse(order[1:][stacked & (gap < 0)])
    webs.append(gap[stacked])
    start = np.concatenate([[0], np.flatnonzero(~stacked) + 1])
    left = np.minimum.reduceat(columns.left[order], start)
    right = np.maximum.reduceat(columns.right[order], start)
    width = np.minimum.reduceat((columns.right - columns.left)[order], start)
    # Strip beside strip: joined where their first rectangles meet.
    gap = left[1:] - right[:-1]
    bottom, height = bottom[start], columns.height[order][start]
    neck = np.minimum((bottom + height)[1:], (bottom + height)[:-1]) - np.maximum(
        bottom[1:], bottom[:-1]
    )
    joined = (gap == 0) & (neck > 0)
    webs += [gap[gap > 0], -neck[(gap == 0) & ~joined]]
    run = np.concatenate([[0], np.flatnonzero(~joined) + 1])
    run_end = np.concatenate([run[1:], [len(start)]]) - 1
    across = np.where(run == run_end, width[run], right[run_end] - left[run])
    smallest = min(columns.height.min(), across.min(), neck[joined].min(initial=across.max()))
    web = np.concatenate(webs)
    return int(smallest), int(web.min()) if web.size else None


def _unravel(columns: Columns) -> Columns:
    """Return the columns with those that stand between each other's rectangles taken apart."""
    same = (columns.left[1:] < columns.right[:-1]) & (columns.bottom[1:] < columns.top[:-1])
    same &= (columns.left[1:] == columns.left[:-1]) & (columns.right[1:] == columns.right[:-1])
    same &= columns.bottom[1:] >= columns.bottom[:-1] + columns.height[:-1]
    tangled = np.isin(columns.left, columns.left[1:][same]) & (columns.count > 1)
    if not tangled.any():
        return columns
    table = (columns.left, columns.right, columns.bottom, columns.height, columns.step)
    count = np.where(tangled, columns.count, 1)
    left, right, bottom, height, step = (np.repeat(values, count) for values in table)
    number = np.arange(len(left)) - np.repeat(np.cumsum(count) - count, count)
    bottom = bottom + number * step
    loose = np.repeat(tangled, count)
    kept = np.repeat(columns.count, count)
    order = np.lexsort((bottom, right, left))
    step, kept = np.where(loose, 0, step), np.where(loose, 1, kept)
    return Columns(*(v[order] for v in (left, right, bottom, height, step, kept)))
