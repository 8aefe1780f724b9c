"""Short traces between two meetings with the film, and through the film alone: the kernels."""

import math

from mpfcad.optics.base.kernel import entry, kernel
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import disk, start_path, uniform
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.film.passage import TILE
from mpfcad.optics.passage import pass_element

#: Streams of random numbers, apart from those of the engine's sources.
WORLD_STREAM, FILM_STREAM, METER_STREAM = 101, 102, 103
_MOST_ELEMENTS = 1_000_000
ABOVE, BELOW, GONE = 1, -1, 0


@kernel
def _direction_cell(number, kx, ky):
    """Return the number of the direction cell that holds (kx, |ky|)."""
    across, along = number.shape
    i = min(across - 1, max(0, int((kx + 1.0) * 0.5 * across)))
    j = min(along - 1, max(0, int(abs(ky) * along)))
    while number[i, j] < 0 and j > 0:
        j -= 1
    return number[i, j]


@kernel
def _start_direction(corner, d, across, along, rng):
    """Return a direction uniform in the part of a cell inside the unit disk: (kx, ky, |kz|)."""
    for _ in range(1000):
        kx = corner[d, 0] + uniform(rng) * 2.0 / across
        ky = corner[d, 1] + uniform(rng) / along
        rest = 1.0 - kx * kx - ky * ky
        if rest > 1e-9:
            break
    ky = math.copysign(ky, uniform(rng) - 0.5)
    return kx, ky, math.sqrt(max(rest, 1e-9))


@kernel
def _to_film(scene, film, e, up, x, dx, dy, dz, flow, rng):
    """Follow a ray from element `e` until it meets the film: (side, x, dx, dy, weight, radiance).

    `side` is `BELOW` or `ABOVE`, whence it meets the film, or `GONE`.
    """
    y = 0.0
    weight, radiance = 1.0, 0.0
    count = len(scene.kind)
    for _ in range(_MOST_ELEMENTS):
        if e < 0 or e == count or weight == 0.0:
            return GONE, x, dx, dy, weight, radiance
        if e == film:
            return (BELOW if up else ABOVE), x, dx, dy, weight, radiance
        way, x, y, dx, dy, dz, weight, found = pass_element(
            scene, e, up, x, y, 0.0, dx, dy, dz, NO_LAMP, weight, flow, None, None, None, rng
        )
        radiance += found
        if way == 0:
            return GONE, x, dx, dy, 0.0, radiance
        up = way > 0
        e += way
    return GONE, x, dx, dy, 0.0, radiance


@entry
def trace_world(
    scene, film, up, pitch, cells, number, corner, seed, first, samples, rng, flow,
    target, weight, radiance,
):  # fmt: skip
    """Trace `samples` rays from each state of cells `first` … that leave the film up or down.

    target (n, d, samples) int64: the state in which each meets the film again, those from above
    after those from below, or -1; weight, radiance: the same shape, float64.
    """
    across, along = number.shape
    d_count = len(corner)
    for cell in range(target.shape[0]):
        for d in range(d_count):
            for s in range(samples):
                state = (first + cell) * d_count + d
                start_path(rng, seed, WORLD_STREAM + (10 if up else 0), state * samples + s)
                x = (first + cell + (s + uniform(rng)) / samples) * pitch / cells
                kx, ky, kz = _start_direction(corner, d, across, along, rng)
                e = film + 1 if up else film - 1
                side, x, kx, ky, w, found = _to_film(
                    scene, film, e, up, x, kx, ky, kz if up else -kz, flow, rng
                )
                radiance[cell, d, s] = found
                weight[cell, d, s] = w
                target[cell, d, s] = -1
                if side != GONE:
                    turn = x / pitch - math.floor(x / pitch)
                    place = min(cells - 1, int(turn * cells))
                    arrival = place * d_count + _direction_cell(number, kx, ky)
                    target[cell, d, s] = arrival + (0 if side == BELOW else cells * d_count)


@entry
def trace_film(
    scene, film, acceptance, number, corner, seed, first, samples, rng, flow, found
):  # fmt: skip
    """Send `samples` rays a direction through the film alone and count how they leave.

    found (n, 2d) float64: rows are entries `first` … : d directions from below, d from above, the
    meter's cone from above; columns d directions upward, then d downward.
    """
    across, along = number.shape
    d_count = len(corner)
    for row in range(found.shape[0]):
        entry = first + row
        up = entry < d_count
        for s in range(samples):
            start_path(rng, seed, FILM_STREAM, entry * samples + s)
            x = (s + uniform(rng)) / samples * scene.tiles.size[int(scene.parameter[film, TILE]), 0]
            if entry == 2 * d_count:
                px, py = disk(rng)
                kx, ky = acceptance * px, acceptance * py
                kz = math.sqrt(1.0 - kx * kx - ky * ky)
            else:
                kx, ky, kz = _start_direction(corner, entry % d_count, across, along, rng)
            way, x, _, kx, ky, kz, weight, _ = pass_element(
                scene,
                film,
                up,
                x,
                0.0,
                0.0,
                kx,
                ky,
                kz if up else -kz,
                NO_LAMP,
                1.0,
                flow,
                None,
                None,
                None,
                rng,
            )
            if way != 0:
                column = _direction_cell(number, kx, ky) + (0 if way > 0 else d_count)
                found[row, column] += weight


@entry
def trace_meter(scene, film, acceptance, number, seed, samples, rng, flow, found):
    """Send `samples` rays of the meter down to the film; found (d,) gets where they meet it."""
    for s in range(samples):
        start_path(rng, seed, METER_STREAM, s)
        px, py = disk(rng)
        kx, ky = acceptance * px, acceptance * py
        kz = math.sqrt(1.0 - kx * kx - ky * ky)
        e = len(scene.kind) - 1
        side, _, kx, ky, weight, _ = _to_film(scene, film, e, False, 0.0, kx, ky, -kz, flow, rng)
        if side == ABOVE:
            found[_direction_cell(number, kx, ky)] += weight


#: Scratch of the kernels that roulette writes to.
FLOW_SIZE = len(FLOWS) + 64
