"""`mpfcad mould`, and `mpfcad cad` of imperfect films, from outside."""

import json

import numpy as np
import pytest

from mpfcad.cli import run_app
from mpfcad.film import Groove
from mpfcad.optics.solid.mesh import read_film_mesh

BEF = Groove(0.050, 0.025)
JOB = """
schema = 1
name = "small"
[map]
curvature_per_mm = {curvature}
[cad]
length_mm = 0.5
angle_tolerance_deg = 3.0
[stack.override]
lamp_pitch_mm = 4.0
[film]
"""


@pytest.fixture
def job(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(film="", curvature=60.0):
        (tmp_path / "job.toml").write_text(JOB.format(curvature=curvature) + film)
        return tmp_path / "job.toml"

    return write


@pytest.mark.parametrize("profile", ["filled", "ideal"])
def test_mould_folder(job, tmp_path, capsys, profile):
    path = job(f'profile = "{profile}"')
    options = ["--shrinkage", "0.004", "--tool-radius-um", "2", "--backing-mm", "1"]
    assert run_app(["mould", str(path), "--out", "m", *options]) == 0
    printed = capsys.readouterr().out
    assert "warning: a tool of nose radius 2 µm cannot reach" in printed
    names = {file.name for file in (tmp_path / "m").iterdir()}
    assert names == {
        "curvature.csv", "film.dxf", "manifest.json", "mould.dxf", "mould.json", "mould.step",
        "mould.stl", "profile.csv", "tool-loss.csv",
    }  # fmt: skip
    record = json.loads((tmp_path / "m" / "mould.json").read_text())
    assert abs(record["block"]["relative_difference"]) < 1e-10
    count = record["groove_count"]
    assert record["mould"]["width_mm"] == pytest.approx(count * 0.05 / 0.996)
    losses = np.loadtxt(tmp_path / "m" / "tool-loss.csv", delimiter=",", skiprows=1)
    assert losses.shape == (count, 4)
    assert record["not_cut"]["lost_area_um2"]["max"] == pytest.approx(losses[:, 2].max(), abs=1e-5)
    first = (tmp_path / "m" / "manifest.json").read_bytes()
    assert run_app(["mould", str(path), "--out", "m", *options]) == 0
    assert (tmp_path / "m" / "manifest.json").read_bytes() == first


def test_imperfect_film(job, tmp_path, capsys):
    path = job(
        "tip_radius_um = 2\nvalley_radius_um = 1\nprism_angle_deg = 89\npitch_error_um = 0.1"
    )
    assert run_app(["cad", str(path), "--out", "c"]) == 0
    mesh = read_film_mesh(tmp_path / "c" / "film.stl")
    count = round(mesh.size[0] / 0.0501)
    assert mesh.size[0] == pytest.approx(count * 0.0501, rel=1e-6)
    depth = 0.02505 / np.tan(np.radians(44.5))
    # A tip of half angle 44.5° and radius r is r (1/sin 44.5° - 1) lower.
    assert mesh.size[2] == pytest.approx(
        0.2 + depth - 0.002 * (1 / np.sin(np.radians(44.5)) - 1), rel=1e-6
    )


def test_measured_film(job, tmp_path, capsys):
    x = np.arange(0, 0.26, 2e-4)
    local = (x + 0.007) % BEF.pitch - BEF.half_width
    # A meniscus that is no parabola, over walls without resin near the tips.
    resin = 0.008 + 18 * local**2 + 1e4 * local**4
    z = np.maximum(resin, np.abs(local))
    x_full = np.linspace(0, BEF.half_width, 20001)
    over = np.maximum(0.008 + 18 * x_full**2 + 1e4 * x_full**4 - x_full, 0)
    fill = float(np.trapezoid(over, x_full)) / (BEF.area / 2)
    table = np.stack([x, z - 0.01 * x], axis=1) * 1000
    np.savetxt("trace.csv", table, "%.6f", ",", header="x_um,z_um", comments="")
    for share in (1.0, 1.25):
        # The shape is the trace's, the resin what the map and so the mask wants.
        wanted = float(BEF.curvature_of_fill(fill * share))
        path = job('measured_file = "trace.csv"', wanted)
        assert run_app(["cad", str(path), "--out", "c"]) == 0
        mesh = read_film_mesh(tmp_path / "c" / "film.stl")
        top = mesh.vertex[np.unique(mesh.top)]
        groove = top[(top[:, 1] == 0) & (top[:, 0] < 0.05 + 1e-6)]
        groove = groove[np.argsort(groove[:, 0])]
        at = np.linspace(-0.024, 0.024, 97)
        drawn = np.interp(at + 0.025, groove[:, 0], groove[:, 2]) - 0.2
        meniscus = np.maximum(0.008 + 18 * at**2 + 1e4 * at**4 - np.abs(at), 0) * share
        # A chord of 3° sags by z'' h²/8, and a kink lies up to 0.5 µm off its place.
        assert np.abs(drawn - np.abs(at) - meniscus).max() < 1.5e-4
        held = np.trapezoid(groove[:, 2], groove[:, 0]) / 0.05 - 0.2 - 0.0125
        # Chords of 3° lie CΔx²/12 above the meniscus: 4e-3 of this resin.
        assert held == pytest.approx(fill * share * 0.0125, rel=5e-3)
    path = job('measured_file = "trace.csv"', float(BEF.curvature_of_fill(fill * 0.4)))
    assert run_app(["cad", str(path), "--out", "d"]) == 2
    assert "expected a trace of a groove with 0.5 to 2 times" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "film", "options", "words"),
    [
        ("mould", "", ["--tool-radius-um", "90"], "tool radius: 90 µm: does not fit"),
        ("mould", "", ["--shrinkage", "2"], "--shrinkage"),
        ("cad", "tip_radius_um = 60", [], "tip_radius: 60 µm: larger than groove 0 allows"),
        ("cad", "valley_radius_um = 20", [], "valley_radius: 20 µm: larger than the groove"),
        ("cad", "tip_radius_um = -1", [], "film.tip_radius_um: -1"),
        (
            "cad",
            "pitch_error_um = -60",
            [],
            "film.pitch_error_um: -60: expected within half the pitch",
        ),
        ("cad", "prism_angle_error_deg = 80", [], "film.prism_angle_error_deg: 80: expected"),
        (
            "cad",
            'measured_file = "none.csv"\nprism_angle_error_deg = 1',
            [],
            "none.csv: no such file",
        ),
        ("cad", 'measured_file = "none.csv"', [], "none.csv: no such file"),
        ("run", "tip_radius_um = 60", [], "tip_radius: 60 µm: larger than groove 0 allows"),
    ],
)
def test_bad_input_is_one_line(job, tmp_path, capsys, command, film, options, words):
    path = job(film, 80.0)
    assert run_app([command, str(path), "--out", "bad", *options]) == 2
    lines = capsys.readouterr().err.splitlines()
    errors = [line for line in lines if line.startswith("mpfcad: ")]
    assert len(errors) == 1
    assert words in errors[0]
    assert not (tmp_path / "bad").exists()


