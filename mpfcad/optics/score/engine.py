"""One trace gives the light and its derivative by every value that has a score."""

from operator import add

import numpy as np
from numpy.typing import ArrayLike

from mpfcad.errors import TraceError
from mpfcad.optics.base.kernel import entry
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.caught import NO_NET
from mpfcad.optics.engine import BLOCK, follow_paths
from mpfcad.optics.scene import Scene
from mpfcad.optics.score.columns import Columns
from mpfcad.optics.score.state import Score
from mpfcad.optics.score.tally import SlopeTally
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.wave import SLOTS, Wave


@entry
def trace_scores(scene, source, seed, stream, first, wave, radiance, flow, net, score):
    """Follow paths as `trace_paths` does, the same ones, and put their scores into `score`.

    `first` is a multiple of the points.
    """
    follow_paths(scene, source, seed, stream, first, wave, radiance, flow, net, score)


def trace_slopes(
    scene: Scene,
    source: Source,
    blocks: int,
    directions: ArrayLike,
    *,
    seed: int = 1,
    first: int = 0,
    threads: int = 1,
) -> SlopeTally:
    """Return light and derivatives of `blocks` blocks of paths from block `first` on.

    directions: (v, k) float64, each of v values as the derivatives of the k columns by it
    (`Columns.of`). The light is that of `trace`; the same blocks give the same bits at any number
    of threads.

    Raises
    ------
    TraceError
        when paths do not start at a meter, light is polarised, or a direction has a part along a
        column whose derivative is not known.
    """
    columns, along = Columns.of(scene), np.asarray(directions, np.float64)
    if source.kind != EYE or scene.polarised:
        raise TraceError("derivatives: expected paths from a meter and light without polarisation")
    if along[:, ~columns.known].any():
        raise TraceError("derivatives: expected directions along known columns alone")
    points = len(source.position)
    flows = len(FLOWS) + len(scene.kind)

    def one(block: int) -> SlopeTally:
        radiance, score = np.empty((BLOCK, points)), Score.empty(columns.first, points, SLOTS)
        trace_scores(
            scene, source, np.uint64(seed), np.uint64(source.kind),
            np.uint64(block * radiance.size), Wave.empty(len(scene.kind), points),
            radiance.reshape(-1), np.zeros(flows), NO_NET, score,
        )  # fmt: skip
        # What is not known may be no number.
        known = along[:, columns.known].T
        slope = score.light[:, columns.known] @ known
        return SlopeTally.of_block(
            radiance.sum(axis=0), slope, score.control[..., columns.known] @ known, BLOCK
        )

    return add_in_order(
        one, range(first, first + blocks), add, SlopeTally.empty(points, len(along)),
        threads=threads,
    )  # fmt: skip
