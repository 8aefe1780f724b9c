"""What a trace leaves: sums of scores and of where the light went, and their standard errors."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: The first entries of a tally's flow; after them one for each element's absorption, lowest first.
#: `walls` and `rim` (what leaves a finite panel beside its layers) are 0 where it has no end.
FLOWS = ("up", "down", "lost", "roulette", "lamps", "walls", "rim")
FLOW_UP, FLOW_DOWN, FLOW_LOST, FLOW_ROULETTE, FLOW_LAMPS, FLOW_WALLS, FLOW_RIM = range(len(FLOWS))
FLOW_ELEMENTS = len(FLOWS)


class Tally(NamedTuple):
    """Sums over paths; memory grows with points, never with paths.

    Attributes
    ----------
    score, score2
        (p,) float64, sum of the paths' radiance and of its square, a point
    flow, flow2
        (f,) float64, sum of the weights (start: 1 a path) that ended as each of `FLOWS` and in each
        element, and of their squares
    paths
        paths a point
    """

    score: NDArray[np.float64]
    score2: NDArray[np.float64]
    flow: NDArray[np.float64]
    flow2: NDArray[np.float64]
    paths: int

    @classmethod
    def empty(cls, points: int, flows: int) -> "Tally":
        """Return a tally of no paths."""
        return cls(np.zeros(points), np.zeros(points), np.zeros(flows), np.zeros(flows), 0)

    def __add__(self, other: "Tally") -> "Tally":
        """Return the tally of both."""
        return Tally(*(a + b for a, b in zip(self, other, strict=True)))

    @property
    def total_paths(self) -> int:
        """Number of paths over all points."""
        return self.paths * len(self.score)

    @property
    def radiance(self) -> NDArray[np.float64]:
        """Mean radiance a point, (p,) float64 [cd/m²]."""
        return self.score / self.paths

    @property
    def radiance_error(self) -> NDArray[np.float64]:
        """Standard error of `radiance`, (p,) float64 [cd/m²]."""
        return _error(self.score, self.score2, self.paths)

    @property
    def fraction(self) -> NDArray[np.float64]:
        """Mean share of a path's weight that ended in each flow, (f,) float64."""
        return self.flow / self.total_paths

    @property
    def fraction_error(self) -> NDArray[np.float64]:
        """Standard error of `fraction`, (f,) float64."""
        return _error(self.flow, self.flow2, self.total_paths)


def _error(total: NDArray[np.float64], squares: NDArray[np.float64], count: int) -> NDArray:
    mean = total / count
    variance = np.maximum(0.0, squares / count - mean**2)
    return np.sqrt(variance / max(1, count - 1))
