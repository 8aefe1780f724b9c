"""Paths from the LEDs of a cell, followed as in `optics.engine`, scored at the topmost sheet."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics.base.kernel import entry, kernel
from mpfcad.optics.base.net import NET
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import start_net_path
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.cavity.board import led_start
from mpfcad.optics.element import SHEET
from mpfcad.optics.engine import pass_queue
from mpfcad.optics.forward.connection import (
    TERMS,
    CellMeter,
    part_at,
    score_at,
    score_spread,
    turned_into,
)
from mpfcad.optics.passage import ENDED
from mpfcad.optics.scene import Scene
from mpfcad.optics.sheet import ACROSS, SHARE, SIGMA, WIDE
from mpfcad.optics.spectral.again import go_on_in_bands
from mpfcad.optics.spectral.engine import Spectral
from mpfcad.optics.spectral.hue import Hue, begin_hue, count_at, look_at, seen
from mpfcad.optics.stokes.bands import ONLY, pass_on, resume
from mpfcad.optics.stokes.state import LIGHT_SHAPE, start_light
from mpfcad.optics.wave import SLOTS, Wave, enqueue, take_longest

#: Paths of one block: whole nets.
BLOCK = 8 * NET
_STREAM = 31


class CellTally(NamedTuple):
    """Sums over blocks of paths; memory does not grow with them.

    Attributes
    ----------
    score
        (TERMS² + bins²,) float64, sums of what `score_at` adds
    outer
        (TERMS², TERMS²) float64, sum over the blocks of the products of their coefficients
    square
        (bins²,) float64, sum of the squares of the blocks' map
    flow, flow2
        (f,) float64, as of `recorder.Tally`
    paths, blocks
        how many
    lit, passed
        paths that found light, of those from the LEDs all; how many times an element was passed or
        a ray joined with the meter: the work done
    """

    score: NDArray[np.float64]
    outer: NDArray[np.float64]
    square: NDArray[np.float64]
    flow: NDArray[np.float64]
    flow2: NDArray[np.float64]
    paths: int
    blocks: int
    lit: int
    passed: int

    @property
    def total_paths(self) -> int:
        """Number of paths."""
        return self.paths

    @classmethod
    def empty(cls, meter: CellMeter, flows: int) -> "CellTally":
        """Return the tally of no paths."""
        n, m = TERMS * TERMS, meter.bins * meter.bins
        flow = np.zeros(flows), np.zeros(flows)
        return cls(np.zeros(n + m), np.zeros((n, n)), np.zeros(m), *flow, 0, 0, 0, 0)

    @classmethod
    def of_block(
        cls, score: NDArray[np.float64], flow: NDArray[np.float64], lit: int, passed: int
    ) -> "CellTally":
        """Return the tally of one block by the sums of its paths."""
        n = TERMS * TERMS
        outer = np.outer(score[:n], score[:n])
        return cls(score, outer, score[n:] ** 2, flow, flow**2, BLOCK, 1, lit, passed)

    def plus(self, other: "CellTally") -> "CellTally":
        """Return the tally of both."""
        return CellTally(
            self.score + other.score, self.outer + other.outer, self.square + other.square,
            self.flow + other.flow, self.flow2 + other.flow2,
            self.paths + other.paths, self.blocks + other.blocks,
            self.lit + other.lit, self.passed + other.passed,
        )  # fmt: skip


def can_connect(scene: Scene) -> bool:
    """Return whether the topmost element is a sheet that scatters, over a board of LEDs."""
    if scene.kind[-1] != SHEET or len(scene.led) == 0:
        return False
    sheet = scene.parameter[-1]
    widths = [sheet[SIGMA], sheet[ACROSS], *([sheet[WIDE]] if sheet[SHARE] > 0 else [])]
    return all(width > 0 for width in widths)


@kernel
def begin(scene, seed, path, slot, wave, hue):
    """Put a new path into a slot; its number there is that of its LED."""
    rng = wave.rng[slot]
    start_net_path(rng, seed, uint64(_STREAM), path, uint64(1))
    x, y, z, dx, dy, dz, led = led_start(scene, rng)
    place = wave.place[slot]
    place[0], place[1], place[2], place[3], place[4], place[5] = x, y, z, dx, dy, dz
    wave.weight[slot] = 1.0
    wave.radiance[slot] = 0.0
    wave.upward[slot] = 1
    wave.lamp[slot] = led
    wave.path[slot] = led
    begin_hue(hue, slot)


@kernel
def arrive(scene, meter, slot, wave, hue, terms, score):
    """Score what the topmost sheet sends into the meter of a ray that comes up to it."""
    p, last = wave.place[slot], len(scene.kind) - 1
    wave.passed[0] += 1
    value = wave.weight[slot] * turned_into(
        scene.parameter[last], meter.acceptance, p[3], p[4], p[5], wave.rng[slot]
    )
    count_at(hue, part_at(meter, p[0], p[1]))
    value = seen(hue, value)
    count_at(hue, -1)
    if meter.reach > 0:
        score_spread(meter, score, wave.path[slot], p[0], p[1], value)
    else:
        score_at(meter, score, terms, p[0], p[1], value)


@entry
def trace_cell(scene, meter, seed, first, count, wave, terms, score, flow, hue):
    """Follow `count` paths from `first` on; score and flow get their sums; the rest is scratch.

    `hue` is the state of light in bands, whose luminance is scored, or None.
    """
    freed = wave.freed
    started, free = 0, min(len(freed), count)
    for slot in range(free):
        freed[slot] = slot
    last = len(scene.kind) - 1
    while True:
        for i in range(min(free, count - started)):
            begin(scene, seed, first + uint64(started + i), freed[i], wave, hue)
            enqueue(wave, 0, freed[i])
        started += min(free, count - started)
        free = 0
        e, waiting = take_longest(wave)
        if waiting == 0:
            return
        rays = wave.batch[:waiting]
        if e == last:
            for slot in rays:
                if wave.upward[slot] != 0:
                    look_at(hue, wave, slot)
                    arrive(scene, meter, slot, wave, hue, terms, score)
        pass_queue(scene, e, rays, wave, flow, None, hue)
        for i in range(waiting):
            slot = uint64(rays[i])
            if not go_on_in_bands(scene, e, slot, wave, flow, hue):
                freed[free] = slot
                free += 1


@entry
def trace_polarised_cell(scene, meter, seed, first, count, wave, terms, light, score, flow, hue):
    """Follow paths of polarised light as `trace_cell` does, one after the other."""
    last = len(scene.kind) - 1
    if hue is not None:
        hue.at[0], hue.at[1] = 0, -1
    for i in range(count):
        begin(scene, seed, first + uint64(i), ONLY, wave, hue)
        p = wave.place[ONLY]
        start_light(light, 1, p[3], p[4], p[5])
        e, begun = 0, True
        while begun:
            while e != ENDED:
                if e == last and wave.upward[ONLY] != 0:
                    arrive(scene, meter, ONLY, wave, hue, terms, score)
                e, _ = pass_on(scene, e, wave, flow, light, hue)
            begun, e, _ = resume(scene, wave, flow, light, hue)


def refuse_unconnected(scene: Scene) -> None:
    """Raise unless there are LEDs, and a sheet on top to connect from.

    Raises
    ------
    TraceError
        in words.
    """
    if not can_connect(scene):
        raise TraceError("forward trace: expected LEDs below and a scattering sheet on top")


def trace_one(
    scene: Scene, meter: CellMeter, seed: int, block: int, spectral: Spectral | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return the sums of one block: what the meter scores, the flow, and the work done."""
    score = np.zeros(meter.size(len(scene.led)))
    flow, passed = np.zeros(len(FLOWS) + len(scene.kind)), 0
    for part, share, hue in _scenes(scene, spectral, 0):
        found, work = _traced(part, meter, seed, block, flow, hue)
        score += share * found
        passed += work
    return score, flow, passed


