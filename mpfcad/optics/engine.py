"""The path tracer: follows paths through a scene's elements, in blocks, on any number of threads.

One path starts at a `Source`, goes from element to element, scores the radiance it meets and ends
when it leaves the scene or the roulette ends it. A path's random numbers depend on (seed, stream,
path) only, blocks have a fixed size, and their sums are added in their order: the tallies are the
same bits at any thread count.
"""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numba import njit, uint64
from numpy.typing import ArrayLike, NDArray

from mpfcad.optics.bsdf import bsdf_passage
from mpfcad.optics.cavity import (
    LAMP,
    NO_LAMP,
    OPENING,
    REFLECTOR,
    cavity_hit,
    lambertian,
    reflector_direction,
)
from mpfcad.optics.film import into_film, out_of_film, placed_film_passage
from mpfcad.optics.film_lanes import film_passages
from mpfcad.optics.kernel import kernel
from mpfcad.optics.panel import (
    LAMP_END,
    WALL_ACROSS,
    WALL_ALONG,
    lamp_start,
    panel_hit,
    wall_direction,
)
from mpfcad.optics.recorder import FLOWS, Tally
from mpfcad.optics.sampling import disk, start_path, uniform
from mpfcad.optics.scene import RESIN, TILE, Scene
from mpfcad.optics.sheet import sheet_passage
from mpfcad.optics.slab import slab_passage
from mpfcad.optics.tile import CHAIN
from mpfcad.optics.tile_table import tile_of
from mpfcad.optics.wave import Wave, enqueue, longest_queue

_CAVITY, _SLAB, _SHEET, _FILM, _BSDF = range(5)
EYE, LAMBERTIAN_BELOW, LAMPS = range(3)
_UP, _DOWN, _LOST, _ROULETTE, _LAMPS, _WALLS, _RIM, _ELEMENTS = range(8)
_ROULETTE_BELOW = 0.1
_MOST_ELEMENTS = 1_000_000

#: Paths of one point in one block.
BLOCK = 512


class _SourceFields(NamedTuple):
    """The fields of a `Source`, as the kernels read them."""

    kind: int
    position: NDArray[np.float64]
    spot: float
    tilt_x: NDArray[np.float64]
    tilt_y: NDArray[np.float64]
    acceptance: float
    along: NDArray[np.float64]
    spot_along: float


class Source(_SourceFields):
    """Where paths start; one number for `tilt_x`, `tilt_y` or `along` stands for all points.

    Attributes
    ----------
    kind
        `EYE`: over the scene, looking down (a luminance meter, traced backward);
        `LAMBERTIAN_BELOW`: under it, Lambertian upward; `LAMPS`: on the lamps' surface, Lambertian
    position
        (p,) float64 [mm], x of the measured points; paths are shared out equally
    spot
        width [mm] across over which a point is averaged
    tilt_x, tilt_y
        (p,) float64, direction cosines (kx, ky) of each meter's line of sight, downward; the light
        it measures goes toward (-kx, -ky) (0, 0: normal)
    acceptance
        sine of the half angle of the meter's acceptance cone about its axis
    along
        (p,) float64 [mm], y of the measured points
    spot_along
        length [mm] along y over which a point is averaged; 0 for that over which the stack repeats
    """

    __slots__ = ()

    def __new__(
        cls,
        kind: int,
        position: ArrayLike,
        spot: float,
        tilt_x: ArrayLike = 0.0,
        tilt_y: ArrayLike = 0.0,
        acceptance: float = 0.0,
        along: ArrayLike = 0.0,
        spot_along: float = 0.0,
    ) -> "Source":
        """Return the source with one entry a point in every array."""
        points = np.shape(position)
        position, tilt_x, tilt_y, along = (
            np.broadcast_to(np.asarray(values, np.float64), points).copy()
            for values in (position, tilt_x, tilt_y, along)
        )
        return super().__new__(
            cls, kind, position, float(spot), tilt_x, tilt_y, float(acceptance), along,
            float(spot_along),
        )  # fmt: skip


