"""Films as a library of pieces: the file, and the trace against meshes of the same solid."""

import math
import zipfile

import numpy as np
import pytest
from harness import BARE, film_mesh, groove

from mpfcad.cad.file.library import piece_mesh, piece_section, write_library
from mpfcad.errors import InputError
from mpfcad.film import Groove, build_library
from mpfcad.film.field.library import diffused
from mpfcad.optics.element import Film, LibraryFilm, Sheet
from mpfcad.optics.engine import trace
from mpfcad.optics.library.file import is_library_file, read_library
from mpfcad.optics.library.piece import Library, joined_places
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.optics.source import EYE, Source

_PLACE = 'transform="1 0 0 0 1 0 0 0 1 {}"'
#: As the production extension states an item whose object stands in a part of its own.
_PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
_ELSEWHERE = f'xmlns:p="{_PRODUCTION}" p:path="/3D/3dmodel.model"'
GROOVE = Groove(0.05, 0.025)
EYES = Source(
    EYE, [0.02, 0.05, 0.07], 0.1, tilt_x=[0.0, 0.3, -0.6], tilt_y=[0.0, 0.5, 0.2],
    acceptance=0.05, along=[0.0, 0.03, 0.02], spot_along=0.08,
)  # fmt: skip


def radiances(film, blocks=8, source=EYES):
    scene = build_scene([Sheet(0.3, 1.49, 0.98), film, Sheet(0.05, 1.49, 1.0)], below=1.0)
    found = trace(scene, source, blocks, seed=5)
    assert found.fraction[2] == 0  # nothing lost
    return found.radiance, found.radiance_error


def agree(one, two):
    off = (one[0] - two[0]) / np.hypot(one[1], two[1])
    assert np.sum(off**2) < 3 + 4 * math.sqrt(6), off  # 4σ of three values


@pytest.mark.parametrize("rotation", [0.0, np.pi / 2])
@pytest.mark.parametrize("curvature", [80.0, 55.0])
def test_a_uniform_library_is_the_film(tmp_path, curvature, rotation):
    x, z = BARE if curvature == 80.0 else groove(curvature)
    section = np.stack([x + 0.025, z + 0.15], axis=1)
    library = Library(0.05, 0.04, (section,), np.zeros((2, 3), np.int64))
    mesh = film_mesh(tmp_path, [(x, z)])
    agree(
        radiances(LibraryFilm(library, 1.55, rotation=rotation)),
        radiances(Film(mesh, 1.55, rotation=rotation)),
    )


def stepped(tmp_path):
    # The last along is the first: the tile repeats.
    wanted = np.array([[40.0, 60.0, 79.0, 40.0], [70.0, 45.0, 60.0, 70.0]])
    library = build_library(GROOVE, 0.15, 0.04, wanted, 40)
    path = tmp_path / "film.3mf"
    write_library(library, path, math.radians(2))
    return library, path


def test_the_file_holds_the_library(tmp_path):
    library, path = stepped(tmp_path)
    assert is_library_file(path)
    found = read_library(path)
    assert (found.pitch, found.length, found.chosen.shape) == (0.05, 0.04, (2, 4))
    used = np.unique(library.chosen)
    for i in range(2):
        for k in range(4):
            section = piece_section(library, library.chosen[i, k], math.radians(2))
            # lib3mf holds float32.
            assert np.allclose(found.section[found.chosen[i, k]], section, atol=2e-8)
    assert len(found.section) == len(used)
    assert path.read_bytes() == stepped(tmp_path)[1].read_bytes()


