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
from mpfcad.optics.film import placed_film_passage
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
from mpfcad.optics.sampling import RNG_SIZE, disk, start_path, uniform
from mpfcad.optics.scene import Scene
from mpfcad.optics.sheet import sheet_passage
from mpfcad.optics.slab import slab_passage

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
def trace_path(scene, source, point, flow, rng):
    """Follow one path and return the radiance it collects; `flow` gets where its weight went."""
    e, up, x, y, z, dx, dy, dz, lamp = _start(scene, source, point, rng)
    weight = 1.0
    radiance = 0.0
    count = len(scene.kind)
    wall = scene.wall
    for _ in range(_MOST_ELEMENTS):
        if e < 0:
            flow[_DOWN] += weight
            return radiance + weight * scene.below
        if e == count:
            flow[_UP] += weight
            return radiance + weight * scene.above
        way, x, y, dx, dy, dz, weight, found = pass_element(
            scene, e, up, x, y, z, dx, dy, dz, lamp, weight, flow, rng
        )
        lamp = NO_LAMP
        radiance += found
        if way == 0:
            flow[_LOST] += weight
            return radiance
        if not (wall[0] <= x <= wall[1] and wall[2] <= y <= wall[3]):
            flow[_RIM] += weight
            return radiance
        weight = _roulette(weight, flow, rng)
        if weight == 0.0:
            return radiance
        up = way > 0
        e += way
    flow[_LOST] += weight
    return radiance


@njit(nogil=True, cache=True, error_model="numpy", _nrt=False)
def trace_block(scene, source, seed, stream, block, rng, once, score, score2, flow, flow2):
    """Trace one block, `BLOCK` paths a point, and add to its sums.

    score, score2: (p,) radiance and its square; flow, flow2: (f,) the same of the weights' ends.
    rng (8,) uint64 and once (f,) are scratch.
    """
    points = len(source.position)
    for i in range(BLOCK):
        for point in range(points):
            start_path(rng, seed, stream, uint64((block * BLOCK + i) * points + point))
            for f in range(len(once)):
                once[f] = 0.0
            radiance = trace_path(scene, source, point, once, rng)
            score[point] += radiance
            score2[point] += radiance * radiance
            for f in range(len(once)):
                flow[f] += once[f]
                flow2[f] += once[f] * once[f]


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
        tally = Tally.empty(points, flows)
        trace_block(
            scene, source, np.uint64(seed), np.uint64(source.kind), np.int64(block),
            np.zeros(RNG_SIZE, np.uint64), np.zeros(flows),
            tally.score, tally.score2, tally.flow, tally.flow2,
        )  # fmt: skip
        return tally._replace(paths=BLOCK)

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
