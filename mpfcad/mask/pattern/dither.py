"""Error diffusion: equal dots, some cells open and some closed, so that their mean is the ratio.

Each groove is a row of cells that is gone through there and back in turn (serpentine). The error of
a cell goes on to the next of *its own groove*: resin levels along a groove, not over the tips, so a
weight to the neighbour (7/16 + 9/16 of Floyd and Steinberg) would only spoil the groove's mean. The
error stays below one dot, so any stretch of a groove is right to about a dot. What keeps dots of
neighbours apart is the threshold: higher beside a dot of the groove before, and a little random.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numba as nb
import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.aperture import Mask, blocks
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.pattern.ratio import CellRatio
from mpfcad.mask.rule import GRID
from mpfcad.store.kernel import kept

#: Share of the threshold that is random, and by how much a dot in the groove before raises it.
NOISE, REPULSION = 0.2, 0.3
#: Start of each groove's error: multiples of the golden section are as unlike as can be.
GOLDEN = (5**0.5 - 1) / 2


@dataclass(frozen=True, eq=False)
class DitherMask(Mask):
    """A mask of equal square dots in some of the cells.

    Attributes
    ----------
    ratio
        what each cell needs
    is_dot
        (n, ⌈m/8⌉) uint8, one bit a cell, first cell of a groove in the highest bit
    side
        of the dots [grid steps]
    cell_steps
        length of the cells along [grid steps]
    left
        (n,) int64, left edge of each groove's dots [grid steps]
    bottom
        lower edge of the dot in a groove's first cell [grid steps]
    """

    ratio: CellRatio
    is_dot: NDArray[np.uint8]
    side: int
    cell_steps: int
    left: NDArray[np.int64]
    bottom: int

    @property
    def period(self) -> float:
        """Length of the cells along the grooves as made [mm]."""
        return self.cell_steps * GRID

    @property
    def smallest_features(self) -> tuple[float | None, float | None]:
        """Side of the dots, and the web between two of neighbouring cells [mm]."""
        cell = min(round(self.pitch / GRID), self.cell_steps)
        return self.side * GRID, (cell - self.side) * GRID

    @property
    def cell_count(self) -> int:
        """Number of cells along a groove, m."""
        return self.ratio.cell_count

    def cells(self, first: int, count: int) -> NDArray[np.uint8]:
        """Return which cells of `count` grooves from `first` on hold a dot, (count, m) 0 or 1."""
        return np.unpackbits(self.is_dot[first : first + count], axis=1, count=self.cell_count)

    @property
    def arrays(self) -> Iterator[ApertureArray]:
        """One array a groove, made as one goes; its offsets are sorted along the groove."""
        for i in range(self.groove_count):
            cell = np.flatnonzero(self.cells(i, 1)[0])
            if not len(cell):
                continue
            offset = np.zeros((len(cell), 2), dtype=np.int64)
            np.multiply(cell, self.cell_steps, out=offset[:, 1])
            place = Placement((int(self.left[i]), self.bottom), offset=offset)
            yield ApertureArray((self.side, self.side), place)

    @cached_property
    def dot_count(self) -> NDArray[np.int64]:
        """Number of dots in each groove, (n,) int64."""
        return np.bitwise_count(self.is_dot).sum(axis=1, dtype=np.int64)

    @property
    def aperture_count(self) -> int:
        """Number of apertures in all."""
        return int(self.dot_count.sum())

    @property
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""
        area = self.dot_count * float(self.side * GRID) ** 2
        return np.asarray(area / (self.pitch * self.length), np.float64)

    @cached_property
    def wanted_ratio(self) -> NDArray[np.float64]:
        """Mean of the aperture ratio that each groove's cells need, (n,) float64."""
        return self.ratio.means()

    def open_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the ratio as drawn, integrated along from 0 to each position [mm]."""
        reach = np.clip((position / GRID - self.bottom) / self.cell_steps, 0, self.cell_count)
        low = np.minimum(reach.astype(np.int64), self.cell_count - 1)
        part = np.clip((reach - low) * self.cell_steps, 0, self.side)
        dots = self.cells(first, count)
        total = np.zeros((count, self.cell_count + 1), dtype=np.int64)
        np.cumsum(dots, axis=1, out=total[:, 1:])
        length = total[:, low] * self.side + part * dots[:, low]
        return length * (GRID * self.side * GRID / self.pitch)

    def wanted_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the wanted ratio, integrated like `open_length`."""
        return self.ratio.integral(first, count, position)


def dither(ratio: CellRatio, full: float) -> NDArray[np.uint8]:
    """Return which cells hold a dot, packed as in `DitherMask`; `full` is the ratio of all dots."""
    n = ratio.film.groove_count
    packed = np.empty((n, -(-ratio.cell_count // 8)), dtype=np.uint8)
    before = np.zeros(ratio.cell_count, dtype=np.uint8)
    for first, count in blocks(n):
        density = ratio.rows(first, count) / full
        dots = np.empty(density.shape, dtype=np.uint8)
        _diffuse(density, first, before, dots)
        before = dots[-1]
        packed[first : first + count] = np.packbits(dots, axis=1)
    return packed


@kept
@nb.njit(nogil=True)
def _diffuse(density, first, before, dots):
    count, m = density.shape
    for i in range(count):
        number = first + i
        error = (number * GOLDEN) % 1.0 - 0.5
        state = nb.uint64(number) * nb.uint64(0x9E3779B97F4A7C15) + nb.uint64(1)
        forward = number % 2 == 0
        for k in range(m):
            j = k if forward else m - 1 - k
            state = state * nb.uint64(6364136223846793005) + nb.uint64(1442695040888963407)
            random = (state >> nb.uint64(33)) / 2147483648.0 - 0.5
            beside = before[j] if i == 0 else dots[i - 1, j]
            value = density[i, j] + error
            threshold = 0.5 + NOISE * random + REPULSION * beside
            dots[i, j] = density[i, j] > 0 and value >= threshold
            error = value - dots[i, j]
