"""The path tracer: follows paths through a scene's elements, in blocks, on any number of threads.

One path starts at a `Source`, goes from element to element, scores the radiance it meets and ends
when it leaves the scene or the roulette ends it. A path's random numbers depend on (seed, stream,
path) only, blocks have a fixed size, and their sums are added in their order: the tallies are the
same bits at any thread count.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import entry, kernel
from mpfcad.optics.base.lanes import LANES
from mpfcad.optics.base.net import NET
from mpfcad.optics.base.recorder import FLOWS, Adding, Block, Tally, Total
from mpfcad.optics.base.sampling import start_net_path
from mpfcad.optics.base.sampling_lanes import net_keys
from mpfcad.optics.base.thread import add_in_order
from mpfcad.optics.caught import NO_NET, catch
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.cavity.queue import pass_cavity_queue
from mpfcad.optics.element import CAVITY, FILM, Sheet
from mpfcad.optics.film.chain_lanes import film_passages
from mpfcad.optics.film.grid_lanes import grid_passages
from mpfcad.optics.film.passage import (
    ABSORPTION,
    COSINE,
    FLIPPED,
    INDEX,
    INDEX_BELOW,
    MEASURED,
    OFFSET,
    RESIN_INDEX,
    ROUGHNESS,
    SCATTERING,
    TILE,
    into_film,
    out_of_film,
)
from mpfcad.optics.film.section_lanes import section_passages
from mpfcad.optics.passage import ENDED, next_element, pass_element
from mpfcad.optics.scene import Scene, build_scene
from mpfcad.optics.score.state import begin_scores, see, settle
from mpfcad.optics.search.tile import BVH, GRID, SECTION
from mpfcad.optics.search.tile_table import tile_of
from mpfcad.optics.source import EYE, LAMPS, REFLECTOR, Source, start_ray
from mpfcad.optics.spectral.hue import look_at
from mpfcad.optics.start_lanes import start_rays
from mpfcad.optics.stokes.engine import trace_block
from mpfcad.optics.wave import Wave, enqueue, take_longest

#: Paths of one point in one block.
BLOCK = NET


@kernel
def _begin(scene, source, seed, stream, path, slot, number, wave):
    """Put a new path into a slot and before its first element."""
    rng = wave.rng[slot]
    points = uint64(len(source.position))
    start_net_path(rng, seed, stream, path, points)
    point = path % points
    e, up, x, y, z, dx, dy, dz, lamp = start_ray(scene, source, point, rng)
    place = wave.place[slot]
    place[0], place[1], place[2], place[3], place[4], place[5] = x, y, z, dx, dy, dz
    wave.weight[slot] = 1.0
    wave.radiance[slot] = 0.0
    wave.upward[slot] = 1 if up else 0
    wave.lamp[slot] = lamp
    wave.path[slot] = number
    enqueue(wave, e, slot)


@kernel
def refill(scene, source, seed, stream, first, started, slots, count, wave, score):
    """Put new paths into free slots while there are any of `count`; return the next's number."""
    slots = slots[: min(len(slots), count - started)]
    begin_scores(score, slots)
    if source.kind in (LAMPS, REFLECTOR):
        for i in range(len(slots)):
            path = first + uint64(started + i)
            _begin(scene, source, seed, stream, path, slots[i], started + i, wave)
    else:
        for i in range(0, len(slots), LANES):
            start_rays(scene, source, seed, stream, first, started + i, slots[i : i + LANES], wave)
    return started + len(slots)


@kernel
def pass_queue(scene, e, rays, wave, flow, score, hue):
    """Follow the rays that wait before element e through it, the first ones in lanes."""
    eight = 0
    if scene.kind[e] == FILM:
        tile = tile_of(scene.tiles, int(scene.parameter[e, TILE]))
        # Films that absorb, of two materials, rough, or with resin that scatters: ray by ray.
        film = scene.parameter[e]
        smooth = film[ROUGHNESS] == 0.0 and film[RESIN_INDEX] == 0.0
        clear = film[SCATTERING] == 0.0 and film[ABSORPTION] == 0.0 and film[MEASURED] == 0.0
        layered = tile.accelerator != SECTION or len(tile.layers.part) > 0
        if tile.accelerator != BVH and layered and clear and smooth:
            _pass_film(tile, scene.parameter[e], rays, wave)
            eight = len(rays)
    elif scene.kind[e] == CAVITY:
        eight = pass_cavity_queue(scene, rays, wave, flow, score, hue)
    _pass_one_by_one(scene, e, rays[eight:], wave, flow, score, hue)


