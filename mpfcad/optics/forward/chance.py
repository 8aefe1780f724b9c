"""Paths from the meter over a cell of LEDs, which they meet by chance, scored as those from them.

They are the paths of `optics.engine` from a meter that looks at the whole cell. Nothing has to
scatter on top of the stack, but small LEDs are seldom met. A path's luminance is scored at the
place that the meter looks at, which its own first random numbers give again.
"""

from collections.abc import Callable

import numpy as np
from numba import uint64

from mpfcad.optics.base.kernel import entry
from mpfcad.optics.base.net import NET
from mpfcad.optics.base.recorder import Adding, Block
from mpfcad.optics.base.sampling import RNG_SIZE, start_net_path
from mpfcad.optics.engine import flow_count, trace_blocks
from mpfcad.optics.forward.connection import TERMS, CellMeter, score_at
from mpfcad.optics.forward.engine import BLOCK, CellTally
from mpfcad.optics.scene import Scene
from mpfcad.optics.source import EYE, Source, start_place
from mpfcad.optics.spectral.engine import Spectral, luminance_blocks


@entry
def score_paths(source, meter, seed, first, radiance, rng, terms, score):
    """Add the radiance (n,) of paths `first` and on at the places that they look at.

    The source is a meter over the cell. rng (8,), terms (2, TERMS): scratch. Returned is how many
    paths have found light.
    """
    points, stream, lit = uint64(len(source.position)), uint64(source.kind), 0
    for i in range(len(radiance)):
        if radiance[i] > 0.0:
            path = first + uint64(i)
            start_net_path(rng, seed, stream, path, points)
            x, y = start_place(source, source.spot_along, path % points, rng)
            score_at(meter, score, terms, x, y, radiance[i])
            lit += 1
    return lit


def cell_source(meter: CellMeter) -> Source:
    """Return the meter as a source of paths: equal points over the whole cell, a net each."""
    points = np.zeros(BLOCK // NET)
    return Source(EYE, points, meter.across, acceptance=meter.acceptance, spot_along=meter.along)


def trace_chance(
    scene: Scene,
    meter: CellMeter,
    blocks: int,
    *,
    seed: int = 1,
    first: int = 0,
    threads: int = 1,
    after_block: Callable[[], None] | None = None,
    spectral: Spectral | None = None,
) -> CellTally:
    """Return the tally of `blocks` blocks of paths from the meter, from block `first` on.

    A path's score is luminance [cd/m²]; flows are those of weights from the meter. Else it is as
    `forward.engine.trace_forward`: the same blocks give the same bits at any number of threads.
    """
    source = cell_source(meter)

    def of_block(block: Block) -> CellTally:
        score = np.zeros(meter.size(0))
        lit: int = score_paths(
            source, meter, np.uint64(seed), np.uint64(block.number * BLOCK),
            block.radiance.reshape(-1), np.zeros(RNG_SIZE, np.uint64), np.zeros((2, TERMS)), score,
        )  # fmt: skip
        return CellTally.of_block(score, block.flow, lit, block.passed)

    numbers = range(first, first + blocks)
    if spectral is not None:
        adding = Adding(CellTally.empty(meter, spectral.flows), of_block, CellTally.plus)
        return luminance_blocks(
            spectral, source, numbers, adding, seed=seed, threads=threads, after_block=after_block
        )
    flows = flow_count(scene, len(source.position))
    adding = Adding(CellTally.empty(meter, flows), of_block, CellTally.plus)
    return trace_blocks(
        scene, source, numbers, adding, seed=seed, threads=threads, after_block=after_block
    )