def test_steps_between_pieces_are_walls_of_the_solid():
    # Two pieces by turns, all resin, as a library and as a mesh of tops and steps.
    length = 0.008
    x = np.linspace(0.0, 0.05, 21)
    tops = [0.175 - c / 2 * x * (0.05 - x) for c in (8.0, 39.0)]
    low, high = tops[1], tops[0]
    rows = [(0.0, low), (0.5, low), (0.5, high), (1.5, high), (1.5, low), (2.0, low)]
    vertex = np.concatenate([
        np.stack([x, np.full(21, place * length), z], axis=1) for place, z in rows
    ])  # fmt: skip
    a = (np.arange(5)[:, None] * 21 + np.arange(20)).ravel()
    facet = np.concatenate([np.stack([a, a + 1, a + 22], 1), np.stack([a, a + 22, a + 21], 1)])
    edge = np.cross(*(vertex[facet[:, i]] - vertex[facet[:, 0]] for i in (1, 2)))
    mesh = FilmMesh(vertex, facet[np.linalg.norm(edge, axis=1) > 1e-15], (0.05, 2 * length, 0.175))
    sections = tuple(np.stack([x, z], axis=1) for z in (low, high))
    library = Library(0.05, length, sections, np.array([[0, 1]]))
    eyes = EYES._replace(spot_along=2 * length)
    found = [
        radiances(film, 12, source=eyes)
        for film in (LibraryFilm(library, 1.55), Film(mesh, 1.55, accelerator="bvh"))
    ]
    agree(*found)
    # Without the steps it is another film: both pieces alone have other means.
    parts = [
        radiances(LibraryFilm(Library(0.05, length, (one,), np.zeros((1, 1), int)), 1.55), 12)[0]
        for one in sections
    ]
    error = found[0][1].max()
    assert np.abs(np.mean(parts, axis=0) - found[0][0]).max() > 4 * error


def test_a_piece_is_a_closed_solid():
    import trimesh

    library = build_library(GROOVE, 0.15, 0.04, np.array([[55.0]]), 2)
    section = piece_section(library, 0, math.radians(1))
    mesh = piece_mesh(section, 0.04)
    solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
    area = np.sum(np.diff(section[:, 0]) * (section[1:, 1] + section[:-1, 1]) / 2)
    assert solid.is_watertight and solid.volume == pytest.approx(0.04 * area, rel=1e-12)


def test_rounding_keeps_means_and_mirror_images():
    u, v = (np.arange(n) + 0.5 for n in (80, 24))
    wanted = 60 + 2 * np.cos(2 * np.pi * u / 80)[:, None] + np.cos(2 * np.pi * v / 24)[None]
    library = build_library(GROOVE, 0.15, 0.5, wanted, 8)
    assert np.array_equal(library.chosen, library.chosen[::-1])
    assert np.array_equal(library.chosen, library.chosen[:, ::-1])
    step = library.curvature[1] - library.curvature[0]
    off = library.curvature[library.chosen] - wanted
    assert np.abs(off).max() < 1.5 * step and abs(off.mean()) < 0.05 * step
    means = off.reshape(8, 10, 4, 6).mean(axis=(1, 3))
    assert np.abs(means).max() < 0.15 * step
    assert diffused(np.full((4, 4), 1.0), np.array([0.0, 2.0])).mean() == pytest.approx(
        0.5, abs=0.2
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (_PLACE.format("0 0 0"), _PLACE.format("0 0.01 0"), "off a grid"),
        (_PLACE.format("0 0 0"), _PLACE.format("0 0 1"), "turned or lifted"),
        (_PLACE.format("0 0 0"), _PLACE.format("0.05 0 0"), "each place"),
        ('unit="millimeter"', 'unit="inch"', "expected millimetres"),
        (_PLACE.format("0 0 0"), _PLACE.format("nan 0 0"), "3MF"),
        (_PLACE.format("0 0 0"), _PLACE.format("0 0"), "3MF"),
        (_PLACE.format("0 0 0"), _ELSEWHERE, "item in another part"),
    ],
)  # fmt: skip
def test_files_that_are_no_library(tmp_path, old, new, words):
    _, path = stepped(tmp_path)
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name).decode() for name in archive.namelist()}
    assert old in content["3D/3dmodel.model"]
    content["3D/3dmodel.model"] = content["3D/3dmodel.model"].replace(old, new, 1)
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in content.items():
            archive.writestr(name, text)
    with pytest.raises(InputError, match=words):
        read_library(path)


def test_curvatures_that_resin_cannot_have_are_refused():
    with pytest.raises(InputError, match="expected 0 … 80"):
        build_library(GROOVE, 0.15, 0.5, np.array([[85.0]]), 4)


def test_places_of_many_films_are_numbered_through_in_two_bytes():
    films = [(np.array([[0, 2], [1, 2]]), 3), (np.array([[1]]), 65_533)]
    assert joined_places(films).tolist() == [0, 2, 1, 2, 4]
    assert joined_places([(np.array([[0]]), 65_535), (np.array([[0]]), 1)])[1] == 65_535
    with pytest.raises(InputError, match="65537 pieces in all films: expected at most 65536"):
        joined_places([*films, (np.array([[0]]), 1)])
