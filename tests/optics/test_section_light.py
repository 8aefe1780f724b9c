"""Cross-sections that are no height over a flat underside: what is chosen, laws, closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from harness import (
    BARE,
    CONCAVE,
    SECTIONS,
    crossed_mesh,
    drawn,
    film_file,
    film_mesh,
    groove,
    pass_layers,
    rays,
    section_mesh,
    through,
    within,
    write_facets,
)
from oracle.ray import reflectance
from scipy.integrate import quad

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError, TraceError
from mpfcad.measure.rounds import light_film
from mpfcad.optics.element import Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.scene import build_scene
from mpfcad.optics.search.grid.section import drawn_segments
from mpfcad.optics.solid.mesh import FilmMesh, read_film_mesh
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source

LEANING = (np.array([-0.025, -0.012, 0.004, 0.025]), np.array([0.025, 0.003, 0.001, 0.025]))


def solid(folder, *rings):
    return read_film_mesh(write_facets(folder / "solid.stl", drawn(rings, 0.1)))


def box(x0, z0, x1, z1, *, air=False):
    ring = [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]
    return ring[::-1] if air else ring


def turned_over(path):
    """Return the film of an STL file as it is when turned over about y, read from disk."""
    record = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    facets = np.frombuffer(path.read_bytes(), record, offset=84)["v"] * np.array([-1, 1, -1])
    return read_film_mesh(write_facets(path.with_name("over.stl"), facets))


@pytest.mark.parametrize("name", SECTIONS)
def test_a_drawn_mesh_that_is_no_height_is_traced_as_a_section(tmp_path, name):
    film = Film(section_mesh(tmp_path, name), 1.5)
    assert build_scene([film]).accelerators == "section"
    with pytest.raises(TraceError, match="chain"):
        build_scene([replace(film, accelerator="chain")])


def test_the_trace_of_a_file_names_what_it_takes(tmp_path):
    path = write_facets(tmp_path / "section.stl", drawn(SECTIONS["undercut"], 0.1))
    assert light_film(read_stack("thesis-32in-mpf"), path).accelerator == "section"


def test_a_mesh_that_is_not_drawn_along_y_has_no_section(tmp_path):
    mesh = crossed_mesh(tmp_path)
    assert drawn_segments(mesh) is None
    with pytest.raises(TraceError, match="section"):
        build_scene([Film(mesh, 1.5, accelerator="section")])
    # Nor one whose far end is another polyline, with corners at both ends only.
    mesh = film_mesh(tmp_path, [CONCAVE])
    vertex = mesh.vertex.copy()
    vertex[(vertex[:, 1] > 0) & (vertex[:, 2] > 0.17)] += (0, 0, 1e-3)
    assert drawn_segments(FilmMesh(vertex, mesh.top, mesh.size)) is None


def test_a_film_alone_and_in_a_stack_has_the_same_tallies_by_chain_and_section(tmp_path):
    film = Film(film_mesh(tmp_path, [groove(c) for c in (30, 57, 80)]), 1.55, offset=0.013)
    stack = [Slab(1.49, 2.0, 0.6, 0.0, 0.8), Sheet(0.36, 1.49, 0.98), film]
    source = Source(EYE, np.linspace(0, 0.1, 5), 0.05, acceptance=0.5)
    chain, section = (
        trace(build_scene([*stack[:2], replace(film, accelerator=a)], below=1.0), source, 40)
        for a in ("chain", "section")
    )
    # Hit points differ in the last bits: no path ends otherwise, sums differ by rounding.
    assert np.abs(chain.radiance - section.radiance).max() < 1e-9
    assert np.abs(chain.fraction - section.fraction).max() < 1e-9


@pytest.mark.parametrize("accelerator", ["section", "bvh"])
@pytest.mark.parametrize("below", [True, False])
def test_a_file_upside_down_is_the_film_turned_over(tmp_path, below, accelerator):
    path = film_file(tmp_path / "film.stl", [LEANING, groove(60.0, chords=5)])
    over = turned_over(path)
    assert not over.underside
    out = []
    for film in (Film(over, 1.5, accelerator=accelerator),
                 Film(read_film_mesh(path), 1.5, flipped=True)):  # fmt: skip
        out.append(np.empty((4000, 4)))
        pass_layers(build_scene([film]), below, 3, out[-1])
    assert (out[0][:, 0] != 0).all()
    assert np.abs(out[0] - out[1]).max() < 1e-9


def fresnel(cosine, index):
    """Return the reflectance of one face, and the transmittances of one slab and of two."""
    r = reflectance(cosine, 1.0, index)
    # Slabs of T = (1-R)/(1+R) and all light to and fro between them: T²/(1-(1-T)²).
    return (1 - r) / (1 + r), (1 - r) / (1 + 3 * r)


@pytest.mark.parametrize("accelerator", ["section", "bvh"])
def test_two_sheets_with_air_between_are_two_slabs(tmp_path, accelerator):
    mesh = solid(tmp_path, box(0, 0, 0.1, 0.1), box(0, 0.13, 0.1, 0.2))
    scene = build_scene([Film(mesh, 1.5, accelerator=accelerator)], below=1.0)
    lambertian = quad(lambda s: fresnel(np.sqrt(1 - s), 1.5)[1], 0, 1, limit=200)[0]
    got = trace(scene, Source(LAMBERTIAN_BELOW, np.zeros(1), 0.05), 400, seed=61)
    within(got.fraction[0], lambertian, got.fraction_error[0], 4)
    for sine in (0.0, 0.5, 0.9):
        tilt = {"tilt_x": 0.8 * sine, "tilt_y": 0.6 * sine}
        got = trace(scene, Source(EYE, np.zeros(1), 0.05, **tilt), 200, seed=62)
        within(got.radiance[0], fresnel(np.sqrt(1 - sine**2), 1.5)[1], got.radiance_error[0], 4)


@pytest.mark.parametrize("accelerator", ["section", "bvh"])
def test_an_air_void_is_two_slabs_where_it_is_and_one_beside_it(tmp_path, accelerator):
    # Exactly normal light never meets the void's upright walls.
    mesh = solid(tmp_path, box(0, 0, 0.1, 0.2), box(0.03, 0.05, 0.06, 0.12, air=True))
    scene = build_scene([Film(mesh, 1.5, accelerator=accelerator)], below=1.0)
    got = trace(scene, Source(EYE, np.array([0.015, 0.045, 0.075]), 0.029), 200, seed=63)
    one, two = fresnel(1.0, 1.5)
    within(got.radiance, np.array([one, two, one]), got.radiance_error, 4)


@pytest.mark.parametrize("name", SECTIONS)
def test_far_from_the_origin_the_same_light_passes(tmp_path, name):
    mesh = section_mesh(tmp_path, name)
    start = rays(20_000, True, size=mesh.size[:2])
    near = through(mesh, start, True)
    start[:, 0] += 3900 * mesh.size[0]
    far = through(mesh, start, True)
    assert (near[:, 0] != 0).all() and (far[:, 0] != 0).all()
    assert (np.abs(near - far).max(axis=1) > 1e-6).mean() < 2e-3


def test_without_flat_underside_nothing_can_be_bonded_to_it(tmp_path):
    over = turned_over(film_file(tmp_path / "film.stl", [BARE]))
    with pytest.raises(InputError, match="flat underside"):
        build_scene([Slab(1.5, 2.0, bonded=True), Film(over, 1.5, 1.5)])
    resin = Resin(film_mesh(tmp_path, [BARE]), 10.0)
    with pytest.raises(InputError, match="flat underside"):
        build_scene([Film(over, 1.5, resin=resin)])
