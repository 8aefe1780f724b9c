"""Eight rays in one vector do what each of them does alone, bit by bit."""

import functools

import numpy as np
import pytest
from harness import (
    BARE,
    CONCAVE,
    REENTRANT,
    SECTIONS,
    aimed,
    compiled,
    crossed_mesh,
    dish_mesh,
    drawn,
    edge_rays,
    film_mesh,
    groove,
    pass_film,
    row,
    section_mesh,
    single_paths,
    write_facets,
)
from numba import njit

from mpfcad.optics.base import lanes, lanes_array
from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE, start_path
from mpfcad.optics.element import Film
from mpfcad.optics.film.chain_lanes import PLACE_SIZE, film_passages
from mpfcad.optics.film.section_lanes import section_passages
from mpfcad.optics.scene import build_scene
from mpfcad.optics.search.bvh.build import build_bvh
from mpfcad.optics.search.bvh.walk import closest_facets
from mpfcad.optics.search.grid.build import build_grid
from mpfcad.optics.search.grid.walk import Walk, walk_on
from mpfcad.optics.search.seam import with_seam
from mpfcad.optics.search.tile import build_tile
from mpfcad.optics.search.tile_table import build_tile_table
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source
from mpfcad.optics.wave import Wave
from mpfcad.store.kernel import kept


@kept
@njit(error_model="numpy", _nrt=False)
def _many(values, table, out):
    x, y = lanes_array.load(values, 0), lanes_array.load(values, 1)
    reflectance, cosine = fresnel(x, 0.5 + y)
    lanes_array.store(out, 0, reflectance)
    lanes_array.store(out, 1, cosine)
    place = lanes.whole(lanes.floor(y * 4.0))
    lanes_array.store(out, 2, lanes_array.gather(table[1], place))
    a, b, c, d = lanes_array.gather_row(table, place)
    lanes_array.store(out, 3, a - b + c * d)
    lanes_array.store(out, 4, lanes.select((x > y) ^ (x < 0.5), lanes.root(x), -y / 3.0))
    lanes_array.store(out, 5, lanes.real((place << 3) ^ 5) + lanes.copy_sign(x, y - 0.5))


@kept
@njit(error_model="numpy", _nrt=False)
def _single(x, y):
    return fresnel(x, 0.5 + y)


def test_operations_are_those_of_plain_numbers():
    rng = np.random.default_rng(1)
    values, table, out = rng.random((2, 8)), rng.random((8, 4)), np.empty((6, 8))
    _many(values, table, out)
    x, y = values
    alone = np.array([_single(a, b) for a, b in zip(x, y, strict=True)]).T
    assert (out[:2] == alone).all()
    place = np.floor(y * 4).astype(int)
    a, b, c, d = table[place].T
    assert (out[2] == table[1][place]).all()
    assert (out[3] == a - b + c * d).all()
    assert (out[4] == np.where((x > y) ^ (x < 0.5), np.sqrt(x), -y / 3)).all()
    assert (out[5] == ((place << 3) ^ 5) + np.copysign(x, y - 0.5)).all()


@kept
@njit(error_model="numpy", _nrt=False)
def _wide(index, values, whole, out, half, numbers):
    row = lanes_array.load_wide(index, 0)
    a, b, c, d, e, f, g, h = lanes_array.gather_line(values, row)
    p, q, r, s = lanes_array.gather_half(values, row)
    reflectance, cosine = fresnel(a, 0.5 + b)
    low = a < lanes.select(b < 0.5, c, 2.0)
    lanes_array.scatter_line(out, row, reflectance, cosine, e, f, -g, h / 3.0, p + q, lanes.root(d))
    lanes_array.scatter_half(half, row, p, q, lanes.select(low, r, s), lanes.copy_sign(s, a - b))
    filled = lanes_array.expand(whole, 2, low, row)
    lanes_array.put(numbers, row, filled)
    return lanes.bits(low), lanes.count_of(low), lanes.any_of(low)


def test_sixteen_lanes_are_as_many_plain_numbers():
    rng = np.random.default_rng(2)
    index, values = rng.permutation(20)[:16], rng.random((20, 8))
    out, half = np.zeros((2, 20, 8))
    numbers, whole = np.zeros(20, np.int64), 100 + np.arange(30)
    mask, count, some = _wide(index, values, whole, out, half, numbers)
    a, b, c, d, e, f, g, h = values[index].T
    low = a < np.where(b < 0.5, c, 2.0)
    expected = [*np.array([_single(*ab) for ab in zip(a, b, strict=True)]).T, e, f]
    expected += [-g, h / 3, e + f, np.sqrt(d)]
    assert (out[index] == np.array(expected).T).all()
    assert ([e, f, np.where(low, g, h), np.copysign(h, a - b)] == half[index, 4:].T).all()
    assert (half[:, :4] == 0).all()
    assert (np.delete(out, index, axis=0) == 0).all()
    assert (np.delete(half, index, axis=0) == 0).all()
    assert (mask, count, some) == (int(np.sum(low << np.arange(16))), low.sum(), True)
    filled = index.copy()
    filled[low] = whole[2 : 2 + low.sum()]
    assert (numbers[index] == filled).all()


