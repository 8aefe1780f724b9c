"""What a trace leaves: sums of scores and of where the light went, and their standard errors."""

from collections.abc import Callable
from operator import add
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

#: The first entries of a tally's flow; after them one for each element's absorption, lowest first.
#: `walls` and `rim` (what leaves a finite panel beside its layers) are 0 where it has no end.
FLOWS = ("up", "down", "lost", "roulette", "lamps", "walls", "rim")
FLOW_UP, FLOW_DOWN, FLOW_LOST, FLOW_ROULETTE, FLOW_LAMPS, FLOW_WALLS, FLOW_RIM = range(len(FLOWS))
FLOW_ELEMENTS = len(FLOWS)
_SHARED = 30

Total = TypeVar("Total")


class Block(NamedTuple):
    """What one block of paths gave.

    Attributes
    ----------
    number
        of the block
    radiance
        (n, p) float64, of each path of each point; may be overwritten
    flow
        (f,) float64, sums of where the weights went
    passed
        how many times an element was passed
    """

    number: int
    radiance: NDArray[np.float64]
    flow: NDArray[np.float64]
    passed: int


class Adding(NamedTuple, Generic[Total]):
    """How blocks are added up: the sum of none, that of one, that of two sums."""

    empty: Total
    of_block: Callable[[Block], Total]
    join: Callable[[Total, Total], Total]


class Tally(NamedTuple):
    """Sums over paths; memory grows with points, never with paths.

    Attributes
    ----------
    score, score2, block2
        (p,) float64, sum of the paths' radiance, of its square and of the squares of the blocks'
        sums, a point
    flow, flow2
        (f,) float64, sum of the weights (start: 1 a path) that ended as each of `FLOWS` and in each
        element, and of the squares of the blocks' sums; of a scene with a glow after them the
        weights that ended by it, by point and place (`cavity.glow`)
    paths, blocks
        paths a point; in how many blocks of equal size
    """

    score: NDArray[np.float64]
    score2: NDArray[np.float64]
    block2: NDArray[np.float64]
    flow: NDArray[np.float64]
    flow2: NDArray[np.float64]
    paths: int
    blocks: int

    @classmethod
    def empty(cls, points: int, flows: int) -> "Tally":
        """Return a tally of no paths."""
        radiance, square, paths = np.zeros(points), np.zeros(points), np.zeros(points)
        return cls(radiance, square, paths, np.zeros(flows), np.zeros(flows), 0, 0)

    @classmethod
    def adding(cls, points: int, flows: int) -> "Adding[Tally]":
        """Return how blocks of paths become a tally."""
        return Adding(
            cls.empty(points, flows), lambda block: cls.of_block(block.radiance, block.flow), add
        )

    @classmethod
    def of_block(cls, radiance: NDArray[np.float64], flow: NDArray[np.float64]) -> "Tally":
        """Return the tally of one block; radiance (n, p) float64 is overwritten, flow (f,) kept."""
        score = radiance.sum(axis=0)
        score2 = np.square(radiance, out=radiance).sum(axis=0)
        return cls(score, score2, score**2, flow, flow**2, len(radiance), 1)

    def __add__(self, other: "Tally") -> "Tally":  # type: ignore[override]  # sums, not joins
        """Return the tally of both."""
        pairs: Any = zip(self, other, strict=True)
        return Tally._make(a + b for a, b in pairs)

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
        """Standard error of `radiance`, (p,) float64 [cd/m²].

        Paths of a block are a net, so the blocks' means scatter less than their paths do: by a
        ratio of variances that every point has of its own, and alike at all. Few blocks tell it
        badly, so a point's, of d = blocks - 1 degrees of freedom, is averaged with that of all
        points, which counts as `_SHARED` degrees (Smyth, "Linear models and empirical Bayes
        methods", 2004). Of a single block the paths' own variance is taken, which is too large.
        """
        return self._error(_SHARED)

    @property
    def own_error(self) -> NDArray[np.float64]:
        """Standard error of `radiance` from each point's own blocks alone, (p,) float64 [cd/m²].

        For points that differ in what nets save, such as directions: a bare plate's ratio of
        variances is 100 times smaller along the normal than at 70°. It has blocks - 1 degrees of
        freedom.
        """
        return self._error(0)

    def _error(self, shared: int) -> NDArray[np.float64]:
        paths, blocks = self.paths, self.blocks
        variance = np.maximum(0.0, self.score2 / paths - self.radiance**2)
        if blocks == 1:
            return np.sqrt(variance / max(1, paths - 1))
        of_blocks = _variance(self.score, self.block2, blocks) * blocks / paths
        ratio = of_blocks / np.where(variance > 0, variance, np.inf)
        mean = ratio.sum() / max(1, np.count_nonzero(variance))
        ratio = ((blocks - 1) * ratio + shared * mean) / (blocks - 1 + shared)
        return np.sqrt(ratio * variance / paths)

    @property
    def radiance_freedom(self) -> float:
        """Degrees of freedom of a single point's `radiance_error`."""
        return _pooled_freedom(1.0, int(np.count_nonzero(self.radiance_error)), self.blocks)

    @property
    def fraction(self) -> NDArray[np.float64]:
        """Mean share of a path's weight that ended in each flow, (f,) float64."""
        return self.flow / self.total_paths

    @property
    def fraction_error(self) -> NDArray[np.float64]:
        """Standard error of `fraction`, (f,) float64, from the blocks' spread; two at least."""
        variance = _variance(self.flow, self.flow2, self.blocks)
        return np.sqrt(self.blocks * variance) / self.total_paths

    @property
    def fraction_freedom(self) -> float:
        """Degrees of freedom of `fraction_error`."""
        return float(self.blocks - 1)


def freedom_of_sum(
    weight: NDArray[np.float64], error: NDArray[np.float64], blocks: float, *, own: bool = False
) -> float:
    """Return the degrees of freedom of the error √Σ(weight · error)² of a weighted sum of points.

    weight, error: (p,) float64, error the `radiance_error`, or with `own` the `own_error`, of a
    tally of `blocks` blocks (inf: errors that are known). Without any error it is that of a single
    point.
    """
    part = (weight * error) ** 2
    shares = float(np.sum((part / part.sum()) ** 2)) if part.sum() > 0 else 1.0
    points = int(np.count_nonzero(error))
    return _pooled_freedom(shares, points, blocks, 0 if own else _SHARED)


def _pooled_freedom(own: float, points: int, blocks: float, shared: int = _SHARED) -> float:
    """Return the degrees of freedom of a variance whose parts come from points with pooled errors.

    own: Σ q² of the points' shares q in the variance, 1 for a single point.

    An error² is (d·s² + d₀·S)/(d + d₀) with s² of the point itself, of variance 2/d in units of its
    square, and S the mean of the p points' s², whose true values scatter with variance 2/d₀. The
    variance of Σ q·error² is then 2/f with

        1/f = own/(d + d₀) + (1/d - 1/(d + d₀))/p

    (matched as by Satterthwaite, "An approximate distribution of estimates of variance components",
    1946): d for one point alone, d + d₀ for one of very many, p·d for the mean of alike points.
    """
    if blocks == 1 or np.isinf(blocks):
        return np.inf
    d, pooled = blocks - 1, blocks - 1 + shared
    return float(1 / (own / pooled + (1 / d - 1 / pooled) / max(points, 1)))


def _variance(total: NDArray[np.float64], squares: NDArray[np.float64], count: int) -> NDArray:
    """Return the variance of values by their sum and the sum of their squares."""
    return np.maximum(0.0, squares - total**2 / count) / (count - 1)
