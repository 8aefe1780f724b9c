"""Paths of light in bands: one path for all of them, or each band by itself.

* Where bands differ by what they lose, one path serves all (`hue`).
* Where they differ by the way they take (dispersion), each has its own path through its own scene,
  with the same random numbers, so that the noise of a colour is less than that of its luminances.
  Wavelengths refracted apart share no path but the first piece of it, so a hero wavelength with
  weights for the others (Wilkie et al., "Hero wavelength spectral sampling", EGSR 2014) would be
  the same.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics.base.kernel import entry
from mpfcad.optics.base.net import NET
from mpfcad.optics.base.recorder import FLOWS, Adding, Block, Tally, Total
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.caught import NO_NET
from mpfcad.optics.engine import pass_queue, refill, trace_paths
from mpfcad.optics.scene import Scene
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.spectral.again import go_on_in_bands
from mpfcad.optics.spectral.converter import conversion
from mpfcad.optics.spectral.envelope import envelope
from mpfcad.optics.spectral.hue import Hue, Tables, begin_hue
from mpfcad.optics.stokes.bands import PolarisedWork
from mpfcad.optics.stokes.state import ROWS
from mpfcad.optics.wave import SLOTS, Wave, take_longest


@entry
def trace_bands(scene, source, hue, seed, stream, first, wave, radiance, flow):
    """Follow paths `first` and on, and put the luminance that each collects into radiance (n,).

    hue.score gets the sums over the paths of each point, channel by channel; the rest is as of
    `engine.trace_paths`. Paths of whole rounds of the points.
    """
    started = 0
    freed = wave.freed
    free = min(len(freed), len(radiance))
    for slot in range(free):
        freed[slot] = slot
    while True:
        begun = min(free, len(radiance) - started)
        for i in range(begun):
            begin_hue(hue, freed[i])
        started = refill(
            scene, source, seed, stream, first, started, freed[:free], len(radiance), wave, None
        )
        free = 0
        e, waiting = take_longest(wave)
        if waiting == 0:
            return
        rays = wave.batch[:waiting]
        pass_queue(scene, e, rays, wave, flow, None, hue)
        for i in range(waiting):
            slot = uint64(rays[i])
            if not go_on_in_bands(scene, e, slot, wave, flow, hue):
                radiance[wave.path[slot]] = wave.radiance[slot]
                freed[free] = slot
                free += 1


class Band(NamedTuple):
    """What the bands of a light are, beside their scenes; b bands, c converters.

    Attributes
    ----------
    source
        (b,) float64, the lamps' power in each for a luminance of 1
    colour
        (b · (1 + c), 3) float64, X, Y, Z of what each channel counts
    wavelength
        (b,) float64 [nm], by which photons are counted
    photons
        (c, b) float64, the share of each converter's photons in each band
    quantum_yield
        (c,) float64, of each converter
    """

    source: NDArray[np.float64]
    colour: NDArray[np.float64]
    wavelength: NDArray[np.float64]
    photons: NDArray[np.float64]
    quantum_yield: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spectral:
    """A scene in bands, ready to trace: one scene for all, or one for each.

    Attributes
    ----------
    scenes
        one for all bands, with `tables`; or one a band
    colour
        (channels, 3) float64, as of `Band`
    tables
        how bands differ, where one scene serves all
    """

    scenes: tuple[Scene, ...]
    colour: NDArray[np.float64]
    tables: Tables | None

    @property
    def is_joint(self) -> bool:
        """Whether one path serves all bands."""
        return self.tables is not None

    @property
    def flows(self) -> int:
        """How many numbers say where weights went."""
        return len(FLOWS) + len(self.scenes[0].kind)


def build_spectral(scenes: Sequence[Scene], band: Band, *, joint: bool) -> Spectral:
    """Return the scenes of all bands as one to trace; `joint`: one path serves all bands.

    Raises
    ------
    TraceError
        when bands that take different ways are to share one, or light is converted and they not.
    """
    if not joint:
        if len(band.photons):
            raise TraceError("bands: a converter needs one path for all of them")
        return Spectral(tuple(scenes), band.colour, None)
    pairs = [
        conversion(share, band.wavelength, photons)
        for share, photons in zip(band.quantum_yield, band.photons, strict=True)
    ]
    taken, emitted = np.array(pairs).reshape(-1, 2, len(scenes)).transpose(1, 0, 2).copy()
    luminance = band.colour[:, 1].copy()
    scene, tables = envelope(scenes, band.source, luminance, taken, emitted)
    return Spectral((scene,), band.colour, tables)


class _Work:
    """Scratch of a block: a wave, luminances (n, p), and the state of all bands."""

    def __init__(self, spectral: Spectral, points: int) -> None:
        self.spectral = spectral
        self.wave = Wave.empty(len(spectral.scenes[0].kind))
        self.radiance = np.empty((NET, points))
        tables = spectral.tables
        self.hue = None if tables is None else Hue.empty(tables, SLOTS, points)

    def trace(
        self, source: Source, block: int, seed: int, flow: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Trace a block: luminances into `radiance`; return the channels' sums a point."""
        spectral, out = self.spectral, self.radiance.reshape(-1)
        start = np.uint64(seed), np.uint64(source.kind), np.uint64(block * self.radiance.size)
        if self.hue is not None:
            self.hue.score[:] = 0.0
            trace_bands(spectral.scenes[0], source, self.hue, *start, self.wave, out, flow)
            return self.hue.score
        total, sums = np.zeros_like(self.radiance), []
        for scene, luminance in zip(spectral.scenes, spectral.colour[:, 1], strict=True):
            trace_paths(scene, source, *start, self.wave, out, flow, NO_NET)
            total += luminance * self.radiance
            sums.append(self.radiance.sum(axis=0))
        self.radiance[:] = total
        flow /= len(spectral.scenes)
        return np.array(sums).T


