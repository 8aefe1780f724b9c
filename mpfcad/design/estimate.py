"""Estimates the operators of the two-scale model by short traces."""

import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.cad import write_stl
from mpfcad.design.grid import Grid
from mpfcad.design.response import Operators
from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm, Profile
from mpfcad.units import deg

if TYPE_CHECKING:
    from mpfcad.optics.scene import Scene
    from mpfcad.optics.solid.mesh import FilmMesh

#: Rays a state through the world, a direction through the film, and from the meter.
WORLD_SAMPLES, FILM_SAMPLES, METER_SAMPLES = 192, 1024, 65536
_FACET_ANGLE = 0.5 * deg
_ROWS = 16


def estimate_operators(
    stack: Stack,
    groove: Groove,
    base: float,
    profile: Profile,
    node: NDArray[np.float64],
    *,
    grid: Grid | None = None,
    seed: int = 1,
    threads: int = 1,
    progress: Callable[[str], None] | None = None,
) -> Operators:
    """Return the operators of a backlight and of films of curvatures `node` [1/mm].

    `base` [mm] is the film's thickness below the valleys. The same seed gives the same operators
    at any number of threads.
    """
    grid = grid or Grid()
    tell = progress or (lambda text: None)
    with tempfile.TemporaryDirectory() as folder:
        films = []
        if stack.needs_prism:
            stack = stack.with_prism(_write_prism(groove, base, profile, Path(folder)))
        for i, curvature in enumerate(node):
            tell(f"tracing the film alone, C = {curvature:g} /mm")
            film = _film_mesh(groove, base, profile, curvature, Path(folder))
            films.append(_trace_film(film, stack, grid, seed, threads))
            if i == 0:
                tell("tracing the backlight around the film")
                world, radiance, meter, segments = _trace_world(film, stack, grid, seed, threads)
    passages = len(node) * (2 * grid.directions + 1) * FILM_SAMPLES
    return Operators(grid, node, np.array(films), world, radiance, meter, passages, segments)


def _film_mesh(
    groove: Groove, base: float, profile: Profile, curvature: float, folder: Path
) -> "FilmMesh":
    """Return a groove of a uniform film as the tracer reads its mesh from disk."""
    from mpfcad.optics.solid.mesh import read_film_mesh

    film = PrismFilm(groove, base, 1.0, profile, np.array([curvature]))
    write_stl(film, folder / "groove.stl", _FACET_ANGLE)
    return read_film_mesh(folder / "groove.stl")


def _write_prism(groove: Groove, base: float, profile: Profile, folder: Path) -> Path:
    """Return the file of a groove without resin."""
    if profile != "filled":
        raise InputError(f"film.profile: {profile}: has no resin of its own: expected 'filled'")
    film = PrismFilm(groove, base, 1.0, profile, np.array([groove.curvature_empty]))
    write_stl(film, folder / "prism.stl", _FACET_ANGLE)
    return folder / "prism.stl"


def _scene(mesh: "FilmMesh", stack: Stack) -> "tuple[Scene, int]":
    """Return the scene and the film's number in it."""
    from mpfcad.backlight.lower import lower_stack
    from mpfcad.optics.element import FILM
    from mpfcad.optics.scene import build_scene

    if stack.polarised:
        raise InputError(
            f"{stack.name}: light.polarised: the model of a film in its backlight has no "
            "polarisation: expected false"
        )
    if stack.bands is not None:
        raise InputError(
            f"{stack.name}: light.bands: the model of a film in its backlight has one wavelength: "
            "expected no bands"
        )
    scene = build_scene(lower_stack(stack, mesh))
    return scene, int(np.flatnonzero(scene.kind == FILM)[0])


