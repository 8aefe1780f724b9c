"""A small model backlight with operators written down by hand, not traced."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from mpfcad.design import Grid, Operators, Response


def build_operators(lamp):
    """Return operators of a film that sends less light up and more back as C grows.

    `lamp` is the amplitude of the light over the pitch: 0 is a uniform source.
    """
    grid = Grid(cells=24, across=4, along=2)
    cells, d = grid.cells, grid.directions
    node = np.linspace(20, 80, 6)
    up = 0.35 + 0.004 * (node - 20) - 3e-5 * (node - 20) ** 2
    spread = np.full((2 * d + 1, d), 1 / d)
    film = np.array([np.hstack([share * spread, (0.95 - share) * spread]) for share in up])
    # Light that goes down comes back from below, blurred over the pitch; upward it is gone.
    distance = np.arange(cells)[:, None] - np.arange(cells)
    distance = np.abs((distance + cells / 2) % cells - cells / 2)
    blur = np.exp(-((distance / 3) ** 2))
    blur *= 0.7 / blur.sum(axis=1, keepdims=True)
    world = np.zeros((2 * cells * d, 2 * cells * d))
    world[cells * d :, : cells * d] = np.kron(blur, np.full((d, d), 1 / d))
    light = 1000 * (1 + lamp * np.cos(2 * np.pi * grid.centre))
    radiance = np.concatenate([np.zeros(cells * d), np.repeat(light, d)])
    meter = np.append(np.zeros(d), 1.0)
    return Operators(grid, node, film, csr_array(world), radiance, meter, 0, 0)


@pytest.fixture(scope="session")
def lamps():
    return Response(build_operators(0.02))


@pytest.fixture(scope="session")
def uniform():
    return Response(build_operators(0.0))
