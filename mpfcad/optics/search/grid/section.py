"""Extruded films of any cross-section: undercuts, voids, several bodies, no flat side.

The cross-section's segments are listed in the cells of a uniform grid over the tile; a ray walks
from cell to cell (`section_walk`). On which side of a vertex it passes is decided by one expression
for both segments that meet there, and each cell also holds what lies just beyond its rim, across
the tile's sides too: a ray cannot slip between segments, and no offset is needed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.solid.crossing_section import extruded_section
from mpfcad.optics.solid.mesh import FilmMesh

#: Segments a cell, on average.
_SHARE = 1
#: By how much of a cell its list reaches beyond it: far more than rounding moves a ray.
_RIM = 1e-3


class Section(NamedTuple):
    """The cross-section of an extruded film tile.

    Attributes
    ----------
    cell
        (columns · rows, 4) float64, row by row from the bottom: the place of each cell's first
        segment in the lists, and of the one after its last; two that are free
    line
        (n, 4) float64 [mm], the lists: x, z of a segment's start and x, z of its end, the film on
        its right
    facing
        (n, 4) float64, outward unit normal, x and z; the segment's number; 0
    shape
        (2,) int64, columns and rows
    """

    cell: NDArray[np.float64]
    line: NDArray[np.float64]
    facing: NDArray[np.float64]
    shape: NDArray[np.int64]


def drawn_segments(mesh: FilmMesh) -> NDArray[np.float64] | None:
    """Return the segments (s, 4) of a mesh drawn along y, as `section_of` takes them, or None."""
    used, number = np.unique(mesh.top, return_inverse=True)
    drawn = extruded_section(mesh.vertex[used], number.reshape(-1, 3))
    if drawn is None or len(drawn.cap):
        return None
    return drawn.point[drawn.edge].reshape(-1, 4)


def section_of(segment: NDArray[np.float64], width: float) -> Section:
    """Return the section of segments (s, 4): x, z of start and end [mm], the film on the right."""
    dx, dz = segment[:, 2] - segment[:, 0], segment[:, 3] - segment[:, 1]
    normal = np.stack([-dz, dx], axis=1) / np.hypot(dx, dz)[:, None]
    low, high = segment[:, 1::2].min(), segment[:, 1::2].max()
    shape = _shape(width, high - low, len(segment))
    place, number, shift = _members(segment, width, low, high, shape)
    order = np.argsort(place, kind="stable")
    place, number, shift = place[order], number[order], shift[order]
    count = np.bincount(place, minlength=shape[0] * shape[1])
    first = np.concatenate([[0], np.cumsum(count)]).astype(float)
    cell = np.stack([first[:-1], first[1:], 0.0 * first[1:], 0.0 * first[1:]], axis=1)
    line = segment[number]
    line[:, 0] += shift
    line[:, 2] += shift
    facing = np.column_stack([normal[number], number, np.zeros(len(number))])
    return Section(cell, line, facing, shape)


def _shape(width: float, height: float, count: int) -> NDArray[np.int64]:
    """Return columns and rows of nearly square cells for a number of segments."""
    side = math.sqrt(width * max(height, 1e-12 * width) * _SHARE / count)
    most = 2 * count
    return np.array([min(max(1, round(n / side)), most) for n in (width, height)], np.int64)


def _members(segment, width, low, high, shape):
    """Return (cell, segment's number, shift of x [mm]) of all that lies in or just beside cells."""
    columns, rows = (int(n) for n in shape)
    step_x, step_z = width / columns, ((high - low) or width) / rows
    x0, z0, x1, z1 = segment.T
    left, right = np.minimum(x0, x1), np.maximum(x0, x1)
    begin = np.floor(left / step_x - _RIM).astype(np.int64)
    end = np.floor(right / step_x + _RIM).astype(np.int64)
    number, column = spread(begin, end)
    # Heights of the part over the column and its rim.
    near, far = (column - _RIM) * step_x, (column + 1 + _RIM) * step_x
    rise = np.where(x1 == x0, 0.0, (z1 - z0) / np.where(x1 == x0, 1.0, x1 - x0))
    at = [np.clip(edge, left[number], right[number]) for edge in (near, far)]
    z = [z0[number] + (a - x0[number]) * rise[number] for a in at]
    upright = x0[number] == x1[number]
    bottom = np.where(upright, np.minimum(z0, z1)[number], np.minimum(*z))
    top = np.where(upright, np.maximum(z0, z1)[number], np.maximum(*z))
    begin = np.floor((bottom - low) / step_z - _RIM).astype(np.int64).clip(0, rows - 1)
    end = np.floor((top - low) / step_z + _RIM).astype(np.int64).clip(0, rows - 1)
    member, row = spread(begin, end)
    number, column = number[member], column[member]
    tile = column // columns
    return row * columns + column - tile * columns, number, -width * tile


def spread(begin: NDArray[np.int64], end: NDArray[np.int64]) -> tuple[NDArray, NDArray]:
    """Return (i, n) for each i and each n from begin[i] to end[i]."""
    count = end - begin + 1
    i = np.repeat(np.arange(len(count)), count)
    return i, np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + begin[i]
