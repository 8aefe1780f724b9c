"""`--confidence` of trace, measure, compare and sweep: the same figures, pages and refusals."""

import json

import numpy as np
import pytest
from harness import film_file, groove
from jsonschema import validate

from mpfcad.cli import run_app
from mpfcad.confidence import probability
from mpfcad.measure import POINTS, flux, rounds
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting
from mpfcad.pipeline.confidence import runs as confidence_runs
from mpfcad.pipeline.confidence.runs import Runs
from mpfcad.pipeline.effort import MEASURE_SETTINGS, MeasureSetting
from mpfcad.record import published_schema

JOB = """
name = "c"
[map]
rows = [[0.0, 62.0], [4.0, 60.0], [8.0, 62.0]]
[stack.override]
lamp_pitch_mm = 8.0
[confidence]
registration_mm = 0.5
"""
SWEEP = """
schema = 1
name = "few"
contrast_limit = 0.2
[axis]
"map.curvature_per_mm" = [55.0, 60.0]
[trace]
half_width = 0.0
paths_million = 0.02
"""
SMALL = "[stack.override]\nlamp_pitch_mm = 8.0\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Give a folder where traces end after a round, and changed films are not traced at all."""
    film_file(tmp_path / "film.stl", [groove(60.0)] * 20, base=0.2)
    (tmp_path / "job.toml").write_text(JOB)
    (tmp_path / "sweep.toml").write_text(SWEEP + SMALL)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(rounds, "LEAST_PATHS", 30_000)
    monkeypatch.setattr(flux, "_ENERGY_BLOCKS", 8)
    monkeypatch.setattr(probability, "_RESPONSES", 20)
    monkeypatch.setattr(confidence_runs, "_SMOOTH", 0.05)
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(10.0, 1000))
    monkeypatch.setitem(MEASURE_SETTINGS, "quick", MeasureSetting(*(10.0,) * 8))

    def trace(runs, steps, _):
        size = sum(z * (1 + i) for i, z in enumerate(steps))
        curve = 1 + 0.002 * size * np.cos(2 * np.pi * np.linspace(0, 1, POINTS))
        return runs.reading.read(curve), runs.reading.spread(curve, np.full(POINTS, 1e-5))

    monkeypatch.setattr(Runs, "trace", trace)
    return tmp_path


def app(*arguments):
    return run_app([*arguments, "--effort", "quick", "--threads", "1"])


def names(confidence):
    return {one["name"] for one in confidence["inputs"]}


def test_trace_says_how_likely_the_limits_are_met(place, capsys):
    assert app("trace", "film.stl", "--confidence", "--json") == 0
    figures = json.loads(capsys.readouterr().out)
    validate(figures, published_schema("trace"))
    found = figures["confidence"]
    low, high = found["probability"]["marginal"]["ci95"]
    assert 0 <= low <= found["probability"]["marginal"]["value"] <= high <= 1
    # A mesh does not say how much resin it has, nor what its depth should be.
    assert {"thickness_mm", "top_sheet_sigma", "registration_mm"} <= names(found)
    assert not {"resin_percent", "depth_um", "base_um"} & names(found)
    assert found["left_out"][0] == "resin_percent: a mesh does not say how it is made"
    assert app("trace", "film.stl", "--confidence") == 0
    out = capsys.readouterr().out
    assert "contrast at most 0.018: " in out and "measure next: " in out


def test_measure_carries_the_jobs_own_widths_and_keeps_what_it_found(place, capsys, monkeypatch):
    arguments = ("measure", "job.toml", "--what", "contrast", "--confidence")
    assert app(*arguments) == 0
    assert "contrast at most 0.018: " in capsys.readouterr().out
    out = place / "exports" / "c-measure"
    record = json.loads((out / "measure.json").read_text())
    validate(record, published_schema("measure"))
    found = record["confidence"]
    assert {"resin_percent", "registration_mm", "depth_um", "thickness_mm"} <= names(found)
    [shift] = [one for one in found["inputs"] if one["name"] == "registration_mm"]
    assert shift["sigma"] == 0.5 and found["left_out"] == []
    page = (out / "measure.html").read_text()
    assert "What to measure next" in page and "registration_mm" in page

    def refuse(*_):
        raise AssertionError("traced again")

    monkeypatch.setattr(Runs, "trace", refuse)
    whole = {path.name: path.read_bytes() for path in out.iterdir()}
    assert app(*arguments) == 0
    assert {path.name: path.read_bytes() for path in out.iterdir()} == whole


@pytest.mark.slow
def test_compare_states_it_of_every_case(place, capsys):
    assert app("compare", "job.toml", "thesis-32in-mpf", "--confidence") == 0
    out = capsys.readouterr().out
    assert out.count("at most 0.018: ") == 3 and out.count(", most by ") == 3
    record = json.loads((place / "exports" / "compare" / "compare.json").read_text())
    of_job, of_bef = (names(case["confidence"]) for case in record["cases"][1:])
    # A plain film has a depth, no resin, and lies everywhere alike.
    assert {"depth_um", "base_um"} <= of_bef
    assert of_job - of_bef == {"resin_percent", "registration_mm"}
    page = (place / "exports" / "compare" / "compare.html").read_text()
    assert "likely accepted" in page and "most by " in page


@pytest.mark.slow
def test_every_point_of_a_sweep_says_it(place, capsys):
    import xarray

    arguments = ["sweep", "sweep.toml", "--workers", "1"]
    assert run_app(arguments) == 0
    assert "most likely" not in capsys.readouterr().out
    assert run_app([*arguments, "--confidence"]) == 0
    assert "most likely at most 0.2 in the real backlight: " in capsys.readouterr().out
    out = place / "exports" / "few-sweep"
    record = json.loads((out / "sweep.json").read_text())
    for point in record["points"]:
        assert point["confidence"]["probability"]["marginal"]["limit"] == 0.2
        assert "resin_percent" in names(point["confidence"])
    data = xarray.open_dataset(out / "sweep.nc", engine="scipy")
    assert (data.probability_low <= data.probability).all()
    assert "likely in the real backlight" in (out / "sweep.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["trace", "--stack", "mini-led-4mm", "--confidence"], "LEDs light it: expected"),
        (["measure", "mini-led-4mm", "--confidence"], "LEDs light it: expected"),
        (["measure", "film.stl", "--what", "flux", "--confidence"],
         "--confidence: --what flux: expected contrast among what is measured"),
        (["compare", "film.stl@panel.toml", "--confidence"], 'extent panel: expected extent ='),
        (["sweep", "panel-sweep.toml", "--confidence"], 'extent panel: expected extent ='),
    ],
)  # fmt: skip
def test_what_has_no_confidence_is_refused_in_a_line(place, capsys, arguments, words):
    panel = 'schema = 1\nextends = "thesis-32in-mpf"\nextent = "panel"\n'
    (place / "panel.toml").write_text(panel)
    (place / "panel-sweep.toml").write_text(SWEEP + '[stack]\nfile = "panel.toml"\n')
    assert run_app(arguments) == 2
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1 and len(error) < 300
    assert not (place / "exports").exists()
