"""`mpfcad calibrate` from outside."""

import json

import numpy as np
import pytest

from mpfcad import film
from mpfcad.cli import run_app
from mpfcad.film import Groove, StylusTip, read_process
from mpfcad.film.stylus.dilated import DilatedGroove

BEF = Groove(0.050, 0.025)
TRUTH = {"a.csv": (0.05, 66.0), "b.csv": (0.10, 55.0), "c.csv": (0.20, 45.0)}


@pytest.fixture(autouse=True, scope="module")
def _fitted_once():
    """Fit the three traces, which the tests write alike, once: a fit takes a second."""
    known, fit = {}, film.fit_stylus_trace

    def remembered(trace, *arguments, **options):
        heights = trace.position.tobytes() + trace.height.tobytes()
        key = heights, repr((trace.name, trace.tip, trace.reading, arguments, options))
        if key not in known:
            known[key] = fit(trace, *arguments, **options)
        return known[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(film, "fit_stylus_trace", remembered)
        yield


@pytest.fixture
def traces(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x = np.arange(0.0, 0.12, 2e-4)
    rng = np.random.default_rng(7)
    for name, (_, curvature) in TRUTH.items():
        local = (x + 0.004) % BEF.pitch - BEF.half_width
        # By a tip that is the median of those that fit where none is told.
        traced = DilatedGroove(BEF, "filled", StylusTip(0.7e-3)).height(local, curvature)
        z = traced - 0.02 * x + rng.normal(0, 5e-5, x.size)
        table = np.stack([x, z], axis=1) * 1000
        np.savetxt(name, table, "%.6f", ",", header="x_um,z_um", comments="")
    return tmp_path


def test_figures_hold_the_truth(traces, capsys):
    assert run_app(["calibrate", *TRUTH, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    for row, (_, curvature) in zip(document["traces"], TRUTH.values(), strict=True):
        truth = {
            "curvature_per_mm": curvature,
            "fitted_curvature_per_mm": BEF.fitted_curvature(curvature),
            "fill_fraction": BEF.fill_fraction(curvature),
        }
        for name, value in truth.items():
            low, high = row[name]["ci95"]
            assert low - 0.2 * (high - low) <= value <= high + 0.2 * (high - low), name
        assert row["residual_rms_um"] == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize("way", ["option", "list"])
def test_calibration_file(traces, capsys, way):
    if way == "option":
        arguments = list(TRUTH)
        for ratio, _ in TRUTH.values():
            arguments += ["--aperture", str(ratio)]
    else:
        text = "".join(f"{name},{ratio}\n" for name, (ratio, _) in TRUTH.items())
        (traces / "list.csv").write_text("file,aperture_ratio\n" + text)
        arguments = ["--coupons", "list.csv"]
    options = ["--model", "table", "--out", "process.toml"]
    assert run_app(["calibrate", *arguments, *options]) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[-1] == "process.toml"
    assert "a.csv: resin meets the walls " in printed
    assert ": tip not stated; tips from sharp to " in printed
    assert "all 3 files: the tip's cone may hide how steep the walls are" in printed
    process = read_process(traces / "process.toml", BEF)
    ratio, curvature = zip(*TRUTH.values(), strict=True)
    assert process.curvature(ratio) == pytest.approx(curvature, abs=0.2)


def test_a_tone_curve_is_calibrated_with_its_intervals(traces, capsys):
    arguments = list(TRUTH)
    for ratio, _ in TRUTH.values():
        arguments += ["--aperture", str(ratio)]
    options = ["--mesh", "120/305-34Y", "--out", "process.toml", "--json"]
    assert run_app(["calibrate", *arguments, *options]) == 0
    told = json.loads(capsys.readouterr().out)["process"]
    process = read_process(traces / "process.toml", BEF)
    assert process.kind == told["kind"] == "tone"
    assert process.screen["mesh"] == "120-34"
    for ratio, curvature in TRUTH.values():
        low, high = process.curvature_interval(ratio)
        assert low[0] - 0.5 < curvature < high[0] + 0.5
        assert 0.2 < high[0] - low[0] < 6
    for entry in told["tone"].values():
        assert entry["ci95"][0] < entry["value"] < entry["ci95"][1]


def test_prints_that_the_screen_cannot_have_held_are_refused(traces, capsys):
    arguments = list(TRUTH)
    for ratio, _ in TRUTH.values():
        arguments += ["--aperture", str(ratio)]
    options = ["--mesh", "120-34", "--solids", "0.1", "--out", "process.toml"]
    assert run_app(["calibrate", *arguments, *options]) == 2
    assert "of what the mesh holds would lie in the grooves: expected at most 100 %" in (
        capsys.readouterr().err
    )
    assert not (traces / "process.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            [
                "a.csv",
                "b.csv",
                "--aperture",
                "0.05",
                "--aperture",
                "0.1",
                "--mesh",
                "119-34",
                "--out",
                "p.toml",
            ],
            "--mesh: '119-34': not in the catalogue",
        ),
        (
            [
                "a.csv",
                "b.csv",
                "--aperture",
                "0.05",
                "--aperture",
                "0.1",
                "--model",
                "line",
                "--out",
                "p.toml",
            ],
            "--model: 'line': expected tone or table",
        ),
        ([], "either traces or --coupons"),
        (["none.csv"], "none.csv: no such file"),
        (["a.csv", "--out", "p.toml"], "--out"),
        (["a.csv", "b.csv", "--aperture", "0.1"], "--aperture: 1 for 2 files"),
        (["a.csv", "--aperture", "0"], "--aperture: 0: expected above 0, up to 1"),
        (["a.csv", "--aperture", "0.1", "--out", "p.toml"], "two or more"),
        (["--coupons", "a.csv"], "a.csv: row 1: header"),
        (["a.csv", "--widths", "3"], "a.csv: x_um: 119.8 µm long: expected 150 µm"),
        (["a.csv", "--pitch-um", "35"], "a.csv: z_um: residual"),
    ],
)
def test_bad_input_is_one_line(traces, capsys, arguments, words):
    assert run_app(["calibrate", *arguments]) == 2
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert words in error
    assert not (traces / "p.toml").exists()
