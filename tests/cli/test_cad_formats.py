"""`mpfcad cad`: its formats, tiles and fused bodies."""

from pathlib import Path

import pytest

from mpfcad.cli import run_app

STACK = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 20.0\npanel_length_mm = 5.0\n'
    "lamp_count = 2\nlamp_pitch_mm = 8.01\n"
)


@pytest.fixture
def job(tmp_path):
    (tmp_path / "small.toml").write_text(STACK)

    def write(table):
        path = tmp_path / "job.toml"
        path.write_text(
            'name = "small"\n[map]\ncurvature_per_mm = 58.0\n[stack]\nfile = "small.toml"\n'
            f"[cad]\nlength_mm = 0.5\n{table}"
        )
        return path

    return write


def made(folder):
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("film"))


def test_every_format_is_written_and_checked(job, tmp_path, capsys):
    out = tmp_path / "out"
    formats = ["--format", "step,stl,3mf,ply"]
    assert run_app(["cad", str(job('bodies = "fused"')), "--out", str(out), *formats]) == 0
    assert made(out) == ["film.3mf", "film.ply", "film.step", "film.stl"]
    printed = [Path(line).name for line in capsys.readouterr().out.splitlines()]
    assert printed == ["film.step", "film.stl", "film.3mf", "film.ply"]
    text = (out / "film.step").read_text()
    assert text.count("=MANIFOLD_SOLID_BREP(") == 1
    assert "=PRODUCT('small'," in text


def test_tiles_of_whole_grooves_cover_the_panel(job, tmp_path):
    out = tmp_path / "out"
    table = 'extent = "panel"\nstl = "tiles"'
    assert run_app(["cad", str(job(table)), "--out", str(out), "--format", "stl"]) == 0
    assert made(out) == ["film-01.stl", "film-02.stl", "film-03.stl"]
    headers = [(out / name).read_bytes()[:80].decode() for name in made(out)]
    places = [header.partition("x0 = ")[2].partition(" mm")[0] for header in headers]
    assert places == ["0", "8.05", "16.1"]


def test_unknown_format_is_one_line(job, tmp_path, capsys):
    assert run_app(["cad", str(job("")), "--out", str(tmp_path / "o"), "--format", "iges"]) == 2
    assert "iges: expected some of step, stl, 3mf, ply" in capsys.readouterr().err


def test_an_imperfect_film_in_every_format(tmp_path, capsys):
    (tmp_path / "small.toml").write_text(STACK)
    (tmp_path / "job.toml").write_text(
        'name = "round"\n[map]\ncurvature_per_mm = 58.0\n[film]\ntip_radius_um = 1.5\n'
        'valley_radius_um = 1.0\n[stack]\nfile = "small.toml"\n[cad]\nlength_mm = 0.5\n'
        'step_protocol = "ap242"\nauthor = "A. Müller"\norganisation = "Films"\n'
    )
    out = tmp_path / "out"
    formats = ["--format", "step,stl,3mf,ply"]
    assert run_app(["cad", str(tmp_path / "job.toml"), "--out", str(out), *formats]) == 0
    assert made(out) == ["film.3mf", "film.ply", "film.step", "film.stl"]
    head = (out / "film.step").read_text("ascii").split("ENDSEC;")[0]
    assert r"('A. M\X2\00FC\X0\ller'),('Films')" in head
    assert "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF" in head
    capsys.readouterr()


def test_a_height_map_too_large_is_refused_before_work(job, tmp_path, capsys):
    table = "sample_across_um = 0.5\nsample_along_um = 0.5"
    out = tmp_path / "out"
    assert run_app(["cad", str(job(table)), "--out", str(out), "--format", "step,dat"]) == 2
    error = capsys.readouterr().err
    (line,) = [x for x in error.splitlines() if x.startswith("mpfcad: ")]
    assert "job.toml: film.dat: " in line and "expected at most 1 million" in line
    assert "writing" not in error and not out.exists()