@kernel
def _look(tilt_x, tilt_y, acceptance, px, py):
    """Return the direction of a meter's ray: (px, py) of the unit disk within its cone.

    The cone stands upright on the meter's axis d0: d = cos a · d0 + sine of the half angle · p,
    p in the plane across d0. Along the normal this is (kx, ky) = acceptance · (px, py).
    """
    axis = math.sqrt(max(0.0, 1.0 - tilt_x * tilt_x - tilt_y * tilt_y))
    toward = (px * tilt_x + py * tilt_y) / (1.0 + axis)
    cosine = math.sqrt(1.0 - acceptance * acceptance * (px * px + py * py))
    dx = cosine * tilt_x + acceptance * (px - toward * tilt_x)
    dy = cosine * tilt_y + acceptance * (py - toward * tilt_y)
    return dx, dy, -math.sqrt(max(0.0, 1.0 - dx * dx - dy * dy))


@kernel
def _start(scene, source, point, rng):
    """Return the first (element, up, x, y, z, dx, dy, dz, lamp) of a path."""
    x = source.position[point] + (uniform(rng) - 0.5) * source.spot
    length = source.spot_along if source.spot_along > 0.0 else scene.length
    y = source.along[point] + (uniform(rng) - 0.5) * length
    last = len(scene.kind) - 1
    px, py = disk(rng)
    if source.kind == EYE:
        dx, dy, dz = _look(source.tilt_x[point], source.tilt_y[point], source.acceptance, px, py)
        return last, False, x, y, 0.0, dx, dy, dz, NO_LAMP
    dz = math.sqrt(max(0.0, 1.0 - px * px - py * py))
    if source.kind == LAMBERTIAN_BELOW:
        return 0, True, x, y, 0.0, px, py, dz, NO_LAMP
    if len(scene.lamp) > 0:
        x, y, z, dx, dy, dz, lamp = lamp_start(scene.parameter[0], scene.wall, scene.lamp, rng)
        return 0, True, x, y, z, dx, dy, dz, lamp
    # On the tube of the lamp nearest to x = position: a cosine about the outward normal.
    angle = 2.0 * math.pi * uniform(rng)
    cavity = scene.parameter[0]
    nx, nz = math.cos(angle), math.sin(angle)
    dx, dy, dz = lambertian(nx, 0.0, nz, rng)
    z = cavity[3] + cavity[4] * nz
    return 0, True, cavity[2] + cavity[4] * nx, y, z, dx, dy, dz, 0


@kernel
def _cavity(scene, x, y, z, dx, dy, dz, lamp, weight, flow, rng):
    """Follow a ray in the cavity until it leaves or ends: (x, y, dx, dy, dz, weight, radiance)."""
    parameter = scene.parameter[0]
    finite = len(scene.lamp) > 0
    radiance = 0.0
    for _ in range(_MOST_ELEMENTS):
        if finite:
            what, x, y, z, number, centre = panel_hit(
                parameter, scene.wall, scene.lamp, x, y, z, dx, dy, dz, lamp
            )
        else:
            what, x, y, z, number, centre = cavity_hit(parameter, x, y, z, dx, dy, dz, lamp)
        if what == OPENING:
            return x, y, dx, dy, dz, weight, radiance
        if what == LAMP:
            luminance = parameter[5] * (scene.lamp[number, 1] if finite else 1.0)
            radiance += weight * luminance
            flow[_LAMPS] += weight * (1.0 - parameter[6])
            weight *= parameter[6]
            lamp = number
            nx = (x - centre) / parameter[4]
            nz = (z - parameter[3]) / parameter[4]
            dx, dy, dz = lambertian(nx, 0.0, nz, rng)
        elif what == REFLECTOR:
            before = weight
            lamp = NO_LAMP
            table = int(parameter[9])
            if table >= 0:
                _, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
                weight *= survival
                dz = abs(dz)
            else:
                weight *= parameter[7]
                dx, dy, dz = reflector_direction(parameter[8], dx, dy, dz, rng)
            flow[_ELEMENTS] += before - weight
        elif what in (WALL_ACROSS, WALL_ALONG):
            flow[_WALLS] += weight * (1.0 - scene.wall[4])
            weight *= scene.wall[4]
            lamp = NO_LAMP
            dx, dy, dz = wall_direction(what, scene.wall[5], dx, dy, dz, rng)
        elif what == LAMP_END:
            # The ends hold the electrodes: they reflect like the tube and do not shine.
            flow[_LAMPS] += weight * (1.0 - parameter[6])
            weight *= parameter[6]
            lamp = number
            dx, dy, dz = lambertian(0.0, math.copysign(1.0, y), 0.0, rng)
        else:
            break
        weight = _roulette(weight, flow, rng)
        if weight == 0.0:
            return x, y, dx, dy, dz, weight, radiance
    flow[_LOST] += weight
    return x, y, dx, dy, dz, 0.0, radiance


