"""Facets at a tile's sides, repeated beyond the opposite sides.

A tile repeats, so a facet that ends on one side is joined there to one that ends on the other. With
both in one place a ray along the seam meets one of them, whatever the rounding of where it turns
from one tile into the next.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

#: How near to a side, in units of the tile, counts as on it: more than all rounding.
_ON = 1e-9


def with_seam(
    corner: NDArray[np.float64], width: float, length: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return (corners (m, 3, 3) [mm], number (m,)) of facets (n, 3, 3) and those beyond the sides.

    Corners on a side come to lie exactly on the opposite one.
    """
    size = np.array([width, length])
    low, high = corner[:, :, :2].min(axis=1), corner[:, :, :2].max(axis=1)
    corners, numbers = [], []
    # Without a turn, which comes first, all facets are on the tile.
    for turn in itertools.product((0, 1, -1), repeat=2):
        shift = turn * size
        meets = (low + shift <= size * (1 + _ON)) & (high + shift >= -size * _ON)
        number = np.flatnonzero(meets.all(axis=1))
        corners.append(corner[number] + [*shift, 0.0])
        numbers.append(number)
    return np.concatenate(corners), np.concatenate(numbers)


def facet_normals(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the outward unit normals (n, 3) of facets (n, 3, 3)."""
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)