@kept
@njit(error_model="numpy")
def _starts(rng, seed):
    for i in range(len(rng)):
        start_path(rng[i], np.uint64(seed), np.uint64(8), np.uint64(i))


def any_rays(mesh, count, up):
    """Return rays (n, 5), their places, generators and ways as a wave holds them."""
    random = np.random.default_rng(2).random((count, 4))
    k, angle = np.sqrt(random[:, 2]) * 0.999999, 2 * np.pi * random[:, 3]
    start = np.empty((count, 5))
    start[:, :2] = random[:, :2] * mesh.size[:2]
    start[:, 2], start[:, 3] = k * np.cos(angle), k * np.sin(angle)
    start[:, 4] = np.sqrt(1 - k * k) * (1 if up else -1)
    # The last row is that of lanes without a ray.
    place = np.zeros((count + 1, PLACE_SIZE))
    place[:-1, :2], place[:-1, 3:6] = start[:, :2], start[:, 2:]
    rng = np.zeros((count + 1, RNG_SIZE), np.uint64)
    _starts(rng, 3)
    return start, place, rng, np.zeros(count + 1, np.int64)


def _scratch():
    """Return the scratch of a wave that a film's passages need."""
    wave = Wave.empty(1)
    return wave.lane_row, wave.waiting


@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize("count", [1, 7, 5000])
def test_rays_through_a_film_are_the_same_alone_and_eight_at_a_time(tmp_path, up, count):
    mesh = film_mesh(tmp_path, [BARE, CONCAVE, groove(57.0), groove(40.0001)])
    tile = build_tile(mesh)
    start, place, rng, way = any_rays(mesh, count, up)
    alone = np.empty((count, 4))
    pass_film(build_tile_table([tile]), 1.5, up, start, 3, alone)
    compiled(film_passages)(tile, 1.5, 1.0, 0.0, np.arange(count), place, way, rng, *_scratch())
    assert (way[:-1] == alone[:, 0]).all()
    # The underside turns a ray by one formula alone and by that of all facets in the lanes.
    assert np.abs(place[:-1, 3:6] - alone[:, 1:]).max() < 1e-9


@functools.cache
def _section_passages():
    return compiled(section_passages)


def eight_at_a_time(mesh, place, rng, up):
    """Return the way (n,) and direction (n, 3) of rays that have passed a section."""
    tile = build_tile(mesh, "section")
    assert len(tile.layers.part)
    way = np.zeros(len(place), np.int64)
    _section_passages()(
        tile, 1.5, 1.0, 0.0, np.arange(len(place) - 1), place, way, rng, *_scratch()
    )
    return way[:-1], place[:-1, 3:6]


SOLIDS = {
    "boxes": ([(0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1)], [(0, 0.13), (0.1, 0.13), (0.1, 0.2),
              (0, 0.2)], [(0.03, 0.05), (0.03, 0.07), (0.06, 0.07), (0.06, 0.05)]),
    "re-entrant": (np.c_[np.append(row([REENTRANT] * 2, 0.15)[0], [0.1, 0]),
                         np.append(row([REENTRANT] * 2, 0.15)[1], [0, 0])][::-1],),
}  # fmt: skip


def solid_mesh(folder, name):
    if name in SECTIONS:
        return section_mesh(folder, name)
    return read_film_mesh(write_facets(folder / "solid.stl", drawn(SOLIDS[name], 0.1)))


@pytest.mark.parametrize("name", [*SECTIONS, *SOLIDS])
def test_rays_through_a_section_are_the_same_alone_and_eight_at_a_time(tmp_path, name):
    mesh = solid_mesh(tmp_path, name)
    for up in (True, False):
        for count in (1, 7, 5000):
            start, place, rng, _ = any_rays(mesh, count, up)
            alone = np.empty((count, 4))
            pass_film(build_tile_table([build_tile(mesh, "section")]), 1.5, up, start, 3, alone)
            way, direction = eight_at_a_time(mesh, place, rng, up)
            assert (way != 0).all()
            assert np.array_equal(way, alone[:, 0])
            assert np.abs(direction - alone[:, 1:]).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "size"),
    [("grooves below", 0.17), ("rods under grooves", 0.17), ("sheet under a film", 0.03),
     ("undercut", None)],
)  # fmt: skip
def test_the_range_that_rays_go_over_at_once_holds_no_surface(tmp_path, name, size):
    mesh = section_mesh(tmp_path, name)
    layers = build_tile(mesh, "section").layers
    _, low, high = layers.lean
    if size is None:
        assert low > high
        return
    assert high - low == pytest.approx(0.998 * size, abs=1e-6)
    ends = mesh.vertex[mesh.top][:, :, 2]
    assert ((ends.max(axis=1) < low) | (ends.min(axis=1) > high)).all()
    # Of each strip the part below it and that above.
    part, turn = layers.part, layers.range[:, 5]
    height = np.where(turn < 0, -1, 1) * part[:, 1]
    below = layers.strip[:, 3].astype(int)
    assert (height[below] < low).all()
    assert (height[below + 1] > high).all()