def _traced(
    scene: Scene, meter: CellMeter, seed: int, block: int, flow: NDArray[np.float64],
    hue: Hue | None,
) -> tuple[NDArray[np.float64], int]:  # fmt: skip
    """Return what the meter scores of one block, and the work done; `flow`, `hue` get theirs."""
    score = np.zeros(meter.size(len(scene.led)))
    paths = scene, meter, np.uint64(seed), np.uint64(block * BLOCK), BLOCK
    wave = Wave.empty(len(scene.kind))
    scratch = wave, np.zeros((2, TERMS))
    if scene.polarised:
        trace_polarised_cell(*paths, *scratch, np.zeros(LIGHT_SHAPE), score, flow, hue)
    else:
        trace_cell(*paths, *scratch, score, flow, hue)
    return score, int(wave.passed[0])


def trace_parts(
    spectral: Spectral, meter: CellMeter, blocks: range, *, seed: int, threads: int,
    after_block: Callable[[], None] | None = None,
) -> NDArray[np.float64]:  # fmt: skip
    """Return the sum of each channel of each block and bin of the meter, (blocks, bins², channels).

    A path of weight 1 that the meter sees with a luminance of 1 counts 1. The same blocks give the
    same bits at any number of threads.

    Raises
    ------
    TraceError
        when there is no sheet on top to connect from.
    """
    first, bins = spectral.scenes[0], meter.bins * meter.bins
    refuse_unconnected(first)

    def one(block: int) -> list[NDArray[np.float64]]:
        found, flow = [], np.zeros(spectral.flows)
        for scene, _, hue in _scenes(first, spectral, bins):
            score, _ = _traced(scene, meter, seed, block, flow, hue)
            if hue is not None:
                return [hue.score]
            found.append(score[TERMS * TERMS :])
        return [np.array(found).T]

    parts: list[NDArray[np.float64]] = add_in_order(
        one, blocks, list.__add__, [], threads=threads, after=after_block
    )
    return np.array(parts)


def trace_forward(
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
    """Return the tally of `blocks` blocks of paths from block `first` on.

    The same blocks give the same bits at any number of threads. `spectral`: the scene in bands,
    whose luminance is scored.

    Raises
    ------
    TraceError
        when there is no sheet on top to connect from.
    """
    flows = len(FLOWS) + len(scene.kind)

    def one(block: int) -> CellTally:
        score, flow, passed = trace_one(scene, meter, seed, block, spectral)
        return CellTally.of_block(score, flow, BLOCK, passed)

    refuse_unconnected(scene)
    return add_in_order(
        one, range(first, first + blocks), CellTally.plus, CellTally.empty(meter, flows),
        threads=threads, after=after_block,
    )  # fmt: skip


def _scenes(
    scene: Scene, spectral: Spectral | None, points: int
) -> list[tuple[Scene, float, Hue | None]]:
    """Return the scenes to trace, with their share in the luminance, and the state of all bands.

    Channels are counted at so many points.
    """
    if spectral is None:
        return [(scene, 1.0, None)]
    if spectral.tables is None:
        return [
            (part, float(share), None)
            for part, share in zip(spectral.scenes, spectral.colour[:, 1], strict=True)
        ]
    tables = spectral.tables._replace(forward=np.ones(1, np.int64))
    return [(spectral.scenes[0], 1.0, Hue.empty(tables, SLOTS, points))]
