"""Films of cells as a library: the file, and the trace against meshes of the same solid."""

import math

import numpy as np
import pytest
from test_library import EYES as EYES_OF_GROOVES
from test_library import agree, radiances

from mpfcad.cad.file.library import write_library
from mpfcad.cad.file.library_window import check_window, write_window
from mpfcad.cad.file.stl import write_mesh
from mpfcad.cad.shape.cell_mesh import build_cell_mesh
from mpfcad.errors import InputError
from mpfcad.film import CellFilm, Groove, build_cell_library
from mpfcad.optics.element import Film, LibraryFilm
from mpfcad.optics.library.file import read_library
from mpfcad.optics.library.top import CellTops, build_cells
from mpfcad.optics.solid.mesh import read_film_mesh

BEF = Groove(0.050, 0.025)
ANGLE = math.radians(4)
EYES = EYES_OF_GROOVES._replace(spot=0.15, spot_along=0.1)
KINDS = [
    ("pyramid", "filled", 60.0, None),
    ("pyramid", "filled", 70.0, 45.0),
    ("pyramid", "filled", 80.0, None),
    ("paraboloid", "ideal", 40.0, 20.0),
]


def library(tmp_path, shape, profile, wanted, levels=40):
    found = build_cell_library(BEF, 0.15, shape, profile, np.array(wanted), levels)
    path = tmp_path / "film.3mf"
    write_library(found, path, ANGLE)
    return found, path


@pytest.mark.parametrize(("shape", "profile", "curvature", "along"), KINDS)
def test_equal_cells_are_the_film(tmp_path, shape, profile, curvature, along):
    wanted = np.tile([curvature, along or curvature], (3, 2, 1))
    held, path = library(tmp_path, shape, profile, wanted)
    film = CellFilm(BEF, 0.15, shape, profile, curvature, (2, 2), along)
    write_mesh(build_cell_mesh(film, ANGLE), tmp_path / "film.stl", "film")
    mesh = read_film_mesh(tmp_path / "film.stl")
    found = read_library(path)
    assert isinstance(found, CellTops) and found.chosen.shape == (3, 2)
    assert held.bare_volume == pytest.approx(6 * (0.15 + 0.025 / 3) * 0.05**2)
    # Spots of whole cells: the mesh's tips stand elsewhere.
    agree(*(radiances(one, source=EYES) for one in (LibraryFilm(found, 1.55), Film(mesh, 1.55))))


def test_steps_between_cells_are_walls_of_the_solid(tmp_path):
    """Three pyramids in a row, the middle one with less resin, against a window as one mesh."""
    wanted = np.array([[[8.0, 8.0]], [[39.0, 39.0]], [[8.0, 8.0]]])
    held, path = library(tmp_path, "pyramid", "filled", wanted)
    write_window(held, tmp_path / "film.stl", ANGLE, "film")
    check_window(tmp_path / "film.stl", held)
    mesh = read_film_mesh(tmp_path / "film.stl")
    scene = [LibraryFilm(read_library(path), 1.55), Film(mesh, 1.55, accelerator="bvh")]
    agree(*(radiances(film, 12, source=EYES) for film in scene))


def test_tops_that_are_no_height_over_the_cell_are_refused():
    square = np.array([[0, 0, 1], [0.05, 0, 1], [0.05, 0.05, 1], [0, 0.05, 1.0]])
    both = np.array([[0, 1, 2], [0, 2, 3]])
    build_cells([CellTops(0.05, 0.05, ((square, both),), np.zeros((1, 1), np.int64))])
    with pytest.raises(InputError, match="reach the sides"):
        build_cells([CellTops(0.05, 0.05, ((square, both[:1]),), np.zeros((1, 1), np.int64))])


def test_cells_have_the_pairs_of_levels_that_occur(tmp_path):
    u = (np.arange(12) + 0.5) / 12
    wave = np.cos(2 * np.pi * u)
    wanted = np.stack([60 + 5 * wave[:, None] + 0 * wave, 50 + 5 * wave + 0 * wave[:, None]], -1)
    held, path = library(tmp_path, "pyramid", "filled", wanted, levels=4)
    assert held.curvature.shape[1] == 2 and len(held.curvature) <= 16
    assert np.abs(held.curvature[held.chosen].mean(axis=(0, 1)) - (60, 50)).max() < 0.3
    assert np.array_equal(read_library(path).chosen.shape, (12, 12))
