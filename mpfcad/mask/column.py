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

    def is_inside(self, left: int, bottom: int, right: int, top: int) -> bool:
        """Return whether all rectangles lie within a box [grid steps]."""
        return bool(
            np.all(self.left >= left)
            and np.all(self.right <= right)
            and np.all(self.bottom >= bottom)
            and np.all(self.top <= top)
        )


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
    # Columns on top of each other (an array that was split) are one column.
    stacked = (columns.left[1:] == columns.left[:-1]) & (columns.right[1:] == columns.right[:-1])
    gap = columns.bottom[1:] - columns.top[:-1]
    refuse(np.flatnonzero(stacked & (gap < 0)))
    webs.append(gap[stacked])
    # Column beside column.
    gap = (columns.left[1:] - columns.right[:-1])[~stacked]
    refuse(np.flatnonzero(~stacked)[gap < 0])
    start = np.concatenate([[0], np.flatnonzero(~stacked) + 1])
    bottom, height = columns.bottom[start], columns.height[start]
    neck = np.minimum((bottom + height)[1:], (bottom + height)[:-1]) - np.maximum(
        bottom[1:], bottom[:-1]
    )
    joined = (gap == 0) & (neck > 0)
    webs += [gap[gap > 0], -neck[(gap == 0) & ~joined]]
    run = np.concatenate([[0], np.flatnonzero(~joined) + 1])
    run_end = np.concatenate([run[1:], [len(start)]]) - 1
    across = columns.right[start][run_end] - columns.left[start][run]
    smallest = min(columns.height.min(), across.min(), neck[joined].min(initial=across.max()))
    web = np.concatenate(webs)
    return int(smallest), int(web.min()) if web.size else None
