"""Paths of polarised light: each carries the state of four meters, one path after the other."""

from collections.abc import Callable

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import entry
from mpfcad.optics.base.net import NET
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE, start_net_path
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.passage import ENDED, next_element, pass_element
from mpfcad.optics.scene import Scene
from mpfcad.optics.source import Source, start_ray
from mpfcad.optics.stokes.state import LIGHT_SHAPE, ROWS, start_light


@entry
def trace_polarised(scene, source, seed, stream, first, light, rng, stokes, flow):
    """Follow paths `first` and on; put what the meters see of each into stokes (n, 4) or (n, 1).

    They are I, Q, U and V of the light that comes to the meter, in the axes of `start_light`.
    light (5, 4), rng (8,): scratch. flow (f,) gets the sums of where the weights went. Returned is
    how many times an element was passed.
    """
    points, rows, passed = uint64(len(source.position)), stokes.shape[1], 0
    for i in range(len(stokes)):
        path = first + uint64(i)
        start_net_path(rng, seed, stream, path, points)
        e, up, x, y, z, dx, dy, dz, lamp = start_ray(scene, source, path % points, rng)
        start_light(light, rows, dx, dy, dz)
        weight = 1.0
        for j in range(rows):
            stokes[i, j] = 0.0
        while e != ENDED:
            way, x, y, dx, dy, dz, weight, found = pass_element(
                scene, e, up, x, y, z, dx, dy, dz, lamp, weight, flow, light, None, None, rng
            )
            lamp = NO_LAMP
            passed += 1
            up = way > 0
            e, weight, seen = next_element(scene, e, way, x, y, weight, flow, None, rng)
            # No element changes the rows' intensities after it has found light.
            if found + seen > 0.0:
                for j in range(rows):
                    stokes[i, j] += (found + seen) * light[j, 0]
    return passed


def compile_polarised_tracer(scene: Scene, source: Source) -> None:
    """Compile `trace_polarised`, once for all scenes, if it is not there yet."""
    trace_block(scene, source, 0, 1, np.empty((0, 1, ROWS)), np.zeros(len(FLOWS) + 1))


def trace_block(
    scene: Scene, source: Source, block: int, seed: int, stokes: NDArray[np.float64],
    flow: NDArray[np.float64],
) -> int:  # fmt: skip
    """Trace a block of paths: stokes (n, p, 4) or (n, p, 1) gets what each sees, flow (f,) sums.

    Returned is how many times an element was passed.
    """
    passed: int = trace_polarised(
        scene, source, np.uint64(seed), np.uint64(source.kind),
        np.uint64(block * stokes.shape[0] * stokes.shape[1]), np.zeros(LIGHT_SHAPE),
        np.zeros(RNG_SIZE, np.uint64), stokes.reshape(-1, stokes.shape[2]), flow,
    )  # fmt: skip
    return passed


def trace_stokes(
    scene: Scene,
    source: Source,
    blocks: int,
    *,
    seed: int = 1,
    first: int = 0,
    threads: int = 1,
    after_block: Callable[[], None] | None = None,
) -> NDArray[np.float64]:
    """Return the mean I, Q, U, V of each block and point, (blocks, p, 4) float64 [cd/m²].

    Q is what passes a polariser along y less what passes one along x; U the same at 45° and 135°,
    anticlockwise from y as the meter sees the panel. The same blocks give the same bits at any
    number of threads.
    """
    points = len(source.position)
    flows = len(FLOWS) + len(scene.kind)

    def one(block: int) -> list[NDArray[np.float64]]:
        stokes = np.empty((NET, points, ROWS))
        trace_block(scene, source, block, seed, stokes, np.zeros(flows))
        return [stokes.mean(axis=0)]

    parts: list[NDArray[np.float64]] = add_in_order(
        one, range(first, first + blocks), list.__add__, [], threads=threads, after=after_block
    )
    return np.array(parts).reshape(blocks, points, ROWS)