@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize("name", [*SECTIONS, *SOLIDS])
def test_no_ray_aimed_at_a_vertex_of_a_section_is_lost_among_eight(tmp_path, name, up):
    mesh = solid_mesh(tmp_path, name)
    start = np.concatenate([edge_rays(mesh, up), aimed(mesh, up)])
    _, place, rng, _ = any_rays(mesh, len(start), up)
    place[:-1, :2], place[:-1, 3:6] = start[:, :2], start[:, 2:]
    way, direction = eight_at_a_time(mesh, place, rng, up)
    assert (way != 0).all(), start[way == 0][0]
    assert np.abs((direction**2).sum(axis=1) - 1).max() < 1e-9
    assert (np.sign(direction[:, 2]) == way).all()


@pytest.mark.parametrize("source", [LAMBERTIAN_BELOW, EYE])
@pytest.mark.parametrize("shape", ["leaning", "dishes"])
def test_paths_over_a_grid_eight_at_a_time_are_those_by_the_tree_one_by_one(
    tmp_path, shape, source
):
    mesh = dish_mesh() if shape == "dishes" else crossed_mesh(tmp_path)
    start = Source(source, np.array([0.1]), 0.05, 0.3, -0.4, 0.8)
    found, flow = np.empty((2, 5000)), np.zeros((2, len(FLOWS) + 1))
    for i, accelerator in enumerate(("grid", "bvh")):
        scene = build_scene([Film(mesh, 1.5, accelerator=accelerator)], below=1.0, above=0.3)
        single_paths(scene, start, 1, 0, found[i], flow[i])
    assert np.array_equal(*found)
    assert np.array_equal(*flow)


@kept
@njit(error_model="numpy", _nrt=False)
def _wait_in(grid, column, walking):
    walk = Walk(
        0.0, 0.0, 1.0, 1.0, 1.0, -1, True, 0.0, 0.0, 1.0, 0.0, column, 0.0, 0.0, 0.0, 0.0, 0.0,
    )  # fmt: skip
    walk, walking = walk_on(grid, walk, 0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 1.0, 1e-12, walking)
    return walk.place, walk.best, walking


@pytest.mark.parametrize("column", [-1e12, 0.0, 1e12])
def test_a_ray_that_waits_for_others_reads_no_cell_outside_the_grid(column):
    # It is stepped on with them, away from the grid; so far out a read would end the process.
    assert _wait_in(build_grid(dish_mesh()), column, False) == (-1, 1.0, False)


def test_the_tree_finds_the_facet_that_trying_all_finds(tmp_path):
    mesh = crossed_mesh(tmp_path)
    tree = build_bvh(mesh)
    random = np.random.default_rng(4).random((2000, 4))
    origin = random[:, :3] * [*mesh.size[:2], 0.0]
    k, phi = np.sqrt(random[:, 2]), 2 * np.pi * random[:, 3]
    direction = np.stack([k * np.cos(phi), k * np.sin(phi), np.sqrt(1 - k * k)], axis=1)
    found = np.empty(len(origin), np.int64)
    closest_facets(tree, origin, direction, found)
    corner, number = with_seam(mesh.vertex[mesh.top], *mesh.size[:2])
    a, b, c = (corner[None, :, i] - origin[:, None] for i in range(3))
    d = direction[:, None]
    sides = [np.einsum("ijk,ijk->ij", np.broadcast_to(d, p.shape), np.cross(p, q))
             for p, q in ((b, c), (c, a), (a, b))]  # fmt: skip
    met = np.all([s >= 0 for s in sides], axis=0)
    normal = np.cross(b - a, c - a)
    distance = np.einsum("ijk,ijk->ij", a, normal) / np.einsum("ijk,ijk->ij", d * 1.0, normal)
    distance = np.where(met & (distance >= 0), distance, np.inf)
    expected = np.where(np.isfinite(distance.min(axis=1)), number[distance.argmin(axis=1)], -1)
    assert (found == expected).all()
    assert (found >= 0).mean() > 0.1
