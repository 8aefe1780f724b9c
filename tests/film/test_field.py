"""Curvature that varies in both directions: interpolation and what a file is refused for."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import (
    CurvatureField,
    FieldFilm,
    Groove,
    PrismFilm,
    is_field_file,
    read_curvature_field,
    read_process,
)
from mpfcad.mask.pattern.ratio import CellRatio

BEF = Groove(0.050, 0.025)
X, Y = np.array([0.0, 1.0, 2.0]), np.array([0.0, 4.0, 6.0, 10.0])
C = np.array([[50.0, 60, 55], [52, 61, 57], [60, 58, 56], [55, 54, 53]])


def write(path, x=X, y=Y, c=C, **other):
    arrays = {"position_across_mm": x, "position_along_mm": y, "curvature_per_mm": c} | other
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})
    return path


def read(path, width=2.0, length=10.0):
    return read_curvature_field(
        path, profile="filled", groove=BEF, panel_width=width, panel_length=length
    )


def test_a_field_reads_back_and_is_bilinear(tmp_path):
    path = write(tmp_path / "f.npz")
    assert is_field_file(path)
    film = FieldFilm(BEF, 10.0, 40, read(path))
    assert film.curvature_at(1.0, 4.0) == 61
    assert film.curvature_at(0.25, 5.0) == pytest.approx(
        0.75 * (52 + 60) / 2 + 0.25 * (61 + 58) / 2
    )
    assert film.curvature_at(-1.0, 99.0) == 55  # held beyond the ends
    low, high = film.field.extremes(film.groove_position)
    y = np.linspace(0, 10, 1001)
    values = film.curvature_at(film.groove_position[:, None], y)
    assert np.allclose(values.min(axis=1), low)
    assert np.allclose(values.max(axis=1), high)


def test_cells_have_the_ratio_of_their_centres():
    process = read_process(None, BEF)
    film = FieldFilm(BEF, 10.0, 40, CurvatureField(X, Y, C))
    rows = CellRatio.build(film, process, 200).rows(3, 5)
    centre = (np.arange(200) + 0.5) * 0.05
    curvature = film.curvature_at(film.groove_position[3:8, None], centre)
    assert np.abs(rows - process.aperture_ratio_of_curvature(curvature)).max() < 1e-7


def test_one_curvature_a_groove_is_a_field_too():
    process = read_process(None, BEF)
    curvature = np.array([80.0, 60.0, 0.0 + 40.0])
    film = PrismFilm(BEF, 0.2, 5.0, "filled", curvature)
    rows = CellRatio.build(film, process, 10).rows(0, 3)
    wanted = process.aperture_ratio_of_curvature(curvature)
    assert np.abs(rows - wanted[:, None]).max() < 1e-9
    assert rows[0].max() == 0


def test_a_map_across_is_no_field(tmp_path):
    path = tmp_path / "m.npz"
    np.savez(path, position_mm=X, curvature_per_mm=C[0])
    assert not is_field_file(path)
    assert not is_field_file(tmp_path / "absent.npz")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"c": C.T}, "shape (3, 4): expected (4, 3), along by across"),
        ({"x": X[::-1]}, "position_across_mm[1] (counted from 0): 1: expected finite and incr"),
        ({"y": Y / 2}, "array position_along_mm: 0 … 5: expected to cover 0 … 10 mm"),
        ({"c": C + 25}, "curvature_per_mm[0, 1] (counted from 0): 85: not printable"),
        ({"c": C / 1000}, "looks like 1/µm"),
        ({"c": np.where(C == 61, np.nan, C)}, "curvature_per_mm[1, 1] (counted from 0): nan"),
        ({"x": None}, "array position_across_mm missing"),
        ({"x": X[None]}, "shape (1, 3): expected numbers in 1 dimension"),
        ({"x": X[:1], "c": C[:, :1]}, "1 values: expected 2 or more"),
    ],
)
def test_what_is_refused(tmp_path, change, words):
    path = write(tmp_path / "f.npz", **change)
    with pytest.raises(InputError) as error:
        read(path)
    assert words in str(error.value)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)