def _trace_film(
    mesh: "FilmMesh", stack: Stack, grid: Grid, seed: int, threads: int
) -> NDArray[np.float64]:
    """Return the shares of a uniform film, (2d+1, 2d), the same for mirrored directions."""
    from mpfcad.design.passage import FLOW_SIZE, trace_film
    from mpfcad.optics.base.sampling import RNG_SIZE

    scene, film = _scene(mesh, stack)
    d = grid.directions

    def rows(first: int) -> NDArray[np.float64]:
        found = np.zeros((min(_ROWS, 2 * d + 1 - first), 2 * d))
        trace_film(
            scene, film, stack.acceptance, grid.number, grid.corner, np.uint64(seed), first,
            FILM_SAMPLES, np.zeros(RNG_SIZE, np.uint64), np.zeros(FLOW_SIZE), found,
        )  # fmt: skip
        return found / FILM_SAMPLES

    with ThreadPoolExecutor(threads) as pool:
        share = np.concatenate(list(pool.map(rows, range(0, 2 * d + 1, _ROWS))))
    column = np.concatenate([grid.mirrored, grid.mirrored + d])
    row = np.append(column, 2 * d)
    return (share + share[np.ix_(row, column)]) / 2


def _trace_world(
    mesh: "FilmMesh", stack: Stack, grid: Grid, seed: int, threads: int
) -> tuple[Any, NDArray[np.float64], NDArray[np.float64], int]:
    """Return (T, r, g, rays traced)."""
    from scipy.sparse import coo_array

    from mpfcad.design.passage import FLOW_SIZE, trace_meter, trace_world
    from mpfcad.optics.base.sampling import RNG_SIZE

    scene, film = _scene(mesh, stack)
    cells, d = grid.cells, grid.directions
    last = len(scene.kind) - 1
    n = cells * d

    def one(job: tuple[bool, int]) -> Any:
        up, first = job
        shape = (1, d, WORLD_SAMPLES)
        target = np.empty(shape, np.int64)
        weight, radiance = np.empty(shape), np.empty(shape)
        trace_world(
            scene, film, up, stack.period.across, cells, grid.number, grid.corner, np.uint64(seed),
            first, WORLD_SAMPLES, np.zeros(RNG_SIZE, np.uint64), np.zeros(FLOW_SIZE),
            target, weight, radiance,
        )  # fmt: skip
        return target, weight, radiance

    ways = [True, False] if film < last else [False]
    jobs = [(up, first) for up in ways for first in range(cells)]
    with ThreadPoolExecutor(threads) as pool:
        found = list(pool.map(one, jobs))
    radiance = np.zeros(2 * n)
    row, column, value = [], [], []
    image = np.concatenate([grid.mirrored_state, grid.mirrored_state + n])
    for (up, first), (target, weight, light) in zip(jobs, found, strict=True):
        state = first * d + np.arange(d) + (0 if up else n)
        radiance[state] = light[0].mean(axis=1)
        met = target >= 0
        row.append(np.broadcast_to(state[None, :, None], target.shape)[met])
        column.append(target[met])
        value.append(weight[met] / WORLD_SAMPLES)
    rows, columns, values = np.concatenate(row), np.concatenate(column), np.concatenate(value)
    # Half from each ray, half from its mirror image.
    place = np.concatenate([rows, image[rows]]), np.concatenate([columns, image[columns]])
    world = coo_array((np.tile(values / 2, 2), place), (2 * n, 2 * n)).tocsr()
    meter = np.zeros(d + 1)
    if film == last:
        meter[d] = 1.0
    else:
        trace_meter(
            scene, film, stack.acceptance, grid.number, np.uint64(seed), METER_SAMPLES,
            np.zeros(RNG_SIZE, np.uint64), np.zeros(FLOW_SIZE), meter,
        )  # fmt: skip
        meter[:d] = (meter[:d] + meter[grid.mirrored]) / 2 / METER_SAMPLES
    segments = len(jobs) * d * WORLD_SAMPLES + METER_SAMPLES * (film < last)
    return world, (radiance + radiance[image]) / 2, meter, segments
