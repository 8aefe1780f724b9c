"""STEP against STL of one film, from the files."""

import numpy as np
import pytest

from mpfcad.cad import check_agreement, write_step, write_stl
from mpfcad.errors import ExportError
from mpfcad.gate import demand
from mpfcad.units import deg


def write(film, folder, bodies="separate"):
    write_step(film, folder / "film.step", bodies=bodies)
    write_stl(film, folder / "film.stl", 0.5 * deg)
    return folder / "film.step", folder / "film.stl"


@pytest.mark.parametrize("bodies", ["separate", "fused"])
@pytest.mark.parametrize("profile", ["filled", "ideal"])
def test_files_of_one_film_agree(make_film, tmp_path, profile, bodies):
    film = make_film([60.0, 30.0, 0.0, 79.0, 80.0, 45.0], profile)
    found = check_agreement(*write(film, tmp_path, bodies), film.volume)
    assert found.distance_max < 2e-7
    assert found.volume_difference < 3e-5


@pytest.mark.parametrize("curvature", [20.0, 59.0, 60.01, 80.0])
def test_another_film_is_refused(make_film, tmp_path, curvature):
    film = make_film([60.0, 50.0, 60.0])
    step, _ = write(film, tmp_path)
    write_stl(make_film([60.0, curvature, 60.0]), tmp_path / "film.stl", 0.5 * deg)
    with pytest.raises(ExportError, match=r"film.stl: off film.step: "):
        demand(check_agreement(step, tmp_path / "film.stl", film.volume).gates)


def test_another_volume_is_refused(make_film, tmp_path):
    film = make_film(60.0)
    with pytest.raises(ExportError, match="volume"):
        demand(check_agreement(*write(film, tmp_path), film.volume * 1.001).gates)


def test_one_moved_corner_is_found(make_film, tmp_path):
    film = make_film(np.full(40, 60.0))
    step, stl = write(film, tmp_path)
    data = bytearray(stl.read_bytes())
    corner = np.frombuffer(data, "<f4", 3, 84 + 50 * 40 + 12).copy()
    corner[2] += np.float32(1e-5)
    data[84 + 50 * 40 + 12 : 84 + 50 * 40 + 24] = corner.tobytes()
    stl.write_bytes(data)
    with pytest.raises(ExportError, match="off"):
        demand(check_agreement(step, stl, film.volume).gates)
