"""Blue noise for the dots of a tile: in every column evenly spread, and unlike its neighbours.

A tile is a torus. Dots are put in one after the other where there is least density yet (the voids
of Ulichney's void-and-cluster method), one a column in each round: resin levels along a column, so
every column has to be even by itself.
"""

import numpy as np
from numpy.typing import NDArray

#: Width of a dot's density over the mean distance of dots, across the tile and along a column.
SPREAD, SPREAD_ALONG = 0.5, 0.35


def rank_columns(columns: int, rows: int, seed: int = 1) -> NDArray[np.int64]:
    """Return the order in which the cells of each column get their dots, (columns, rows) int64.

    The first k entries of a column are the cells of its k dots.
    """
    random = np.random.default_rng(seed)
    order = np.empty((columns, rows), dtype=np.int64)
    dots = np.zeros((columns, rows))
    for number in range(rows):
        plane, line = _density(columns, rows, number + 1)
        spread = np.fft.irfft2(np.fft.rfft2(dots) * np.fft.rfft2(plane), s=dots.shape)
        spread += np.fft.irfft(np.fft.rfft(dots) * np.fft.rfft(line), n=rows)
        for c in random.permutation(columns):
            density = spread[c] + np.where(dots[c] > 0, np.inf, 1e-9 * random.random(rows))
            row = int(np.argmin(density))
            order[c, number] = row
            dots[c, row] = 1
            spread += np.roll(plane, (c, row), axis=(0, 1))
            spread[c] += np.roll(line, row)
    return order


def _density(columns: int, rows: int, number: int) -> tuple[NDArray, NDArray]:
    """Return the density around a dot at (0, 0), over the tile and along its own column."""
    x = np.minimum(np.arange(columns), columns - np.arange(columns))
    y = np.minimum(np.arange(rows), rows - np.arange(rows))
    distance = rows / number
    plane = np.exp(-(x[:, None] ** 2 + y**2) / (2 * (SPREAD * max(1.0, distance**0.5)) ** 2))
    line = np.exp(-(y**2) / (2 * (SPREAD_ALONG * distance) ** 2))
    return plane, line