@kernel
def _roulette(weight, flow, rng):
    """End a faint path half of the time, and double it otherwise; `flow` keeps the difference."""
    if weight >= _ROULETTE_BELOW or weight == 0.0:
        return weight
    if uniform(rng) < 0.5:
        flow[_ROULETTE] += weight
        return 0.0
    flow[_ROULETTE] -= weight
    return 2.0 * weight


@kernel
def pass_element(scene, e, up, x, y, z, dx, dy, dz, lamp, weight, flow, rng):
    """Follow a ray through element e: (way, x, y, dx, dy, dz, weight, radiance found).

    `way` is 1 when it leaves upward, -1 downward, 0 when it was lost; z and lamp count for a path
    that starts in the cavity.
    """
    kind = scene.kind[e]
    parameter = scene.parameter[e]
    way = 1
    before = weight
    found = 0.0
    if kind == _CAVITY:
        if lamp == NO_LAMP:
            z = parameter[0]
        x, y, dx, dy, dz, weight, found = _cavity(
            scene, x, y, z, dx, dy, dz, lamp, weight, flow, rng
        )
        before = weight
    elif kind == _SLAB:
        way, x, y, dx, dy, dz, survival = slab_passage(
            scene.phase, parameter, up, x, y, dx, dy, dz, rng
        )
        weight *= survival
    elif kind == _SHEET:
        passed, dx, dy, dz = sheet_passage(parameter[0], parameter[1], dx, dy, dz, rng)
        weight *= parameter[2]
        way = 1 if passed == up else -1
    elif kind == _BSDF:
        passed, dx, dy, dz, survival = bsdf_passage(scene.bsdf, int(parameter[0]), dx, dy, dz, rng)
        weight *= survival
        way = 1 if passed == up else -1
    else:
        way, x, y, dx, dy, dz = placed_film_passage(
            scene.tiles, scene.phase, parameter, up, x, y, dx, dy, dz, rng
        )
    flow[_ELEMENTS + e] += before - weight
    return way, x, y, dx, dy, dz, weight, found


@kernel
def _begin(scene, source, seed, stream, path, slot, number, wave):
    """Put a new path into a slot and before its first element."""
    rng = wave.rng[slot]
    start_path(rng, seed, stream, path)
    point = path % uint64(len(source.position))
    e, up, x, y, z, dx, dy, dz, lamp = _start(scene, source, point, rng)
    place = wave.place[slot]
    place[0], place[1], place[2], place[3], place[4], place[5] = x, y, z, dx, dy, dz
    wave.weight[slot] = 1.0
    wave.radiance[slot] = 0.0
    wave.upward[slot] = 1 if up else 0
    wave.lamp[slot] = lamp
    wave.path[slot] = number
    for f in range(wave.once.shape[1]):
        wave.once[slot, f] = 0.0
    enqueue(wave, e, slot)


@kernel
def _pass_queue(scene, e, rays, wave):
    """Follow the rays that wait before element e through it."""
    if scene.kind[e] == _FILM:
        tile = tile_of(scene.tiles, int(scene.parameter[e, TILE]))
        # Resin that scatters is followed ray by ray.
        if tile.accelerator == CHAIN and scene.parameter[e, RESIN] == 0.0:
            _pass_film(tile, scene.parameter[e], rays, wave)
            return
    for slot in rays:
        p = wave.place[slot]
        way, p[0], p[1], p[3], p[4], p[5], wave.weight[slot], found = pass_element(
            scene, e, wave.upward[slot] != 0, p[0], p[1], p[2], p[3], p[4], p[5],
            wave.lamp[slot], wave.weight[slot], wave.once[slot], wave.rng[slot],
        )  # fmt: skip
        wave.way[slot] = way
        wave.lamp[slot] = NO_LAMP
        wave.radiance[slot] += found