@pytest.mark.parametrize(
    ("cell", "profile"), [("pyramid", "filled"), ("pyramid", "ideal"), ("paraboloid", "ideal")]
)
def test_cells(job, tmp_path, capsys, cell, profile):
    path = job(f'cell = "{cell}"\nprofile = "{profile}"')
    path.write_text(path.read_text().replace("length_mm = 0.5", "length_mm = 0.1"))
    assert run_app(["cad", str(path), "--out", "c"]) == 0
    mesh = read_film_mesh(tmp_path / "c" / "film.stl")
    assert mesh.size == pytest.approx((4.0, 0.1, 0.225), rel=1e-6)
    assert (tmp_path / "c" / "film.step").is_file()


@pytest.mark.parametrize(
    ("command", "film", "words"),
    [
        ("cad", 'cell = "cone"', "film.cell: cone"),
        ("cad", 'cell = "paraboloid"', "paraboloid: profile filled: expected 'ideal'"),
        ("cad", 'cell = "pyramid"\ntip_radius_um = 1', "cells: expected a film as designed"),
        ("mould", 'cell = "pyramid"', "film.cell: pyramid: expected 'groove' for a mould"),
        ("mask", 'cell = "pyramid"', "film.cell: pyramid: the process is calibrated for grooves"),
    ],
)
def test_cells_refused(job, tmp_path, capsys, command, film, words):
    assert run_app([command, str(job(film)), "--out", "bad"]) == 2
    errors = [e for e in capsys.readouterr().err.splitlines() if e.startswith("mpfcad: ")]
    assert len(errors) == 1
    assert words in errors[0]
    assert not (tmp_path / "bad").exists()
