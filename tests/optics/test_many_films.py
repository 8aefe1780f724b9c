"""Several films in one stack: crossed, askew, upside down; compiled once, equal to the oracle."""

from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, crossed_mesh, film_mesh, groove, pass_layers, single_paths
from oracle.tracer import Philox, ReferenceTracer

from mpfcad.errors import TraceError
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace, trace_paths
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
SHEET = Sheet(0.3, 1.49, 1.0)
#: Grooves that are not the same from left and right, so that a mirrored film would be noticed.
LEANING = (np.array([-0.025, -0.012, 0.004, 0.025]), np.array([0.025, 0.003, 0.001, 0.025]))
CROSSED = np.pi / 2


def turned_mesh(mesh):
    """Return the mesh turned by +90° about z."""
    width, length, thickness = mesh.size
    x, y, z = mesh.vertex.T
    return FilmMesh(np.stack([length - y, x, z], axis=1), mesh.top, (length, width, thickness))


def light(elements, enter_below=True, count=4000, seed=3):
    out = np.empty((count, 4))
    pass_layers(build_scene(elements), enter_below, seed, out)
    assert (out[:, 0] != 0).all()
    return out


@pytest.mark.parametrize("below", [True, False])
def test_a_crossed_film_is_the_film_with_its_mesh_turned(tmp_path, below):
    mesh = film_mesh(tmp_path, [LEANING, groove(60.0, chords=5)], length=0.1)
    crossed = light([Film(mesh, 1.5, rotation=CROSSED)], below)
    turned = light([Film(turned_mesh(mesh), 1.5)], below)
    assert np.abs(crossed - turned).max() < 1e-9
    assert np.abs(crossed - light([Film(mesh, 1.5)], below)).max() > 0.1


@pytest.mark.parametrize("below", [True, False])
def test_a_film_upside_down_is_the_film_seen_from_the_other_side(tmp_path, below):
    # The same light, mirrored in z and x, into the upright film: pass_layers enters about x = 0.37
    # of the tile, so a tile with a mirrored mesh meets the same rays.
    mesh = film_mesh(tmp_path, [LEANING, groove(60.0, chords=5)])
    down = light([Film(mesh, 1.5, flipped=True)], below)
    width = mesh.size[0]
    mirrored = FilmMesh(mesh.vertex * (-1, 1, 1) + (width, 0, 0), mesh.top[:, ::-1], mesh.size)
    up = light([Film(mirrored, 1.5)], not below)
    assert np.array_equal(down[:, 0], -up[:, 0])
    assert np.abs(down[:, 1:] - up[:, 1:]).max() < 1e-9


@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
def test_half_a_turn_and_turned_over_twice_is_the_film_itself(tmp_path, accelerator):
    mesh = film_mesh(tmp_path, [LEANING])
    plain = Film(mesh, 1.5, accelerator=accelerator)
    once = light([SHEET, plain])
    assert np.abs(once - light([SHEET, replace(plain, rotation=2 * np.pi)])).max() < 1e-9
    # A symmetric film does not know half a turn, but for the place where a ray meets it.
    bare = Film(film_mesh(tmp_path, [BARE]), 1.5)
    a, b = (light([SHEET, f], count=40_000) for f in (bare, replace(bare, rotation=np.pi)))
    share = [np.mean(v[:, 0] > 0) for v in (a, b)]
    assert abs(share[0] - share[1]) < 4 * np.sqrt(0.5 / 40_000)


def test_flat_films_are_plates_path_by_path(tmp_path):
    # Same draws in the same order; the flat mesh repeats, so only rounding differs.
    flat = film_mesh(tmp_path, [groove(0.0)], base=0.175)
    thickness = flat.size[2]
    film, plate = Film(flat, 1.5, flipped=True, rotation=0.7), Slab(1.5, thickness)
    as_mesh = light([SHEET, Film(flat, 1.5), SHEET, film, SHEET])
    as_plates = light([SHEET, plate, SHEET, plate, SHEET])
    assert np.abs(as_mesh - as_plates).max() < 1e-9


def test_kernels_are_compiled_once_for_any_number_of_films(tmp_path):
    mesh, other = film_mesh(tmp_path, [BARE]), crossed_mesh(tmp_path)
    source = Source(LAMBERTIAN_BELOW, np.zeros(1), 0.05)
    for films in ([Film(mesh, 1.5)], [Film(mesh, 1.5), Film(other, 1.6)], [Film(mesh, 1.5)] * 5):
        trace(build_scene(films), source, 1)
    assert len(trace_paths.signatures) == 1


def test_films_of_one_mesh_share_its_tile(tmp_path):
    mesh = film_mesh(tmp_path, [BARE])
    scene = build_scene([Film(mesh, 1.5), Film(mesh, 1.6, rotation=CROSSED)])
    assert len(scene.tiles.accelerator) == 1
    two = build_scene([Film(mesh, 1.5), Film(crossed_mesh(tmp_path), 1.5)])
    assert two.accelerators == "chain, grid"


def test_a_film_upside_down_cannot_be_bonded(tmp_path):
    film = Film(film_mesh(tmp_path, [BARE]), 1.5, flipped=True)
    with pytest.raises(TraceError, match="upside down"):
        build_scene([Slab(1.5, 2.0, bonded=True), film])


@pytest.mark.parametrize(
    ("rotation", "flipped"),
    [(CROSSED, False), (-CROSSED, True), (0.0, True), (0.3, False)],
    ids=["crossed", "crossed upside down", "upside down", "askew"],
)
def test_stacks_of_films_equal_the_oracle(tmp_path, rotation, flipped):
    mesh = film_mesh(tmp_path, [LEANING, groove(60.0, chords=5)])
    first = Film(mesh, 1.55, offset=0.013)
    second = Film(crossed_mesh(tmp_path), 1.5, offset=0.02, rotation=rotation, flipped=flipped)
    third = replace(first, rotation=rotation, flipped=flipped)
    elements = [CAVITY, SHEET, first, second, third] if rotation != 0.3 else [SHEET, first, third]
    scene = build_scene(elements, below=1.0)
    engine = np.empty(20)
    flow = np.zeros(len(FLOWS) + len(elements))
    source = Source(EYE, np.array([0.1]), 0.05, acceptance=0.5)
    single_paths(scene, source, 1, 0, engine, flow)
    oracle = ReferenceTracer(elements, below=1.0)
    expected = [oracle.radiance(0.1, 0.05, 0.5, Philox(1, EYE, p, 1)) for p in range(20)]
    assert np.any(expected)
    assert np.abs(engine - expected).max() < 1e-9 * np.max(expected)
