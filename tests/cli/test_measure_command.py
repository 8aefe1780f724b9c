"""`mpfcad measure` and `mpfcad compare` with short traces: files, figures, and what is kept."""

import json
import re

import numpy as np
import pytest
from harness import film_file, groove
from jsonschema import ValidationError, validate

from mpfcad.cli import run_app
from mpfcad.measure import rounds
from mpfcad.pipeline import TRACE_SETTINGS, WHAT, TraceSetting
from mpfcad.pipeline.effort import MEASURE_SETTINGS, MeasureSetting
from mpfcad.record import published_schema

FILES = [
    "camera-contour.png", "camera.png", "camera.tif", "manifest.json", "measure.html",
    "measure.json",
]  # fmt: skip


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Give a folder with a film and a cache of its own, where every trace ends after one round."""
    folder = tmp_path_factory.mktemp("measure")
    film_file(folder / "film.stl", [groove(60.0)] * 20, base=0.2)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("MPFCAD_CACHE", str(folder / "cache"))
        patch.setattr(rounds, "LEAST_PATHS", 60_000)
        patch.setitem(TRACE_SETTINGS, "quick", TraceSetting(10.0, 1000))
        patch.setitem(MEASURE_SETTINGS, "quick", MeasureSetting(*(10.0,) * 8))
        yield folder


def app(*arguments):
    return run_app([*arguments, "--effort", "quick", "--threads", "1"])


@pytest.fixture(scope="module")
def measured(place):
    assert app("measure", "film.stl") == 0
    return place / "exports" / "film-measure"


def estimates(value):
    if isinstance(value, dict):
        if "ci95" in value:
            yield value
        for name, entry in value.items():
            # The contrast after each round stands in columns.
            yield from estimates(entry) if name != "convergence" else ()
    elif isinstance(value, list):
        for entry in value:
            yield from estimates(entry)


def test_measure_writes_its_files_and_every_figure_has_its_error(measured):
    assert sorted(path.name for path in measured.iterdir()) == FILES
    record = json.loads((measured / "measure.json").read_text())
    lacking = {"psf", "panel", "polarisation", "colour"}
    assert set(WHAT) - lacking <= set(record) and not lacking & set(record)
    found = [entry for entry in estimates(record) if "formula" not in entry]
    assert len(found) > 25
    for entry in found:
        low, high = entry["ci95"]
        assert low <= entry["value"] <= high and entry["standard_error"] >= 0
    assert record["traced"]["accelerator"] == "chain"
    assert record["screen"]["axes"] == {"across": "vertical", "along": "horizontal"}
    relative = record["relative_luminance"]["value"]
    means = [entry["contrast"]["mean_luminance_cd_m2"]["value"] for entry in
             (record, record["baseline"])]  # fmt: skip
    assert relative == pytest.approx(means[0] / means[1])


def test_pictures_read_back_with_another_library(measured):
    from PIL import Image

    record = json.loads((measured / "measure.json").read_text())["camera"]
    lines = np.array(record["luminance_cd_m2"])
    with Image.open(measured / "camera.tif") as tif:
        says = json.loads(tif.tag_v2[270])
        counts = np.array(tif)
    assert counts.dtype == np.uint16 and counts.shape == (200, 200)
    step = says["luminance_cd_m2_per_count"]
    # Lamps lie level: the lines' values run down, half a count off at most.
    assert np.abs(counts * step - lines).max() <= step / 2 + 1e-9
    assert counts.max() > 50_000
    with Image.open(measured / "camera.png") as png:
        grey = np.array(png)
    assert grey.shape == (600, 600)
    expected = np.clip(np.round(lines / (1.1 * lines.mean()) * 255), 0, 255)
    assert (grey[1::3, 0] == expected[:, 0]).all()
    with Image.open(measured / "camera-contour.png") as png:
        assert np.array(png).shape == (600, 600, 3)


def test_the_page_needs_no_network_and_shows_every_part(measured):
    page = (measured / "measure.html").read_text()
    for title in ("lamp pitch", "Viewing angle", "Conoscopic map", "efficiency", "Camera image"):
        assert title in page
    assert 'src="http' not in page and "NaN" not in page.split("</script>")[-2]


def test_measure_writes_what_its_published_schema_says(measured):
    validate(json.loads((measured / "measure.json").read_text()), published_schema("measure"))


@pytest.fixture(scope="module")
def led(place):
    assert app("measure", "mini-led-4mm", "--what", "contrast,angular", "--out", "led") == 0
    return place / "led"


def test_leds_are_measured_as_the_published_schemas_say(led, capsys):
    schema, record = published_schema("measure"), json.loads((led / "measure.json").read_text())
    validate(record, schema)
    page = (led / "measure.html").read_text()
    assert "Luminance over the cell of an LED" in page and "lamp pitch" not in page
    for missing in ("cell", "points", "sigma_over_mean"):
        part = {key: value for key, value in record["contrast"].items() if key != missing}
        with pytest.raises(ValidationError):
            validate({**record, "contrast": part}, schema)
    assert app("trace", "film.stl", "--stack", "mini-led-4mm", "--json") == 0
    figures, schema = json.loads(capsys.readouterr().out), published_schema("trace")
    validate(figures, schema)
    for missing in ("cell", "points", "energy"):
        with pytest.raises(ValidationError):
            validate({key: value for key, value in figures.items() if key != missing}, schema)


def test_a_finite_panel_prints_the_contrast_of_each_pitch(place, capsys):
    (place / "panel.toml").write_text(
        'extends = "thesis-32in-mpf"\nextent = "panel"\n[value]\nlamp_count = 4\n'
        "lamp_pitch_mm = 8.0\npanel_width_mm = 36.0\nlamp_2_luminance_factor = 0.5\n"
    )
    assert app("measure", "panel.toml", "--what", "contrast", "--out", "panel") == 0
    figures = capsys.readouterr().out
    pitches = [line for line in figures.splitlines() if line.startswith("contrast.pitches.")]
    assert len(pitches) == 3
    assert all(re.search(r" 0\.\d+ \[\d\.?\d*, 0\.\d+\]$", line) for line in pitches), pitches


def test_the_same_figures_again_are_not_traced_again(place, measured, monkeypatch):
    from mpfcad.optics import engine

    def refuse(*arguments, **options):
        raise AssertionError("traced again")

    first = {path.name: path.read_bytes() for path in measured.iterdir()}
    monkeypatch.setattr(engine, "trace", refuse)
    assert app("measure", "film.stl") == 0
    assert {path.name: path.read_bytes() for path in measured.iterdir()} == first
    # Another seed is another measurement.
    assert app("measure", "film.stl", "--seed", "2", "--out", "other", "--what", "flux") == 3
    assert not (place / "other").exists()


def test_compare_puts_the_conventional_stack_first(place, measured, capsys):
    assert app("compare", "film.stl", "thesis-32in-conventional") == 0
    record = json.loads((place / "exports" / "compare" / "compare.json").read_text())
    base, film = record["cases"]
    assert base["label"] == "BEF in thesis-32in-conventional" == record["baseline"]
    assert base["relative_luminance"]["value"] == 1
    assert base["sheet_count"] == 4
    assert film["label"] == "film in thesis-32in-mpf"
    # The same figures as alone.
    alone = json.loads((measured / "measure.json").read_text())
    assert film["contrast"] == alone["contrast"] and film["flux"] == alone["flux"]
    assert film["relative_efficiency"] == alone["relative_efficiency"]
    page = (place / "exports" / "compare" / "compare.html").read_text()
    assert "film<br>in thesis-32in-mpf" in page
    assert "0." in capsys.readouterr().out


def test_a_comparison_that_was_interrupted_keeps_what_it_found(place, measured, monkeypatch):
    from mpfcad.pipeline.measure import figures

    seen = []
    real = dict(figures._MEASURE)

    def stop(*arguments):
        raise KeyboardInterrupt

    def count(name):
        return lambda *arguments: (seen.append(name), real[name](*arguments))[1]

    for name in real:
        monkeypatch.setitem(figures._MEASURE, name, count(name))
    monkeypatch.setitem(figures._MEASURE, "flux", stop)
    source = "film.stl@thesis-32in-mpf-plate"
    assert app("compare", source, "--out", "two") == 130
    assert seen == ["contrast", "angular"] and not (place / "two").exists()
    monkeypatch.setitem(figures._MEASURE, "flux", count("flux"))
    assert app("compare", source, "--out", "two") == 0
    assert seen == ["contrast", "angular", "flux"]
    record = json.loads((place / "two" / "compare.json").read_text())
    assert [case["sheet_count"] for case in record["cases"]] == [4, 2]


def test_a_job_and_a_preset_are_cases(place):
    from mpfcad.pipeline import read_case

    (place / "job.toml").write_text('name = "c60"\n[map]\ncurvature_per_mm = 60.0\n')
    job = read_case("job.toml")
    assert (job.name, job.lit.stack.name) == ("c60", "thesis-32in-mpf")
    # Where its files lay for a while is no part of what it is: figures that are kept are found.
    assert read_case("job.toml").lit.case == job.lit.case
    slim = read_case("job.toml", thickness=16.0)
    assert slim.lit.stack.thickness == 16.0 and slim.lit.case["mesh"] == job.lit.case["mesh"]
    bef = read_case("thesis-32in-mpf")
    assert bef.name == "BEF" and bef.lit.case["mesh"] != job.lit.case["mesh"]
    (place / "own.toml").write_text('extends = "thesis-32in-mpf"\ntitle = "own"\n')
    own = read_case("own.toml")
    assert own.name == "BEF" and own.lit.stack.name == "own"
    assert own.lit.case["mesh"] == bef.lit.case["mesh"]
    assert read_case("own.toml", thickness=16.0).lit.stack.thickness == 16.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["measure", "film.stl", "--what", "hue"], "--what: hue: expected some of contrast"),
        (["measure", "film.stl", "--what", "panel"], "extent: pitch: expected panel"),
        (["measure", "none.stl"], "none.stl: no such file"),
        (["measure", "none"], "none: no such preset"),
        (["measure", "none.toml"], "none.toml: no such file: expected a closed mesh in mm, a job"),
        (["measure", "thesis-32in-mpf", "--stack", "led-tv-20mm"], "is a stack itself"),
        (["measure", "own.toml", "--stack", "led-tv-20mm"], "own.toml is a stack itself"),
        (["measure", "wrong.toml"], "wrong.toml: value.thickness_mm: 0: expected a number in"),
        (["measure", "own.toml", "--offset-mm", "1"], "--offset-mm: 1: of own.toml: expected a"),
        (["measure", "cache"], "is no export of mpfcad"),
        (["compare", "film.stl@none"], "none: no such preset"),
        (["compare"], "CASE"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(place, measured, capsys, arguments, words):
    own = 'extends = "thesis-32in-mpf"\ntitle = "own"\n'
    (place / "own.toml").write_text(own)
    (place / "wrong.toml").write_text(f"{own}[value]\nthickness_mm = 0\n")
    before = sorted(path.name for path in place.iterdir())
    assert run_app(arguments) == 2
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1
    assert sorted(path.name for path in place.iterdir()) == before


def test_figures_are_listed_and_what_only_has_an_interval_is_left_out(capsys, tmp_path):
    from mpfcad.cli.terminal import print_measurement

    figure = {"value": 0.0123, "standard_error": 0.0004, "ci95": [0.0115, 0.0131]}
    steps = {"paths": [1, 2], "contrast": [0.02, 0.01], "ci95": [[0, 1], [0, 1]]}
    record = {"contrast": {"lamp_mura_contrast": figure, "convergence": steps}}
    print_measurement(record, tmp_path, as_json=False)
    first, page = capsys.readouterr().out.splitlines()
    assert first.split() == ["contrast.lamp_mura_contrast", "0.0123", "±", "0.0004"]
    assert page == str(tmp_path / "measure.html")


def test_what_is_of_leds_alone_is_refused_of_tubes(capsys):
    assert run_app(["measure", "thesis-32in-mpf", "--what", "psf"]) == 2
    assert "of LEDs alone" in capsys.readouterr().err