@kernel
def _pass_film(tile, film, rays, wave):
    """Follow rays through an extruded film as it lies in the stack."""
    placed = film[3] != 1.0 or film[5] != 0.0
    if placed:
        for slot in rays:
            p = wave.place[slot]
            up, p[0], p[1], p[3], p[4], p[5] = into_film(
                film, tile.width, wave.upward[slot] != 0, p[0], p[1], p[3], p[4], p[5]
            )
            wave.upward[slot] = 1 if up else 0
    film_passages(
        tile, film[0], film[1], film[2],
        rays, wave.place, wave.upward, wave.way, wave.rng, wave.lane_float, wave.lane_whole,
    )  # fmt: skip
    if placed:
        for slot in rays:
            p = wave.place[slot]
            wave.way[slot], p[0], p[1], p[3], p[4], p[5] = out_of_film(
                film, tile.width, wave.way[slot], p[0], p[1], p[3], p[4], p[5]
            )


@kernel
def _go_on(scene, e, slot, wave):
    """Move a ray that has left element e before the next; return whether its path goes on."""
    once = wave.once[slot]
    way = wave.way[slot]
    if way == 0:
        once[_LOST] += wave.weight[slot]
        return False
    x, y, wall = wave.place[slot, 0], wave.place[slot, 1], scene.wall
    if not (wall[0] <= x <= wall[1] and wall[2] <= y <= wall[3]):
        once[_RIM] += wave.weight[slot]
        return False
    weight = _roulette(wave.weight[slot], once, wave.rng[slot])
    wave.weight[slot] = weight
    if weight == 0.0:
        return False
    e += way
    if e < 0:
        once[_DOWN] += weight
        wave.radiance[slot] += weight * scene.below
        return False
    if e == len(scene.kind):
        once[_UP] += weight
        wave.radiance[slot] += weight * scene.above
        return False
    wave.upward[slot] = 1 if way > 0 else 0
    enqueue(wave, e, slot)
    return True


@njit(nogil=True, cache=True, error_model="numpy", _nrt=False)
def trace_paths(scene, source, seed, stream, first, wave, radiance, flow, flow2):
    """Follow paths `first` and on, and put what each collects into radiance (n,).

    Paths go round the points. flow, flow2 (f,) get the sums of where the weights went and of their
    squares; `wave` is scratch. A scene without elements has no paths.
    """
    started = min(len(wave.way), len(radiance))
    for slot in range(started):
        _begin(scene, source, seed, stream, first + uint64(slot), slot, slot, wave)
    while True:
        e, waiting = longest_queue(wave)
        if waiting == 0:
            return
        rays = wave.batch[:waiting]
        for i in range(waiting):
            rays[i] = wave.queue[e, i]
        wave.length[e] = 0
        _pass_queue(scene, e, rays, wave)
        for slot in rays:
            if _go_on(scene, e, slot, wave):
                continue
            radiance[wave.path[slot]] = wave.radiance[slot]
            for f in range(len(flow)):
                flow[f] += wave.once[slot, f]
                flow2[f] += wave.once[slot, f] * wave.once[slot, f]
            if started < len(radiance):
                path = first + uint64(started)
                _begin(scene, source, seed, stream, path, slot, started, wave)
                started += 1


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
    flows = len(FLOWS) + len(scene.kind)

    def one(block: int) -> Tally:
        radiance = np.empty((BLOCK, points))
        flow, flow2 = np.zeros(flows), np.zeros(flows)
        trace_paths(
            scene, source, np.uint64(seed), np.uint64(source.kind),
            np.uint64(block * radiance.size), Wave.empty(len(scene.kind), flows),
            radiance.reshape(-1), flow, flow2,
        )  # fmt: skip
        return Tally(radiance.sum(axis=0), (radiance**2).sum(axis=0), flow, flow2, BLOCK)

    total = Tally.empty(points, flows)
    with ThreadPoolExecutor(threads) as pool:
        jobs = [pool.submit(one, block) for block in range(first, first + blocks)]
        try:
            for job in jobs:
                total = total + job.result()
                if after_block:
                    after_block()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return total
