"""What zones that are dimmed by themselves do: halo, single block, checkerboard.

Patterns and terms are those of IEC 62595-2-1:2016, "Measurement methods of block-wise BLUs": the
checkerboard, the single white and the single black block, and the incoherent point spread function
of a block. Luminances of LEDs that shine together add up, so each pattern is a sum of the LEDs'
maps. The board goes on beyond the panel's edge as its own mirror image, as white walls make it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.zone import Zones
from mpfcad.measure.cell.spread import SpreadResult, ratio_of
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.uniformity import METERS, SCREEN_POINTS, uniformity

#: Zones on either side of the block over which its profile is given.
_ZONES_BESIDE = 2
Range = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Profile:
    """The luminance of the block alone, along a line through its middle.

    Attributes
    ----------
    place
        (n,) float64 [mm] from the block's middle
    luminance, standard_error
        (n,) float64 [cd/m²]
    """

    place: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BlockResult:
    """The zone in the panel's middle: what it does alone, dark, and on a checkerboard.

    Attributes
    ----------
    edge
        of the block [mm] on the panel: left, right, bottom, top
    leds, zones
        LEDs of the block; zones of the panel
    halo
        light that leaves outside the block over light inside, while it shines alone
    white, black
        luminance in the block while it alone shines, and while it alone is dark, over that while
        all shine
    contrast
        of both: white over black
    checkerboard
        luminance in the block while the zones of its colour shine, over that while the others do;
        None where the zones are no checkerboard
        All are None where there is no light to divide by
    even
        Lmin/Lmax on 9 points of the block: alone white, and while all shine
    across, along
        profiles of the block alone
    """

    edge: NDArray[np.float64]
    leds: int
    zones: int
    halo: Estimate | None
    white: Estimate | None
    black: Estimate | None
    contrast: Estimate | None
    checkerboard: Estimate | None
    even: tuple[Estimate, Estimate]
    across: Profile
    along: Profile


def block_figures(spread: SpreadResult, board: Any, seed: int) -> BlockResult | None:
    """Return what the zone in the panel's middle does; None of a source without zones.

    `board` is the source of the stack that `spread` was traced in.
    """
    zones: Zones | None = getattr(board, "zones", None)
    if zones is None:
        return None
    patterns = _Patterns(spread, board, zones)
    edge = patterns.edge
    own = zones.number == zones.middle
    cells = patterns.cells(edge)
    white, whole = patterns.luminance(own, *cells), patterns.luminance(np.ones_like(own), *cells)
    inside = patterns.inside(*cells)
    alone, all_lit = white[:, inside].mean(axis=1), whole[:, inside].mean(axis=1)
    light = spread.batch.sum(axis=(2, 3, 4, 5)) @ own.sum(axis=(1, 2)).astype(float)
    light /= 1 - spread.beside
    within = white[:, inside].sum(axis=1)
    board_of = None
    if zones.colour is not None and len(zones.edge) > 1:
        same = zones.colour[zones.number] == zones.colour[zones.middle]
        bright = patterns.luminance(same, *cells)[:, inside].mean(axis=1)
        board_of = ratio_of(bright, all_lit - bright)
    return BlockResult(
        edge, zones.leds, len(zones.edge), ratio_of(light - within, within),
        ratio_of(alone, all_lit), ratio_of(all_lit - alone, all_lit),
        ratio_of(alone, all_lit - alone), board_of,
        (patterns.evenness(white, cells, seed), patterns.evenness(whole, cells, seed)),
        patterns.profile(own, 0), patterns.profile(own, 1),
    )  # fmt: skip


class _Patterns:
    """Luminance of zones that shine together, over any of the panel's cells."""

    def __init__(self, spread: SpreadResult, board: Any, zones: Zones) -> None:
        self._spread, self._zones = spread, zones
        self._count = board.cells
        size = np.array(spread.size)
        first = np.array([-((n - 1) // 2) for n in self._count])
        #: Left lower corner [mm] of cell (0, 0) on the panel.
        self._corner = np.array(board.origin) + (first - 0.5) * size
        self.edge = zones.edge[zones.middle]

    def cells(self, edge: NDArray[np.float64]) -> tuple[Range, Range]:
        """Return the first cell and the one after the last that a rectangle [mm] reaches into."""
        found = []
        for axis, (low, high) in enumerate((edge[:2], edge[2:])):
            size, corner = self._spread.size[axis], self._corner[axis]
            first = int(np.floor((low - corner) / size + 1e-6))
            found.append((first, int(np.ceil((high - corner) / size - 1e-6))))
        return found[0], found[1]

    def place(self, axis: int, cells: Range) -> NDArray[np.float64]:
        """Return the middles [mm] on the panel of the bins of cells."""
        bins = self._spread.bins
        number = (np.arange((cells[1] - cells[0]) * bins) + 0.5) / bins + cells[0]
        return np.asarray(self._corner[axis] + number * self._spread.size[axis])

    def inside(self, across: Range, along: Range) -> NDArray[np.bool_]:
        """Return which bins of cells lie in the block."""
        left, right, bottom, top = self.edge
        x, y = self.place(0, across), self.place(1, along)
        return np.outer((left <= x) & (x < right), (bottom <= y) & (y < top))

    def luminance(self, lit: NDArray[np.bool_], across: Range, along: Range) -> NDArray[np.float64]:
        """Return the luminance (g, n, m) [cd/m²] over cells of LEDs `lit` (l, a, b)."""
        spread, reach = self._spread, self._spread.reach
        n, m, b = across[1] - across[0], along[1] - along[0], spread.bins
        found = np.zeros((len(spread.batch), n, b, m, b))
        i, k = np.arange(*across), np.arange(*along)
        for p in range(2 * reach + 1):
            rows = _mirrored(i - p + reach, self._count[0])
            for q in range(2 * reach + 1):
                drive = lit[:, rows][:, :, _mirrored(k - q + reach, self._count[1])]
                for led in np.flatnonzero(drive.any(axis=(1, 2))):
                    part = spread.batch[:, led, p, :, q]
                    found += part[:, None, :, None] * drive[led][None, :, None, :, None]
        haze = spread.haze() * lit.mean()
        return found.reshape(len(found), n * b, m * b) + haze[:, None, None]

    def evenness(
        self, luminance: NDArray[np.float64], cells: tuple[Range, Range], seed: int
    ) -> Estimate:
        """Return Lmin/Lmax on 9 points of the block, each the four bins about it."""
        left, right, bottom, top = self.edge
        point = []
        for u, v in SCREEN_POINTS[list(METERS[9])]:
            x, y = left + u * (right - left), bottom + v * (top - bottom)
            i, k = _two(self.place(0, cells[0]), x), _two(self.place(1, cells[1]), y)
            point.append(luminance[:, i][:, :, k].mean(axis=(1, 2)))
        value = np.mean(point, axis=1)
        error = np.std(point, axis=1, ddof=1) / np.sqrt(len(luminance))
        return uniformity(value, error, float(len(luminance)), seed)

    def profile(self, lit: NDArray[np.bool_], axis: int) -> Profile:
        """Return the luminance along a line through the block's middle."""
        edge = self.edge.reshape(2, 2)
        middle, half = edge.mean(axis=1), np.diff(edge, axis=1)[:, 0] / 2
        wide = np.array(self._spread.size)
        wide[axis] = (1 + 2 * _ZONES_BESIDE) * half[axis]
        found = self.cells(np.stack([middle - wide, middle + wide], axis=1).ravel())
        cells = [(max(a, 0), min(b, n)) for (a, b), n in zip(found, self._count, strict=True)]
        value = self.luminance(lit, cells[0], cells[1])
        other = _two(self.place(1 - axis, cells[1 - axis]), middle[1 - axis])
        line = value.take(other, axis=2 - axis).mean(axis=2 - axis)
        error = line.std(axis=0, ddof=1) / np.sqrt(len(line))
        return Profile(self.place(axis, cells[axis]) - middle[axis], line.mean(axis=0), error)


def _two(place: NDArray[np.float64], at: float) -> NDArray[np.int64]:
    """Return the numbers of the two places that are nearest to one."""
    return np.sort(np.argsort(np.abs(place - at), kind="stable")[:2])


def _mirrored(cell: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return cells of a panel that goes on as its own mirror image."""
    folded = cell % (2 * count)
    return np.where(folded < count, folded, 2 * count - 1 - folded)
