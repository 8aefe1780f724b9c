"""Whether a file holds the very apertures that it should: a fingerprint of every groove.

The fingerprint of a groove is the sum, modulo 2⁶⁴, of a hash of every aperture's corners. It does
not depend on the order or on how apertures are gathered in arrays, so a single aperture that is
moved, resized, lost or added anywhere on the panel changes it (but for one case in 10¹⁹).
"""

from collections.abc import Iterable
from typing import Any

import numba as nb
import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.array import ApertureArray
from mpfcad.store.kernel import kept

#: Odd constants of the mixing function splitmix64 (Steele, Lea, Flood, OOPSLA 2014).
_A, _B, _C = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB


def fingerprint(
    arrays: Iterable[ApertureArray], groove_edge: NDArray[np.int64]
) -> NDArray[np.uint64]:
    """Return the fingerprint of each groove, (n,) uint64.

    `groove_edge` (n + 1,) int64 are the tips, left to right [grid steps]; an aperture belongs to
    the groove of its left edge, or to the nearest.
    """
    edge = np.ascontiguousarray(groove_edge, np.int64)
    total = np.zeros(len(edge) - 1, np.uint64)
    for array in arrays:
        place, (left, bottom, right, top) = array.place, array.box
        x, y = place.origin[0] + left, place.origin[1] + bottom
        size = (right - left, top - bottom)
        if place.offset is not None:
            offset = np.ascontiguousarray(place.offset, np.int64)
            _add_listed(total, edge, x, y, *size, offset)
        else:
            _add_lattice(
                total, edge, x, y, *size, place.columns, *place.column_step, place.rows,
                *place.row_step,
            )  # fmt: skip
    return total


def different_grooves(found: NDArray[np.uint64], wanted: NDArray[np.uint64]) -> NDArray[np.int64]:
    """Return the grooves whose fingerprints differ, counted from 0."""
    return np.flatnonzero(found != wanted)


@nb.njit(nogil=True)
def _mix(word: Any, value: Any) -> Any:
    word = (word ^ np.uint64(value)) + np.uint64(_A)
    word = (word ^ (word >> np.uint64(30))) * np.uint64(_B)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(_C)
    return word ^ (word >> np.uint64(31))


@nb.njit(nogil=True)
def _column(x: Any, width: Any, length: Any) -> Any:
    return _mix(_mix(_mix(np.uint64(0), x), width), length)


@nb.njit(nogil=True)
def _groove(edge: Any, x: Any) -> Any:
    return min(max(np.searchsorted(edge, x, side="right") - 1, 0), len(edge) - 2)


@kept
@nb.njit(nogil=True)
def _add_listed(
    total: Any, edge: Any, x: Any, y: Any, width: Any, length: Any, offset: Any
) -> None:
    last, groove, column = np.int64(-(2**62)), 0, np.uint64(0)
    for i in range(len(offset)):
        left = x + offset[i, 0]
        if left != last:
            last, groove, column = left, _groove(edge, left), _column(left, width, length)
        total[groove] += _mix(column, y + offset[i, 1])


@kept
@nb.njit(nogil=True)
def _add_lattice(
    total: Any,
    edge: Any,
    x: Any,
    y: Any,
    width: Any,
    length: Any,
    columns: Any,
    ax: Any,
    ay: Any,
    rows: Any,
    bx: Any,
    by: Any,
) -> None:
    for i in range(columns):
        left = x + i * ax
        groove, column = _groove(edge, left), _column(left, width, length)
        added = np.uint64(0)
        for j in range(rows):
            if bx and j:
                total[groove] += added
                added = np.uint64(0)
                left = x + i * ax + j * bx
                groove, column = _groove(edge, left), _column(left, width, length)
            added += _mix(column, y + i * ay + j * by)
        total[groove] += added
