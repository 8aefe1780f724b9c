"""Where the light of each LED leaves: a map over many cells of every LED by itself."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.forward.connection import CellMeter
from mpfcad.optics.forward.engine import BLOCK, refuse_unconnected, trace_one
from mpfcad.optics.scene import Scene

#: Sums that are kept apart, so that anything read off the maps has a spread.
BATCHES = 32


class SpreadTally(NamedTuple):
    """Sums over blocks of paths in `BATCHES` batches; memory does not grow with them.

    Attributes
    ----------
    score
        (BATCHES, 1 + leds·side²) float64, sums of what `score_spread` adds; block b is in batch
        b mod BATCHES
    flow
        (f,) float64, as of `recorder.Tally`
    paths
        how many
    """

    score: NDArray[np.float64]
    flow: NDArray[np.float64]
    paths: int

    @property
    def total_paths(self) -> int:
        """Number of paths."""
        return self.paths

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return self.paths // BLOCK

    @classmethod
    def empty(cls, scene: Scene, meter: CellMeter) -> "SpreadTally":
        """Return the tally of no paths."""
        size = meter.size(len(scene.led))
        return cls(np.zeros((BATCHES, size)), np.zeros(len(FLOWS) + len(scene.kind)), 0)


def trace_spread(
    scene: Scene,
    meter: CellMeter,
    tally: SpreadTally,
    blocks: range,
    *,
    seed: int,
    threads: int,
    after_block: Callable[[], None] | None = None,
) -> SpreadTally:
    """Return a tally with some blocks added to it; its own arrays take them in.

    The same blocks give the same bits at any number of threads.

    Raises
    ------
    TraceError
        when there is no sheet on top to connect from.
    """
    refuse_unconnected(scene)

    def one(block: int) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
        score, flow, _ = trace_one(scene, meter, seed, block)
        return block, score, flow

    def added(
        total: SpreadTally, part: tuple[int, NDArray[np.float64], NDArray[np.float64]]
    ) -> SpreadTally:
        block, score, flow = part
        total.score[block % BATCHES] += score
        total.flow[:] += flow
        return total._replace(paths=total.paths + BLOCK)

    return add_in_order(one, blocks, added, tally, threads=threads, after=after_block)
