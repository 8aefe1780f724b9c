"""The coarse state of a ray beside the film: a cell of position and a cell of direction.

Positions are `cells` equal parts of a lamp pitch, from a lamp's axis on. Directions are cells of
(kx, |ky|), the direction cosines in the medium beside the film: `across` equal parts of -1 … 1 and
`along` of 0 … 1, those that meet the unit disk. Mirroring a state (x → -x, kx → -kx) gives a state.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Grid:
    """The cells of position and direction.

    Attributes
    ----------
    cells
        of position over a lamp pitch
    across, along
        of kx in -1 … 1 and of |ky| in 0 … 1
    """

    cells: int = 36
    across: int = 20
    along: int = 7

    @cached_property
    def number(self) -> NDArray[np.int64]:
        """Number of each direction cell, (across, along) int64; -1 outside the unit disk."""
        edge = np.linspace(-1, 1, self.across + 1)
        nearest = np.where(edge[:-1] * edge[1:] <= 0, 0, np.minimum(abs(edge[:-1]), abs(edge[1:])))
        low = np.arange(self.along) / self.along
        inside = nearest[:, None] ** 2 + low**2 < 1
        return np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1)

    @cached_property
    def corner(self) -> NDArray[np.float64]:
        """Smallest (kx, |ky|) of each direction cell, (d, 2) float64."""
        i, j = np.nonzero(self.number >= 0)
        return np.stack([2 * i / self.across - 1, j / self.along], axis=1)

    @property
    def directions(self) -> int:
        """Number of direction cells d."""
        return len(self.corner)

    @cached_property
    def mirrored(self) -> NDArray[np.int64]:
        """Number of each direction cell's mirror image kx → -kx, (d,) int64."""
        i, j = np.nonzero(self.number >= 0)
        return self.number[self.across - 1 - i, j]

    @cached_property
    def mirrored_state(self) -> NDArray[np.int64]:
        """Number of each state's mirror image, (cells·d,) int64; state = cell·d + direction."""
        cell = np.arange(self.cells - 1, -1, -1) * self.directions
        return (cell[:, None] + self.mirrored).ravel()

    @property
    def centre(self) -> NDArray[np.float64]:
        """Middle of each cell of position, (cells,) float64 in pitches."""
        return (np.arange(self.cells) + 0.5) / self.cells
