"""How the layers of a cross-section are found: leaned, cut into runs, pieces, strips, parts."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.search.chain import cells, parabolas
from mpfcad.optics.search.grid.section import spread
from mpfcad.optics.search.layers import NO_LAYERS, Layers
from mpfcad.optics.search.layers_aside import Strips, ways_aside

#: Leans that are tried: the first with which no segment is steep, or the best.
_LEANS = (0.0, *(s * t for t in (0.2, 0.45, 0.8, 1.3, 2.0, 3.0) for s in (1, -1)))
_STEEP = 0.03
#: How near to each other places count as one, in units of the width: some rounding.
_SAME = 32 * 2.3e-16
#: The least band that is used, in units of the section's height; how far from its ends a ray has to
#: be, in units of the band, so that no vertex is where it comes in.
_BAND, _WITHIN = 0.1, 1e-3


class _Line(NamedTuple):
    """Segments from left to right, leaned.

    x, z: (s, 2) [mm], of both ends; the left one is in the tile, `around` are the tiles from there
    to the right one. sign: 1, or -1 where the film is above; turn: what z is multiplied by.
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    around: NDArray[np.int64]
    sign: NDArray[np.int64]
    turn: NDArray[np.int64]

    def slope(self, width: float) -> NDArray[np.float64]:
        return (self.z[:, 1] - self.z[:, 0]) / (self.x[:, 1] + self.around * width - self.x[:, 0])


def layers_of(segment: NDArray[np.float64], width: float, underside: bool) -> Layers:
    """Return the layers of segments (s, 4): x, z of start and end [mm], the film on the right.

    They are without parts where the section has none somewhere, or is not one of solids.
    """
    lean = _lean(segment)
    line, before = _leaned(segment, width, lean)
    run = before
    while (run != run[run]).any():
        run = run[run]
    last = np.ones(len(run), bool)
    last[before[before != np.arange(len(run))]] = False
    ends = np.concatenate([[0.0], line.x[before == np.arange(len(run)), 0], line.x[last, 1]])
    cut = np.unique(ends)
    piece, parent, k = _pieces(line, cut, width)
    strip, sign = k % len(cut), line.sign[parent]
    slope = line.slope(width)[parent]
    edge = np.append(cut, width)
    # From the bottom to the top by the height over a strip's middle, which one piece of each has.
    middle = ((edge[:-1] + edge[1:]) / 2)[strip]
    over = np.flatnonzero((piece[:, 0] <= middle) & (middle < piece[:, 2]))
    height = piece[over, 1] + slope[over] * (middle[over] - piece[over, 0])
    over = over[np.lexsort([height, strip[over]])]
    turn = line.turn[parent]
    strips = Strips.of(strip[over], sign[over], turn[over], len(cut), width, underside)
    names, name = np.unique(run[parent] * (k.max() + 1) + k, return_inverse=True)
    if strips is None or len(names) != len(over):
        return NO_LAYERS
    number = np.empty(len(names), np.int64)
    number[name[over]] = np.arange(len(over))
    part = number[name]
    order = np.lexsort([piece[:, 0], part])
    piece, slope, turn, part = piece[order], slope[order], turn[order], part[order]
    first = np.flatnonzero(np.diff(part, prepend=-1))
    last = np.append(first[1:], len(part)) - 1
    lowest = np.minimum.reduceat(piece[:, 1::2].min(axis=1), first)
    highest = np.maximum.reduceat(piece[:, 1::2].max(axis=1), first)
    across = strips.across(lowest, highest)
    band, under = _band(strips, lowest, highest)
    aside = ways_aside(strips, edge, piece[first, 1], piece[last, 3], lowest, highest)
    piece[:, 1::2] *= turn[:, None]
    slope = slope * turn
    share = 1 / np.hypot(slope, 1 - lean * turn * slope)
    sides = [np.append(0.0, slope[:-1]), np.append(slope[1:], 0.0)]
    # The vertices of a part, then those of the next.
    vertex = np.insert(piece[:, :2], last + 1, piece[last, 2:], axis=0)
    count = np.arange(len(first))
    x, z = vertex.T
    rows, start = parabolas(x, z, first + count, last + 1 + count)
    return Layers(
        np.stack([*piece.T, slope, share, *sides], axis=1),
        rows,
        np.stack([first, last, start - count, *across], axis=1).astype(float),
        aside,
        _entries(edge, strips, under),
        np.stack([np.append(cut[1:], np.inf), strips.lowest, strips.highest, under], axis=1),
        np.array([lean, *band]),
    )


def _band(strips, lowest, highest):
    """Return the z range [mm] that is free of parts, and the highest part below it a strip."""
    order = np.argsort(lowest)
    # How high all parts reach up to each, and how far above that the next one begins.
    reach = np.maximum.accumulate(highest[order])[:-1]
    gap = lowest[order][1:] - reach
    zone = highest.max() - lowest.min()
    if len(gap) == 0 or gap.max() < _BAND * zone:
        return (np.inf, -np.inf), strips.lowest
    low = reach[np.argmax(gap)]
    below = np.bincount(strips.strip, highest <= low, len(strips.lowest)).astype(int)
    margin = _WITHIN * gap.max()
    if not below.all() or (strips.lowest + below > strips.highest).any():
        return (np.inf, -np.inf), strips.lowest
    return (low + margin, low + gap.max() - margin), strips.lowest + below - 1