@kernel
def _pass_one_by_one(scene, e, rays, wave, flow, score, hue):
    """Follow rays through an element of any kind."""
    for slot in rays:
        p = wave.place[slot]
        look_at(hue, wave, slot)
        before = 1.0 if scene.kind[e] == CAVITY else wave.weight[slot]
        way, p[0], p[1], p[3], p[4], p[5], wave.weight[slot], found = pass_element(
            scene, e, wave.upward[slot] != 0, p[0], p[1], p[2], p[3], p[4], p[5],
            wave.lamp[slot], wave.weight[slot], flow, None, score, hue, wave.rng[slot],
        )  # fmt: skip
        wave.way[slot] = way
        wave.lamp[slot] = NO_LAMP
        wave.radiance[slot] += found
        settle(score, wave, slot, e, before, found)


@kernel
def _pass_film(tile, film, rays, wave):
    """Follow rays in lanes through a film as it lies in the stack."""
    placed = film[COSINE] != 1.0 or film[FLIPPED] != 0.0
    if placed:
        for slot in rays:
            p = wave.place[slot]
            up, p[0], p[1], p[3], p[4], p[5] = into_film(
                film, tile.width, wave.upward[slot] != 0, p[0], p[1], p[3], p[4], p[5]
            )
            wave.upward[slot] = 1 if up else 0
    if tile.accelerator == GRID:
        grid_passages(
            tile, film[INDEX], film[INDEX_BELOW], film[OFFSET],
            rays, wave.place, wave.upward, wave.way, wave.rng,
        )  # fmt: skip
    elif tile.accelerator == SECTION:
        section_passages(
            tile, film[INDEX], film[INDEX_BELOW], film[OFFSET],
            rays, wave.place, wave.way, wave.rng, wave.lane_row, wave.waiting,
        )  # fmt: skip
    else:
        film_passages(
            tile, film[INDEX], film[INDEX_BELOW], film[OFFSET],
            rays, wave.place, wave.way, wave.rng, wave.lane_row, wave.waiting,
        )  # fmt: skip
    if placed:
        for slot in rays:
            p = wave.place[slot]
            wave.way[slot], p[0], p[1], p[3], p[4], p[5] = out_of_film(
                film, tile.width, wave.way[slot], p[0], p[1], p[3], p[4], p[5]
            )


@kernel
def go_on(scene, e, slot, wave, flow, score, hue):
    """Move a ray that has left element e before the next; return whether its path goes on."""
    way = wave.way[slot]
    look_at(hue, wave, slot)
    e, wave.weight[slot], found = next_element(
        scene, e, way, wave.place[slot, 0], wave.place[slot, 1], wave.weight[slot], flow,
        hue, wave.rng[slot],
    )  # fmt: skip
    wave.radiance[slot] += found
    see(score, wave, slot, found)
    if e == ENDED:
        return False
    wave.upward[slot] = 1 if way > 0 else 0
    enqueue(wave, e, slot)
    return True


@kernel
def follow_paths(scene, source, seed, stream, first, wave, radiance, flow, net, score):
    """Follow paths `first` and on as `trace_paths` does; `score` gets their scores, or is None."""
    started, caught = 0, 0
    if source.kind != LAMPS:
        net_keys(seed, stream, first, uint64(len(source.position)), wave.net_key)
    freed = wave.freed
    free = min(len(freed), len(radiance))
    for slot in range(free):
        freed[slot] = slot
    while True:
        started = refill(
            scene, source, seed, stream, first, started, freed[:free], len(radiance), wave, score
        )
        free = 0
        e, waiting = take_longest(wave)
        if waiting == 0:
            return caught
        rays = wave.batch[:waiting]
        pass_queue(scene, e, rays, wave, flow, score, None)
        is_under_gate = e + 1 == net.gate
        for i in range(waiting):
            slot = uint64(rays[i])
            goes_on = go_on(scene, e, slot, wave, flow, score, None)
            if is_under_gate:
                caught = catch(net, scene.wall, wave, slot, caught)
            if goes_on:
                continue
            radiance[wave.path[slot]] = wave.radiance[slot]
            freed[free] = slot
            free += 1


