"""Windows of films whose curvature varies along the grooves: volumes, every file read back."""

from dataclasses import replace

import numpy as np
import pytest

from mpfcad.cad.check.field import check_field_stl, curvature_difference
from mpfcad.cad.check.field_agreement import check_field_agreement
from mpfcad.cad.check.step.body import check_film_body
from mpfcad.cad.file.stl import write_mesh
from mpfcad.cad.shape.field_mesh import build_field_mesh
from mpfcad.cad.step.field import write_field_step
from mpfcad.errors import ExportError, InputError
from mpfcad.film import CurvatureField, FieldFilm, Groove, PrismFilm, cut_piece
from mpfcad.gate import demand
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.units import deg

BEF = Groove(0.050, 0.025)
#: Lowest and highest C: resin everywhere, walls that begin to show, resin that ends, both.
RANGES = [(20.0, 35.0), (45.0, 70.0), (30.0, 60.0), (55.0, 90.0), (10.0, 90.0)]


def window(low=45.0, high=70.0, *, profile="filled", grooves=3, start=1.0, length=1.0):
    """Return grooves of a lattice of spots, 1 mm apart along and 0.4 mm across."""
    x, y = np.linspace(0, 2, 41), np.linspace(0, 4, 41)
    wave = np.cos(2 * np.pi * x / 0.4) * np.cos(2 * np.pi * y[:, None])
    c = np.clip((low + high) / 2 + (high - low) / 2 * wave, 0, 80)
    film = FieldFilm(BEF, 4.0, 40, CurvatureField(x, y, c), profile)
    return cut_piece(film, 8, grooves, start, length, 0.2)


def test_the_window_has_the_films_curvature():
    film = FieldFilm(
        BEF, 4.0, 40, CurvatureField(np.array([0.0, 2]), np.array([0.0, 4]), [[50, 60], [60, 75]])
    )
    piece = cut_piece(film, 10, 4, 1.3, 0.7, 0.2)
    x, y = np.meshgrid(piece.groove_position, np.linspace(0, 0.7, 5))
    found = piece.curvature_at(piece.local(x)[0], y)
    assert found == pytest.approx(film.curvature_at(x + 0.5, y + 1.3), rel=1e-12)
    # In its middle a groove has the vertex of its parabola.
    assert piece.height(x, y) == pytest.approx(0.2 + BEF.vertex_height(found), rel=1e-12)


@pytest.mark.parametrize("profile", ["filled", "ideal"])
def test_volume_of_one_curvature_is_that_of_a_prism_film(profile):
    field = CurvatureField(np.array([0.0, 2]), np.array([0.0, 4]), np.full((2, 2), 58.0))
    piece = cut_piece(FieldFilm(BEF, 4.0, 40, field, profile), 3, 5, 0.5, 2.5, 0.2)
    prism = PrismFilm(BEF, 0.2, 2.5, profile, np.full(5, 58.0))
    assert piece.volume == pytest.approx(prism.volume, rel=1e-14)


@pytest.mark.parametrize("span", RANGES)
def test_volume_against_fine_sums(span):
    piece = window(*span)
    y = np.linspace(0, 1, 40_001)
    height = [BEF.mean_height(piece.curvature_at(np.full(y.shape, g), y)) for g in range(3)]
    total = sum(np.trapezoid(line, y) for line in height)
    assert piece.volume == pytest.approx((total + 0.2 * 3) * 0.05, rel=1e-8)


@pytest.mark.parametrize(
    ("span", "profile"), [*((span, "filled") for span in RANGES), ((20.0, 120.0), "ideal")]
)
def test_files_read_back(tmp_path, span, profile):
    film = window(*span, profile=profile)
    step, stl = tmp_path / "film.step", tmp_path / "film.stl"
    write_field_step(film, step)
    found = check_film_body(step, film)
    assert found.volume_error < 1e-9
    first = step.read_bytes()
    write_field_step(film, step)
    assert step.read_bytes() == first
    write_mesh(build_field_mesh(film, 3 * deg), stl, "film")
    check = check_field_stl(stl, film, 3 * deg)
    assert check.normal_error_max < 3.1 * deg
    assert curvature_difference(film, check.curvature) < 1e-3
    agreement = check_field_agreement(step, stl, film.volume, 1e-3)
    assert agreement.distance_max < 1e-7
    mesh = read_film_mesh(stl)
    assert mesh.size == pytest.approx((*film.size, film.thickness), rel=1e-6)


def test_another_film_is_noticed(tmp_path):
    film = window()
    step, stl = tmp_path / "film.step", tmp_path / "film.stl"
    write_field_step(film, step)
    write_mesh(build_field_mesh(film, 3 * deg), stl, "film")
    curvature = film.curvature.copy()
    curvature[1, 4] += 0.05
    for other in (replace(film, curvature=curvature), window(profile="ideal")):
        with pytest.raises(ExportError):
            demand(check_field_stl(stl, other, 3 * deg).gates)
        with pytest.raises(ExportError):
            demand(check_film_body(step, other).gates)
    write_field_step(replace(film, curvature=curvature), step)
    with pytest.raises(ExportError, match=r"off film\.step"):
        demand(check_field_agreement(step, stl, film.volume, 1e-3).gates)


def test_a_piece_that_does_not_repeat_is_no_tile(tmp_path):
    film = window(length=0.8)
    write_mesh(build_field_mesh(film, 5 * deg), tmp_path / "film.stl", "film")
    check_field_stl(tmp_path / "film.stl", film, 5 * deg)
    with pytest.raises(InputError, match=r"must repeat from side to side"):
        read_film_mesh(tmp_path / "film.stl")


def test_what_is_too_large_is_refused_with_what_fits(tmp_path):
    film = window(10.0, 90.0)
    many = replace(film, curvature=np.tile(film.curvature, (900, 1)))
    with pytest.raises(InputError, match=r"million facets: expected at most 12 million: \d+ mm²"):
        build_field_mesh(many, 0.2 * deg)
    with pytest.raises(
        InputError, match=r"\d+ patches: expected at most 20000 in a STEP file: \d+"
    ):
        write_field_step(many, tmp_path / "film.step")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="cuts through the underside"):
        replace(film, profile="ideal", curvature=np.full_like(film.curvature, 720.0))
