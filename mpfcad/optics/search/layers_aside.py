"""The strips of a section in layers, and from each cell the cells beside it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.search.grid.section import spread


class Strips(NamedTuple):
    """The parts of each of n strips, from the lowest to the highest, strip after strip.

    Attributes
    ----------
    lowest, highest
        (n,) int64, a part each
    strip, sign, turn
        (p,) int64, of each part: its strip; 1, or -1 where the film is above it; what its z is
        multiplied by
    width
        of the tile [mm]
    underside
        whether the lowest cells are of film
    """

    lowest: NDArray[np.int64]
    highest: NDArray[np.int64]
    strip: NDArray[np.int64]
    sign: NDArray[np.int64]
    turn: NDArray[np.int64]
    width: float
    underside: bool

    @classmethod
    def of(cls, strip, sign, turn, count, width, underside) -> "Strips | None":
        """Return the strips; None where one has no part, or film and air do not take turns."""
        parts = np.bincount(strip, minlength=count)
        highest = np.cumsum(parts) - 1
        lowest = highest - parts + 1
        layer = np.arange(len(strip)) - lowest[strip]
        expected = np.where((layer % 2 == 0) == underside, 1, -1)
        if not parts.all() or (sign != expected).any() or (sign[highest] < 0).any():
            return None
        return cls(lowest, highest, strip, sign, turn, width, underside)

    def beside(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the part below each part and that above it, or -1."""
        number = np.arange(len(self.strip))
        below = np.where(number == self.lowest[self.strip], -1, number - 1)
        return below, np.where(number == self.highest[self.strip], -1, number + 1)

    def across(self, lowest: NDArray, highest: NDArray) -> list[NDArray]:
        """Return of each part what `Layers.range` has last; of all their lowest and highest z."""
        below, above = self.beside()
        turned = self.turn < 0
        down = np.where(below < 0, lowest.min(), highest[below])
        up = np.where(above < 0, highest.max(), lowest[above])
        # From above, a part that is turned is a body in the way, and from below one that is not.
        below = below + 0.25 * (turned[below] & (below >= 0))
        above = above + 0.25 * ~(turned[above] | (above < 0))
        return [
            np.where(turned, -up, down), np.where(turned, -down, up),
            np.where(self.turn == self.sign, 1, 2) * self.turn,
            np.where(turned, above, below), np.where(turned, below, above),
        ]  # fmt: skip


def ways_aside(
    strips: Strips,
    edge: NDArray[np.float64],
    left: NDArray[np.float64],
    right: NDArray[np.float64],
    lowest: NDArray[np.float64],
    highest: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return `Layers.aside` for strips between x edge (n+1,) and their parts (p,) [mm].

    left, right, lowest, highest: heights of the ends of each part and of its extremes [mm].
    """
    count, parts = len(strips.lowest), len(strips.strip)
    # Cell i is below part i less its strip's number; each strip has one cell more, its highest.
    strip = np.sort(np.append(strips.strip, np.arange(count)))
    number = np.arange(len(strip))
    layer = number - (strips.lowest + np.arange(count))[strip]
    lower = np.where(layer == 0, -1, number - strip - 1)
    upper = np.where(number == (strips.highest + np.arange(count) + 1)[strip], -1, number - strip)
    film = (layer % 2 == 0) == strips.underside
    # A ray looks first where it goes, down or up.
    targets = np.where(lower < 0, upper, lower), np.where(upper < 0, lower, upper)
    free = np.where(lower < 0, lowest[upper], -np.inf), np.where(upper < 0, highest[lower], np.inf)
    rows: list[NDArray] = []
    more: list[NDArray] = []
    for way, here, there in ((-1, left, right), (1, right, left)):
        beside = (strip + way) % count
        turn = np.where((beside - strip) * way > 0, 0.0, way * strips.width)
        begin = (strips.lowest + np.arange(count))[beside]
        end = (strips.highest + np.arange(count))[beside] + 1
        a, b = spread(begin, end)
        bottom = np.maximum(_end(here, lower, a, -np.inf), _end(there, lower, b, -np.inf))
        top = np.minimum(_end(here, upper, a, np.inf), _end(there, upper, b, np.inf))
        gap = np.where(film[a] == film[b], bottom - top, np.inf)
        # The cells that go on there, or where a cell ends in a point the nearest of its kind.
        nearest = np.full(len(strip), np.inf)
        np.minimum.at(nearest, a, gap)
        goes = np.flatnonzero((gap < 0) | (gap == nearest[a]))
        taken = np.ones(len(goes), bool)
        point = gap[goes] >= 0
        taken[1:] = ~(point[1:] & point[:-1] & (a[goes][1:] == a[goes][:-1]))
        goes = goes[taken]
        ends = edge[beside + (way > 0)] + turn
        for target, clear in zip(targets, free, strict=True):
            base = 8 * parts + sum(map(len, more))
            a_, b_ = a[goes], b[goes]
            first, extra = _questions(a_, target[b_], bottom[goes], clear[b_], base)
            first[:, 3:5] = np.stack([turn, ends], axis=1)
            rows.append(first)
            more.append(extra)
    below, above = np.arange(parts) + strips.strip, np.arange(parts) + strips.strip + 1
    turned = strips.turn < 0
    over, under = np.where(turned, below, above), np.where(turned, above, below)
    order = [rows[2 * way + up][side] for up in (0, 1) for side in (over, under) for way in (0, 1)]
    return np.concatenate([np.stack(order, axis=1).reshape(-1, 8), *more])


def _end(height, part, cell, none):
    """Return the heights at which cells end, those of a part each, or `none` where they do not."""
    return np.where(part[cell] < 0, none, height[part[cell]])


def _questions(cell, target, bottom, clear, base):
    """Return rows of `Layers.aside`: the first of each cell (c, 8), and further ones (q, 8).

    cell, target, bottom, clear: of all ways out of cells, cell by cell from the lowest way up. The
    further rows have numbers from `base` on.
    """
    first = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.diff(np.append(first, len(cell)))
    place = np.arange(len(cell)) - np.repeat(first, count)
    left = np.repeat(count, count) - place
    one = left == 1
    # Ways 1, 2, … of a cell but the last have rows of their own.
    own = (place > 0) & (left > 1)
    number = base + np.cumsum(own) - 1

    def beyond(value):
        return np.where(one, value, np.append(value[1:], 0.0))

    above = np.where(left > 2, -1.0 - np.append(number[1:], 0), beyond(target))
    split = np.where(one, 0.0, beyond(bottom))
    none = 0.0 * split
    row = np.stack([target, split, above, none, none, clear, beyond(clear), none], axis=1)
    return row[first], row[own]
