"""Binary STL files as numbers, read without the program."""

import functools

import numpy as np


def read_corners(path):
    """Return the facets' corners, (t, 3, 3) float64 in the file's unit."""
    record = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    return np.fromfile(path, record, offset=84)["v"].astype(float)


@functools.lru_cache(maxsize=1)
def read_mesh(path):
    """Return vertices (v, 3) [mm] about the middle of the mesh, z from below, and facets."""
    corner = read_corners(path).reshape(-1, 3)
    low, high = corner.min(axis=0), corner.max(axis=0)
    # The middle over a tip, whatever the number of grooves.
    middle = np.array([round((high[0] - low[0]) / 2 / 0.05) * 0.05, (high[1] - low[1]) / 2, 0.0])
    vertex, facet = np.unique(corner - low - middle, axis=0, return_inverse=True)
    return vertex, facet.reshape(-1, 3)
