"""Height maps: read back by another library, against the closed form."""

import numpy as np
import pytest

from mpfcad.cad.file.height import build_height_grid, check_heights, write_heights
from mpfcad.errors import ExportError, InputError
from mpfcad.film import CellFilm, CurvatureField, FieldFilm, Groove, cut_piece

BEF = Groove(0.050, 0.025)


def dish():
    return CellFilm(BEF, 0.2, "paraboloid", "ideal", 60.0, (3, 2))


def field():
    c = CurvatureField(np.array([0.0, 2]), np.array([0.0, 4]), [[30, 60], [60, 75]])
    return cut_piece(FieldFilm(BEF, 4.0, 40, c), 10, 4, 1.3, 0.7, 0.2)


@pytest.mark.parametrize("film", [dish(), field()])
@pytest.mark.parametrize("suffix", ["tif", "dat"])
def test_heights_read_back(tmp_path, film, suffix):
    grid = build_height_grid(film.size, (0.0011, 0.0021), film.height)
    path = tmp_path / f"film.{suffix}"
    write_heights(grid, path, "film")
    first = path.read_bytes()
    check = check_heights(path, grid)
    assert check.height_error_max < 2e-8
    assert (grid.step[0] <= 0.0011) and (grid.step[1] <= 0.0021)
    write_heights(grid, path, "film")
    assert path.read_bytes() == first
    other = build_height_grid(film.size, (0.0011, 0.0021), lambda x, y: film.height(x, y) + 1e-6)
    with pytest.raises(ExportError, match="height error"):
        check_heights(path, other)
    finer = build_height_grid(film.size, (0.0010, 0.0021), film.height)
    with pytest.raises(ExportError, match="points"):
        check_heights(path, finer)


def test_the_first_row_is_the_far_end(tmp_path):
    film = field()
    grid = build_height_grid(film.size, (0.025, 0.1), film.height)
    write_heights(grid, tmp_path / "film.dat", "film")
    lines = (tmp_path / "film.dat").read_text().splitlines()
    assert lines[0].split() == ["9", "8", "0.025", "0.1", "0", "0", "0"]
    # The second point is the vertex of the first groove's parabola at the largest y.
    wanted = 0.2 + BEF.vertex_height(film.curvature[0, -1])
    assert float(lines[2].split()[0]) == pytest.approx(wanted, abs=2e-8)


def test_too_many_points_are_refused_with_what_fits(tmp_path):
    grid = build_height_grid((392.3, 697.4), (0.0025, 0.05), field().height)
    with pytest.raises(InputError, match=r"expected at most 250 million: cad\.sample_along_um = 4"):
        write_heights(grid, tmp_path / "film.tif", "film")
    with pytest.raises(InputError, match=r"expected at most 1 million"):
        write_heights(grid, tmp_path / "film.dat", "film")
    assert not list(tmp_path.iterdir())
