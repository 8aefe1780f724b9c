"""A map C(x, y) as a halftone: pieces of grooves that are bare, or printed with one curvature.

The share of printed pieces is p = (C_bare - C)/(C_bare - C_p), so that the mean of C is kept. Which
are printed is found by error diffusion across the grooves. The resin of a printed piece then levels
along its groove, so its ends are not sharp. That keeps the resin, not C: spread out, the same resin
covers more of the walls, and the mean of C falls.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.field.library import mirrored
from mpfcad.film.field.repeated import RepeatedField
from mpfcad.film.groove import Groove
from mpfcad.film.process.levelling import levelled_fill

#: Golden section: its multiples are as unlike as can be.
GOLDEN = (5**0.5 - 1) / 2
#: How far C of a map may lie outside the two curvatures [1/mm].
ROOM = 1e-9


@dataclass(frozen=True, eq=False)
class Halftone:
    """Pieces of the grooves of a cell, bare or printed alike.

    Attributes
    ----------
    groove
        the bare V groove
    curvature
        C [1/mm] of a printed piece before it levels
    tone
        (n, m) float64 [1/mm], the map that the pieces of each groove stand for
    printed
        (n, m) bool, which of them are printed
    side_by_side
        fewest grooves that are printed alike
    """

    groove: Groove
    curvature: float
    tone: NDArray[np.float64]
    printed: NDArray[np.bool_]
    side_by_side: int

    @property
    def share(self) -> float:
        """Share of the pieces that is printed."""
        return float(self.printed.mean())

    @property
    def fill(self) -> float:
        """Fill fraction of a printed piece before it levels."""
        return float(self.groove.fill_fraction(self.curvature))

    @property
    def two_level(self) -> NDArray[np.float64]:
        """C [1/mm] of each piece before it levels, (n, m)."""
        return np.where(self.printed, self.curvature, self.groove.curvature_empty)

    def levelled(
        self,
        length: float,
        parts: int,
        levelling: float,
        *,
        shift: tuple[float, float] = (0.0, 0.0),
        fill: float | None = None,
    ) -> NDArray[np.float64]:
        """Return C [1/mm] of each of `parts` of a piece once the resin has levelled, (n, m·parts).

        Resin is kept: C is that of a part's mean fill.

        Parameters
        ----------
        length
            of a piece [mm]
        parts
            of a piece
        levelling
            full width at half maximum [mm] of the Gauss curve of small differences from the fill of
            a printed piece
        shift
            of the print across and along the grooves [mm]. Resin that is printed over a tip falls
            into both grooves.
        fill
            of a printed piece; None: that of its curvature
        """
        whole, beside = divmod(shift[0] / self.groove.pitch, 1.0)
        row = np.roll(self.printed.astype(float), int(whole), axis=0)
        row = (1 - beside) * row + beside * np.roll(row, 1, axis=0)
        row *= self.fill if fill is None else fill
        found = levelled_fill(row, length, parts, levelling, self.fill, shift[1])
        curvature = self.groove.curvature_of_fill(np.clip(found, 0.0, 1.0))
        return np.minimum(curvature, self.groove.curvature_empty)


def build_halftone(
    groove: Groove, curvature: float, tone: NDArray[np.float64], side_by_side: int = 1
) -> Halftone:
    """Return the halftone of a map (n, m) [1/mm] of n grooves of m pieces each.

    So many grooves `side_by_side` are printed alike, or one more.

    Raises
    ------
    InputError
        when the map is not between the printed and the bare curvature.
    """
    bare = groove.curvature_empty
    low, high = float(tone.min()), float(tone.max())
    if low < curvature - ROOM or high > bare + ROOM:
        raise InputError(
            f"map: C {low:.4g} … {high:.4g} /mm over the cell: expected {curvature:g} … {bare:g}, "
            "from halftone.curvature_per_mm to bare prisms"
        )
    block = blocks_of(len(tone), side_by_side)
    width = np.bincount(block)
    total = np.add.reduceat(tone, np.cumsum(width) - width, axis=0)
    share = (bare - total / width[:, None]) / (bare - curvature)
    chosen = mirrored(np.clip(share, 0.0, 1.0), printed_blocks)
    return Halftone(groove, curvature, tone, chosen[block] == 1, int(width.min()))


def printed_blocks(share: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return which blocks are printed, (n, m) of 0 and 1, so that their share is kept.

    What a block leaves is handed on to the next across the grooves, there and back in turn, so that
    each row of pieces has its own share: the light of whole rows shows. Their thresholds follow the
    golden section, so that rows beside each other print at other places.
    """
    n, m = share.shape
    chosen = np.zeros((n, m), np.int64)
    left = 0.0
    for k in range(m):
        threshold = (0.5 + k * GOLDEN) % 1.0
        for i in range(n) if k % 2 == 0 else range(n - 1, -1, -1):
            left += share[i, k]
            some = share[i, k] > 0 and (left > threshold or share[i, k] >= 1)
            chosen[i, k] = int(some)
            left -= chosen[i, k]
    return chosen


def blocks_of(count: int, width: int) -> NDArray[np.int64]:
    """Return the number of the block of each of `count` grooves, (count,), its own mirror image.

    Blocks are `width` grooves wide or more, by as little as goes; there is one at least.

    Examples
    --------
    >>> blocks_of(10, 3)
    array([0, 0, 0, 1, 1, 1, 1, 2, 2, 2])
    """
    number = max(1, count // width)
    if count % 2 and number % 2 == 0:
        number -= 1  # the groove in the middle is in the block in the middle
    grooves = np.full(number, count // number)
    more = count % number
    grooves[number // 2] += more % 2
    wider = ((np.arange(more // 2) + 0.5) * (number // 2) / max(more // 2, 1)).astype(np.int64)
    grooves[wider] += 1
    grooves[number - 1 - wider] += 1
    return np.repeat(np.arange(number), grooves)


@dataclass(frozen=True, eq=False)
class HalftoneField(RepeatedField):
    """The pieces of a halftone over the panel as printed, with sharp ends; `cell` is `two_level`.

    Attributes
    ----------
    halftone
        the pieces of one cell
    """

    halftone: Halftone

    @property
    def stored(self) -> tuple[NDArray[np.float64], ...]:
        """What its file holds: the map, of which the pieces are found again."""
        across, along, _ = super().stored
        return across, along, self.halftone.tone.T

    def at(self, across: ArrayLike, along: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at points [mm], that of the piece."""
        x, y = np.broadcast_arrays(np.asarray(across, float), np.asarray(along, float))
        groove = np.floor(x / self.pitch + 1e-9).astype(np.int64)
        piece = np.floor((y - self.start) / self.piece + 1e-9).astype(np.int64)
        n, m = self.cell.shape
        return self.cell[np.mod(groove - self.first, n), np.mod(piece, m)]

    def printed_pieces(self) -> tuple[float, NDArray[np.bool_]]:
        """Return y [mm] of the first whole piece on the panel, and which of them are printed.

        (grooves of the panel, k) bool. A piece that the panel's edge cuts is none of them.
        """
        low = int(np.ceil(-self.start / self.piece - 1e-9))
        high = int(np.floor((self.length - self.start) / self.piece + 1e-9))
        printed = self.halftone.printed
        n, m = printed.shape
        rows = printed[np.mod(np.arange(self.groove_count) - self.first, n)]
        return self.start + low * self.piece, rows[:, np.mod(np.arange(low, high), m)]