@entry
def trace_paths(scene, source, seed, stream, first, wave, radiance, flow, net):
    """Follow paths `first` and on, and put what each collects into radiance (n,).

    Paths go round the points. flow (f,) gets the sums of where the weights went; `wave` is scratch.
    `net` gets the rays that come up to its gate; returned is how many came. A scene without
    elements has no paths.
    """
    return follow_paths(scene, source, seed, stream, first, wave, radiance, flow, net, None)


def compile_tracer() -> None:
    """Compile `trace_paths`, once for all scenes, if it is not there yet."""
    scene, source = build_scene([Sheet(0.0, 1.5, 1.0)]), Source(EYE, [0.0], 0.0)
    zero, flow = np.uint64(0), np.zeros(len(FLOWS) + 1)
    trace_paths(scene, source, zero, zero, zero, Wave.empty(1), np.empty(0), flow, NO_NET)


def flow_count(scene: Scene, points: int) -> int:
    """Return how many flows a tally of so many points has."""
    return len(FLOWS) + len(scene.kind) + points * max(0, len(scene.glow) - 1)


def landed_weights(scene: Scene, tally: Tally) -> NDArray[np.float64]:
    """Return the mean weight of a point's paths that ended at each place of the glow, (p, n)."""
    landed = tally.flow[flow_count(scene, 0) :]
    return landed.reshape(len(tally.score), -1) / tally.paths


def trace(
    scene: Scene,
    source: Source,
    blocks: int,
    *,
    seed: int = 1,
    first: int = 0,
    threads: int = 1,
    after_block: Callable[[], None] | None = None,
) -> Tally:
    """Return the tally of `blocks` blocks of paths from block `first` on.

    The same blocks give the same bits at any number of threads. `after_block` is called as each
    block comes in.
    """
    points = len(source.position)
    adding, numbers = Tally.adding(points, flow_count(scene, points)), range(first, first + blocks)
    return trace_blocks(
        scene, source, numbers, adding, seed=seed, threads=threads, after_block=after_block
    )


def trace_blocks(
    scene: Scene,
    source: Source,
    blocks: range,
    adding: Adding[Total],
    *,
    seed: int,
    threads: int,
    after_block: Callable[[], None] | None = None,
) -> Total:
    """Return what numbered blocks of paths add up to; else as `trace`."""
    points = len(source.position)
    flows = flow_count(scene, points)

    def polarised(block: int) -> Total:
        stokes, flow = np.empty((BLOCK, points, 1)), np.zeros(flows)
        passed = trace_block(scene, source, block, seed, stokes, flow)
        return adding.of_block(Block(block, stokes[:, :, 0], flow, passed))

    # Memory that threads hand on: asking for it anew took 5 % on a film alone.
    scratch: list[Any] = []

    def one(block: int) -> Total:
        try:
            wave, radiance = scratch.pop()
        except IndexError:
            wave, radiance = Wave.empty(len(scene.kind), points), np.empty((BLOCK, points))
        flow = np.zeros(flows)
        wave.passed[0] = 0
        trace_paths(
            scene, source, np.uint64(seed), np.uint64(source.kind),
            np.uint64(block * radiance.size), wave, radiance.reshape(-1), flow, NO_NET,
        )  # fmt: skip
        total = adding.of_block(Block(block, radiance, flow, int(wave.passed[0])))
        scratch.append((wave, radiance))
        return total

    return add_in_order(
        polarised if scene.polarised else one, blocks, adding.join, adding.empty,
        threads=threads, after=after_block,
    )  # fmt: skip