def _lean(segment: NDArray[np.float64]) -> float:
    """Return by how much to lean a section over, so that no segment of it is steep."""
    dx, dz = (segment[:, 2:] - segment[:, :2]).T
    least = [np.abs((dx + lean * dz) / np.hypot(dx, dz)).min() for lean in _LEANS]
    steep = np.array(least) < _STEEP
    return _LEANS[int(np.argmax(least) if steep.all() else np.argmin(steep))]


def _leaned(segment, width, lean):
    """Return the segments leaned, and before each the one whose run it goes on, or itself."""
    point = segment.reshape(-1, 2).copy()
    point[point[:, 0] >= width, 0] -= width
    vertex, number = np.unique(point[:, 0] + 1j * point[:, 1], return_inverse=True)
    number = number.reshape(-1, 2)
    x = vertex.real + lean * vertex.imag
    x -= np.floor(x / width) * width
    x = _as_one(x, width)
    ends = segment[:, ::2] + lean * segment[:, 1::2]
    leftward = ends[:, 1] < ends[:, 0]
    swap = np.where(leftward[:, None], [1, 0], [0, 1])
    number, ends = (np.take_along_axis(v, swap, axis=1) for v in (number, ends))
    step = ends[:, 1] - ends[:, 0] - (x[number[:, 1]] - x[number[:, 0]])
    sign = np.where(leftward, -1, 1)
    around = np.round(step / width).astype(np.int64)
    line = _Line(x[number], vertex.imag[number], around, sign, sign)
    before, hill = _before(line, number, line.slope(width))
    return line._replace(turn=np.where(hill, -sign, sign)), before


def _as_one(x, width):
    """Return places [mm], of those that are one but for rounding the same for all."""
    order = np.argsort(x, kind="stable")
    group = np.cumsum(np.diff(x[order], prepend=x[order[0]]) > _SAME * width)
    first = np.flatnonzero(np.diff(group, prepend=-1))
    out = np.empty(len(x))
    out[order] = x[order][first][group]
    return np.where(out > width * (1 - _SAME), 0.0, out)


def _before(line, number, slope):
    """Return the segment to the left of each in its run, or its own number; and which are hills.

    A run bends towards the air, or it is a hill of film. Of a segment that both could have, the
    first has it.
    """
    own = np.arange(len(number))
    times = np.bincount(number.ravel())
    ending = np.full(len(times), -1)
    ending[number[:, 1]] = own
    left = ending[number[:, 0]]
    bend = (slope - slope[left]) * line.sign
    # A run ends at the side of the tile, else it might have no end.
    on = (left >= 0) & (times[number[:, 0]] == 2) & (line.around[left] == 0)
    on &= line.sign == line.sign[left]
    room = on & (bend >= 0)
    taken = room.copy()
    taken[left[room]] = True
    hill = on & (bend < 0) & ~taken & ~taken[left]
    of_hill = hill.copy()
    of_hill[left[hill]] = True
    return np.where(room | hill, left, own), of_hill


def _pieces(line, cut, width):
    """Return (pieces (q, 4): x, z of both ends in the tile [mm], their segments, their strips).

    Strips are counted on beyond the tile.
    """
    count = len(cut)
    begin = np.searchsorted(cut, line.x[:, 0], side="right") - 1
    end = count * line.around + np.searchsorted(cut, line.x[:, 1], side="left") - 1
    parent, k = spread(begin, end)
    x, z, slope = line.x[parent], line.z[parent], line.slope(width)[parent]

    def at(k):
        return cut[k % count] + width * (k // count)

    def height(k):
        return np.clip(z[:, 0] + slope * (at(k) - x[:, 0]), z.min(axis=1), z.max(axis=1))

    starts, ends = k == begin[parent], k == end[parent]
    edge = np.append(cut, width)
    last = x[:, 1] + width * (line.around[parent] - k // count)
    columns = [
        np.where(starts, x[:, 0], cut[k % count]), np.where(starts, z[:, 0], height(k)),
        np.where(ends, last, edge[k % count + 1]), np.where(ends, z[:, 1], height(k + 1)),
    ]  # fmt: skip
    return np.stack(columns, axis=1), parent, k


def _entries(edge, strips, under):
    """Return `Layers.cell`."""
    first, last, between, _ = cells(edge).T
    several = np.where(last > first + 1, first, -1.0)
    first, last = first.astype(int), last.astype(int)
    rows = [np.stack([part[first], part[last], between, several], axis=1)
            for part in (strips.highest, strips.lowest, under, under + 1)]  # fmt: skip
    return np.stack(rows, axis=1).reshape(-1, 4)