def _work(spectral: Spectral, points: int, rows: int) -> Any:
    """Return the scratch of a block; `rows` of the state that are followed of polarised light."""
    scenes = spectral.scenes
    if not scenes[0].polarised:
        return _Work(spectral, points)
    return PolarisedWork(scenes, spectral.colour, spectral.tables, points, rows)


def trace_luminance(
    spectral: Spectral, source: Source, blocks: int, *, seed: int = 1, first: int = 0,
    threads: int = 1, after_block: Callable[[], None] | None = None,
) -> Tally:  # fmt: skip
    """Return the tally of luminances Y of `blocks` blocks of paths, as `engine.trace` does.

    Its flows are those of the weight by which paths are drawn.
    """
    return luminance_blocks(
        spectral, source, range(first, first + blocks),
        Tally.adding(len(source.position), spectral.flows), seed=seed, threads=threads,
        after_block=after_block,
    )  # fmt: skip


def luminance_blocks(
    spectral: Spectral, source: Source, blocks: range, adding: Adding[Total], *, seed: int,
    threads: int, after_block: Callable[[], None] | None = None,
) -> Total:  # fmt: skip
    """Return what luminances of numbered blocks add up to, as `engine.trace_blocks` does."""

    def one(work: Any, block: int) -> Total:
        flow = np.zeros(spectral.flows)
        work.wave.passed[0] = 0
        work.trace(source, block, seed, flow)
        return adding.of_block(Block(block, work.radiance, flow, int(work.wave.passed[0])))

    total: Total = _all(
        spectral, source, 1, one, adding.join, adding.empty, blocks, threads, after_block
    )
    return total


def trace_channels(
    spectral: Spectral, source: Source, blocks: int, *, seed: int = 1, first: int = 0,
    threads: int = 1, after_block: Callable[[], None] | None = None,
) -> NDArray[np.float64]:  # fmt: skip
    """Return the mean of each channel of each block and point, (blocks, p, channels) float64.

    In the unit of the lamps' luminance; its product with `colour` is X, Y, Z [cd/m²]. The same
    blocks give the same bits at any number of threads.
    """
    found = _means(spectral, source, 1, seed, range(first, first + blocks), threads, after_block)
    return found.reshape(blocks, len(source.position), len(spectral.colour))


def trace_stokes_channels(
    spectral: Spectral, source: Source, blocks: int, *, seed: int = 1, first: int = 0,
    threads: int = 1, after_block: Callable[[], None] | None = None,
) -> NDArray[np.float64]:  # fmt: skip
    """Return the mean I, Q, U, V of each channel of each block and point, (blocks, p, 4, channels).

    Units are those of `trace_channels`, axes those of `stokes.engine.trace_stokes`.

    Raises
    ------
    TraceError
        when light is not polarised.
    """
    if not spectral.scenes[0].polarised:
        raise TraceError("bands: Stokes vectors: expected polarised light")
    found = _means(spectral, source, ROWS, seed, range(first, first + blocks), threads, after_block)
    return found.reshape(blocks, len(source.position), ROWS, len(spectral.colour))


def _means(
    spectral: Spectral, source: Source, rows: int, seed: int, blocks: range, threads: int,
    after: Callable[[], None] | None,
) -> NDArray[np.float64]:  # fmt: skip
    """Return what each block's scratch gives as sums, over the paths of a point."""

    def one(work: Any, block: int) -> list[NDArray[np.float64]]:
        return [work.trace(source, block, seed, np.zeros(spectral.flows)) / NET]

    return np.array(
        _all(spectral, source, rows, one, list.__add__, [], blocks, threads, after), np.float64
    )


def _all(
    spectral: Spectral, source: Source, rows: int, one: Callable[[Any, int], Any], join: Any,
    empty: Any, blocks: range, threads: int, after: Callable[[], None] | None,
) -> Any:  # fmt: skip
    """Return the sum of what `one` gives of each block, its scratch handed on."""
    tables = spectral.tables
    if tables is not None and len(tables.taken) and source.kind != EYE:
        raise TraceError("bands: light is converted on paths from a meter alone")
    scratch: list[Any] = []

    def of(block: int) -> Any:
        try:
            work = scratch.pop()
        except IndexError:
            work = _work(spectral, len(source.position), rows)
        found = one(work, block)
        scratch.append(work)
        return found

    return add_in_order(of, blocks, join, empty, threads=threads, after=after)
