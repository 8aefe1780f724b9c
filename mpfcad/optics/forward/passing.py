"""Rays that come up to a place in the stack, of paths from the lamps: what a ray file holds."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.net import NET
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.caught import Net
from mpfcad.optics.engine import trace_paths
from mpfcad.optics.scene import Scene
from mpfcad.optics.source import LAMPS, Source
from mpfcad.optics.wave import Wave

#: Paths of one block: whole nets.
BLOCK = 8 * NET


class Passing(NamedTuple):
    """The rays of one block of paths, in the order of the paths.

    Attributes
    ----------
    ray
        (n, 6) float64, in the columns of `caught`: place [mm], direction and weight
    path
        (n,) int64, the number in the block of each ray's path
    flow
        (f,) float64, as of `recorder.Tally`
    """

    ray: NDArray[np.float64]
    path: NDArray[np.int64]
    flow: NDArray[np.float64]


def passing_rays(
    scene: Scene, gate: int, blocks: range, *, seed: int, threads: int
) -> list[Passing]:
    """Return the rays that come up to element `gate`, of each block of paths from the lamps.

    `gate` is the number of elements for those that leave the scene. The paths are those of
    `engine.trace` from `LAMPS`. The same blocks give the same bits at any number of threads.
    """
    source = Source(LAMPS, np.zeros(1), 0.0)

    def one(block: int) -> Passing:
        room = 2 * BLOCK
        while True:
            net, flow = Net.at(gate, room), np.zeros(len(FLOWS) + len(scene.kind))
            found = trace_paths(
                scene, source, np.uint64(seed), np.uint64(LAMPS), np.uint64(block * BLOCK),
                Wave.empty(len(scene.kind)), np.empty(BLOCK), flow, net,
            )  # fmt: skip
            if found <= room:
                order = np.argsort(net.path[:found], kind="stable")
                return Passing(net.ray[order], net.path[order], flow)
            room = found

    def listed(done: list[Passing], part: Passing) -> list[Passing]:
        return [*done, part]

    return add_in_order(one, blocks, listed, [], threads=threads)
