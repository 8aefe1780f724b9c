"""Maps C(x, y) through `mpfcad cad`, and what of them is refused."""

import numpy as np
import pytest

from mpfcad.cli import run_app

STACK = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 12.0\npanel_length_mm = 30.0\n'
    "lamp_count = 3\nlamp_pitch_mm = 4.0\n"
)


@pytest.fixture
def job(tmp_path):
    """Return what writes a job whose map has spots 2 mm apart across and 1 mm along."""
    (tmp_path / "small.toml").write_text(STACK)
    x, y = np.linspace(0, 12, 61), np.linspace(0, 30, 301)
    curvature = 57 + 6 * np.cos(np.pi * x) * np.cos(2 * np.pi * y[:, None])
    names = ("position_across_mm", "position_along_mm", "curvature_per_mm")
    np.savez(tmp_path / "field.npz", **dict(zip(names, (x, y, curvature), strict=True)))

    def write(cad, film="", map_table='file = "field.npz"\nextent = "panel"'):
        path = tmp_path / "job.toml"
        path.write_text(
            f'name = "spots"\n[map]\n{map_table}\n[film]\n{film}\n[stack]\nfile = "small.toml"\n'
            f"[cad]\nangle_tolerance_deg = 4.0\n{cad}\n"
        )
        return str(path)

    return write


def test_a_window_of_spots_in_every_format(job, tmp_path, capsys):
    window = "width_mm = 0.2\nlength_mm = 0.7\nstart_across_mm = 3.31\nstart_along_mm = 12.3"
    out = tmp_path / "out"
    formats = ["--format", "step,stl,tif,dat"]
    assert run_app(["cad", job(window), "--out", str(out), *formats]) == 0
    names = {"film.step", "film.stl", "film.tif", "film.dat", "curvature.npz", "manifest.json"}
    assert {path.name for path in out.iterdir()} == names
    assert len(capsys.readouterr().out.splitlines()) == 4
    # The whole map goes with the files, bit for bit.
    with np.load(out / "curvature.npz") as kept, np.load(tmp_path / "field.npz") as given:
        assert all(np.array_equal(kept[name], given[name]) for name in given.files)


@pytest.mark.parametrize(
    ("command", "cad", "words"),
    [
        ("run", "length_mm = 0.75", "cad.length_mm: 0.75: the curvature of the piece and of what"),
        ("run", "length_mm = 1.0\nwidth_mm = 1.5", "cad.width_mm: 1.5: the curvature of the piece"),
        ("cad", 'extent = "panel"', "patches: expected at most 20000 in a STEP file"),
        (
            "cad",
            "start_across_mm = 9.0",
            "cad.start_across_mm: 9: expected at most 8, for",
        ),
        ("cad", "start_along_mm = 28.5", "cad.start_along_mm: 28.5: expected at most 28, for a"),
        ("cad", "length_mm = 40.0", "cad.length_mm: 40: expected at most 30"),
        ("cad", 'stl = "tiles"', "cad.stl: tiles: expected 'whole'"),
    ],
)
def test_what_is_refused_is_said_in_one_line(job, tmp_path, capsys, command, cad, words):
    assert run_app([command, job(cad), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert words in error
    assert not (tmp_path / "out").exists()


def test_other_films_have_no_window_and_maps_no_imperfections(job, tmp_path, capsys):
    out = ["--out", str(tmp_path / "out")]
    uniform = job("width_mm = 1.0", map_table="curvature_per_mm = 60.0")
    assert run_app(["cad", uniform, *out]) == 2
    assert "cad.width_mm: 1: is for maps that vary along the grooves" in capsys.readouterr().err
    assert run_app(["cad", job("", "tip_radius_um = 1.0"), *out]) == 2
    assert "expected grooves as designed" in capsys.readouterr().err
    assert run_app(["cad", job(""), "--format", "ply", *out]) == 2
    assert "ply: expected some of step, stl, tif, dat" in capsys.readouterr().err
