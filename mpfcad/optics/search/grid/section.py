"""Extruded films of any cross-section: undercuts, voids, several bodies, no flat side.

The cross-section's segments lie in the cells of a uniform grid over the tile, in blocks of eight
that are tested at once (`lanes`); a ray walks from cell to cell. On which side of a vertex it
passes is decided by one expression for both segments that meet there, and each cell also holds what
lies just beyond its rim, across the tile's sides too: a ray cannot slip between segments, and no
offset is needed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import LANES, bits, select
from mpfcad.optics.base.lanes_array import load, local_floats, store
from mpfcad.optics.solid.crossing_section import extruded_section
from mpfcad.optics.solid.mesh import FilmMesh

#: Segments a cell, on average: 4, 8 and 16 are as fast on films of 2 to 150 chords a groove.
_SHARE = 8
#: By how much of a cell its list reaches beyond it: far more than rounding moves a ray.
_RIM = 1e-3
_MOST_CELLS = 100_000_000


class Section(NamedTuple):
    """The cross-section of an extruded film tile.

    Attributes
    ----------
    corner
        (4b, 8) float64 [mm], for each block x, z of the segments' starts and x, z of their ends,
        the film on their right; NaN in places left over
    segment
        (b, 8) int64, the segments' numbers in `normal`
    first
        (columns · rows + 1,) int64, the first block of each cell, row by row from the bottom
    normal
        (s, 2) float64, outward unit normals, x and z
    shape
        (2,) int64, columns and rows
    """

    corner: NDArray[np.float64]
    segment: NDArray[np.int64]
    first: NDArray[np.int64]
    normal: NDArray[np.float64]
    shape: NDArray[np.int64]


def build_section(mesh: FilmMesh) -> Section | None:
    """Return the section of a film mesh, or None where it is not one drawn along y."""
    used, number = np.unique(mesh.top, return_inverse=True)
    drawn = extruded_section(mesh.vertex[used], number.reshape(-1, 3))
    if drawn is None or len(drawn.cap):
        return None
    return section_of(drawn.point[drawn.edge].reshape(-1, 4), mesh.size[0])


def section_of(segment: NDArray[np.float64], width: float) -> Section:
    """Return the section of segments (s, 4): x, z of start and end [mm], the film on the right."""
    dx, dz = segment[:, 2] - segment[:, 0], segment[:, 3] - segment[:, 1]
    normal = np.stack([-dz, dx], axis=1) / np.hypot(dx, dz)[:, None]
    low, high = segment[:, 1::2].min(), segment[:, 1::2].max()
    shape = _shape(width, high - low, len(segment))
    cell, number, shift = _members(segment, width, low, high, shape)
    order = np.argsort(cell, kind="stable")
    cell, number, shift = cell[order], number[order], shift[order]
    count = np.bincount(cell, minlength=shape[0] * shape[1])
    first = np.concatenate([[0], np.cumsum(-(-count // LANES))])
    # The place of each member in its cell's blocks.
    place = np.arange(len(cell)) - np.repeat(np.cumsum(count) - count, count)
    block, lane = first[cell] + place // LANES, place % LANES
    corner = np.full((first[-1], 4, LANES), np.nan)
    corner[block, :, lane] = segment[number]
    corner[block, 0, lane] += shift
    corner[block, 2, lane] += shift
    numbers = np.zeros((first[-1], LANES), np.int64)
    numbers[block, lane] = number
    return Section(corner.reshape(-1, LANES), numbers, first.astype(np.int64), normal, shape)


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
    number, column = _spread(begin, end)
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
    member, row = _spread(begin, end)
    number, column = number[member], column[member]
    tile = column // columns
    return row * columns + column - tile * columns, number, -width * tile


def _spread(begin: NDArray[np.int64], end: NDArray[np.int64]) -> tuple[NDArray, NDArray]:
    """Return (i, n) for each i and each n from begin[i] to end[i]."""
    count = end - begin + 1
    i = np.repeat(np.arange(len(count)), count)
    return i, np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + begin[i]


@kernel
def section_hit(section, width, low, high, x, z, dx, dz, inside):
    """Return the next segment that a ray meets: (segment or -1, distance, x, z, shift).

    The ray starts at (x, z) [mm], inside or outside the film; low, high: lowest and highest z of
    the section. `shift` [mm] is what to add to x to be in the same coordinates as before; segment
    -1: the ray leaves the section's heights without a hit, -2: it never does.
    """
    speed = math.sqrt(dx * dx + dz * dz)
    if speed == 0.0:
        return -2, 0.0, x, z, 0.0
    ux, uz = dx / speed, dz / speed
    flown = 0.0
    if z < low and uz > 0.0:
        flown = (low - z) / uz
    elif z > high and uz < 0.0:
        flown = (high - z) / uz
    elif z < low or z > high:
        return -1, 0.0, x, z, 0.0
    x += flown * ux
    z += flown * uz
    shift = math.floor(x / width) * width
    x -= shift
    columns, rows = section.shape[0], section.shape[1]
    step_x, step_z = width / columns, (high - low) / rows
    if step_z == 0.0:
        step_z = width
    column = min(max(int(x / step_x), 0), columns - 1)
    row = min(max(int((z - low) / step_z), 0), rows - 1)
    slack = 16 * 2.3e-16 * max(width, high)
    lane_x, lane_z = local_floats(LANES), local_floats(LANES)
    side = 1.0 if inside else -1.0
    right, up = side * ux, side * uz
    best = math.inf
    k = -1
    hit_x = hit_z = hit_shift = 0.0
    turns = 0
    for _ in range(_MOST_CELLS):
        to_x = ((column + 1 if ux > 0.0 else column) * step_x - x) / ux if ux != 0.0 else math.inf
        to_z = math.inf
        if uz != 0.0:
            to_z = (low + (row + 1 if uz > 0.0 else row) * step_z - z) / uz
        edge = min(to_x, to_z)
        cell = row * columns + column
        for block in range(section.first[cell], section.first[cell + 1]):
            ax, az = load(section.corner, 4 * block), load(section.corner, 4 * block + 1)
            bx, bz = load(section.corner, 4 * block + 2), load(section.corner, 4 * block + 3)
            a = right * (az - z) - up * (ax - x)
            b = right * (bz - z) - up * (bx - x)
            met = bits((a >= -slack) & (b <= slack) & (a > b))
            if not met:
                continue
            part = a / (a - b)
            part = select(part > 0.0, select(part < 1.0, part, 1.0), 0.0)
            store(lane_x, 0, ax + part * (bx - ax))
            store(lane_z, 0, az + part * (bz - az))
            for i in range(LANES):
                if not (met >> i) & 1:
                    continue
                distance = (lane_x[i] - x) * ux + (lane_z[i] - z) * uz
                if -slack <= distance < best:
                    best = distance
                    k = section.segment[block, i]
                    hit_x, hit_z, hit_shift = lane_x[i], lane_z[i], shift
        if k >= 0 and best <= edge:
            break
        if to_x < to_z:
            column += 1 if ux > 0.0 else -1
            if column < 0 or column == columns:
                turn = width if ux > 0.0 else -width
                column = columns - 1 if column < 0 else 0
                x -= turn
                shift += turn
                turns += 1
                if uz == 0.0 and turns > 1:
                    # Nothing at this height in a whole tile.
                    return -2, 0.0, x, z, shift
        else:
            row += 1 if uz > 0.0 else -1
            if row < 0 or row == rows:
                if k < 0:
                    return -1, flown / speed, x, z, shift
                break
    if k < 0:
        return -2, 0.0, x, z, shift
    return k, max(0.0, flown + best) / speed, hit_x, hit_z, hit_shift
