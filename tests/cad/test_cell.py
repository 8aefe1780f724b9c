"""Films of cells: volumes in closed form, every file read back, traced as tiles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.cad import check_agreement
from mpfcad.cad.check.cell import check_cell_stl
from mpfcad.cad.check.step.body import check_film_body
from mpfcad.cad.file.stl import write_mesh
from mpfcad.cad.shape.cell_mesh import build_cell_mesh
from mpfcad.cad.step.cell import write_cell_step
from mpfcad.errors import ExportError, InputError
from mpfcad.film import CellFilm, Groove
from mpfcad.gate import demand
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.units import deg

BEF = Groove(0.050, 0.025)
KINDS = [("pyramid", "filled"), ("pyramid", "ideal"), ("paraboloid", "ideal")]


def cells(shape="pyramid", profile="filled", curvature=60.0, count=(3, 2)):
    return CellFilm(BEF, 0.2, shape, profile, curvature, count)


@given(kind=st.sampled_from(KINDS), curvature=st.floats(0.0, 80.0))
def test_mean_height_in_closed_form(kind, curvature):
    """Against Gauss's rule on a quarter cell, split at the diagonal and at the contact lines."""
    film = cells(*kind, curvature)
    place, weight = np.polynomial.legendre.leggauss(12)
    place, weight = (place + 1) / 2, weight / 2
    w = BEF.half_width
    reach = float(BEF.contact_position(curvature)) / w if kind[1] == "filled" else 1.0
    total = 0.0
    for low, high in ((0.0, reach), (reach, 1.0)):
        near = low + (high - low) * place
        for t, share in zip(near, weight * (high - low), strict=True):
            # Both halves of the L-shaped line min(x, y) = t.
            x, y = np.full(12, t * w), (t + (1 - t) * place) * w
            if kind[0] == "pyramid":
                total += share * 2 * (1 - t) * np.sum(weight * film.height(x, y))
            else:
                total += share * np.sum(weight * film.height(x + w, place * w + w))
    assert film.mean_height == pytest.approx(total, rel=1e-9)


@pytest.mark.parametrize(("shape", "profile"), KINDS)
@pytest.mark.parametrize("curvature", [10.0, 40.0, 60.0, 79.9999, 80.0])
def test_files_read_back(tmp_path, shape, profile, curvature):
    film = cells(shape, profile, curvature)
    path = tmp_path / "film.step"
    write_cell_step(film, path)
    assert check_film_body(path, film).volume_error < 1e-7
    first = path.read_bytes()
    write_cell_step(film, path)
    assert path.read_bytes() == first
    path = tmp_path / "film.stl"
    write_mesh(build_cell_mesh(film, 1 * deg), path, "film")
    check = check_cell_stl(path, film, 1 * deg)
    assert abs(check.volume_error) < 1e-4
    agreement = check_agreement(tmp_path / "film.step", path, film.volume)
    assert agreement.distance_max < 1e-7
    assert check.curvature == pytest.approx(curvature, rel=1e-4)
    mesh = read_film_mesh(path)
    assert mesh.size == pytest.approx((*film.size, film.thickness), rel=1e-6)


def test_finer_facets_are_nearer(tmp_path):
    film = cells("paraboloid", "ideal", 40.0)
    errors = []
    for angle in (4.0, 1.0):
        write_mesh(build_cell_mesh(film, angle * deg), tmp_path / "film.stl", "film")
        errors.append(check_cell_stl(tmp_path / "film.stl", film, angle * deg).volume_error)
    assert errors[1] == pytest.approx(errors[0] / 16, rel=0.3)


def test_another_film_is_noticed(tmp_path):
    write_mesh(build_cell_mesh(cells(), 1 * deg), tmp_path / "film.stl", "film")
    write_cell_step(cells(), tmp_path / "film.step")
    for other in (cells(curvature=62.0), cells(profile="ideal")):
        with pytest.raises(ExportError):
            demand(check_cell_stl(tmp_path / "film.stl", other, 1 * deg).gates)
        with pytest.raises(ExportError):
            demand(check_film_body(tmp_path / "film.step", other).gates)


def test_what_is_refused(tmp_path):
    with pytest.raises(InputError, match="paraboloid: profile filled"):
        cells("paraboloid", "filled")
    with pytest.raises(InputError, match=r"expected below 360 /mm"):
        cells("paraboloid", "ideal", 400.0)
    with pytest.raises(InputError, match=r"expected below 720 /mm"):
        cells("pyramid", "ideal", 800.0)
    with pytest.raises(InputError, match=r"12 million: 3\.4 deg, or \d+ cells fit"):
        build_cell_mesh(cells("paraboloid", "ideal", 60.0, (100, 100)), 0.5 * deg)
    with pytest.raises(InputError, match="flat"):
        write_cell_step(cells(curvature=0.0), tmp_path / "film.step")
    with pytest.raises(InputError, match="expected at most"):
        write_cell_step(cells(count=(200, 200)), tmp_path / "film.step")
