"""The main job from Python: objects, figures with units, errors where nonsense is made."""

import doctest
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from few_paths import few_paths

import mpfcad
from mpfcad.api.fit import FitResult
from mpfcad.api.result import Export, Measurement, Run, Trace

MASKS = Path(__file__).parents[1] / "masks"
STACK = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 40.0\npanel_length_mm = 50.0\n'
    "lamp_count = 5\nlamp_pitch_mm = 8.0\n"
)


@pytest.fixture(scope="module")
def short_trace():
    with few_paths():
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("api")
    (folder / "stack.toml").write_text(STACK)
    return folder


@pytest.fixture(scope="module")
def job(folder):
    x = np.linspace(0.0, 8.0, 33)
    return mpfcad.Job.of_curvature(
        58 + 3 * np.cos(2 * np.pi * x / 8.0),
        x,
        name="wave",
        tables={"stack": {"file": "stack.toml"}, "cad": {"length_mm": 0.1}},
        folder=folder,
    )


@pytest.fixture(scope="module")
def run(job, folder, short_trace):
    return job.run(folder / "out", effort="quick")


def test_import_is_quick_and_loads_nothing_heavy():
    code = (
        "import sys, mpfcad; dir(mpfcad); mpfcad.Job; "
        "print([m for m in ('numba', 'scipy', 'OCP', 'klayout', 'plotly', 'xarray', 'distributed') "
        "if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there():
    for name in mpfcad.__all__:
        assert getattr(mpfcad, name).__doc__


def test_a_run_has_figures_with_units(run, folder):
    stored = json.loads((folder / "out" / "verification.json").read_text())
    assert run.verdict == stored["verdict"]
    assert run.contrast.value == stored["lamp_mura_contrast"]["value"]
    assert run.contrast.low <= run.contrast.value <= run.contrast.high
    assert list(run.luminance) == ["luminance_cd_m2", "standard_error_cd_m2"]
    assert run.luminance.sizes == {"position_pitch": len(stored["luminance"]["position_pitch"])}
    gate = run.gates.sel(gate="lamp_mura_contrast")
    assert float(gate["limit"]) == stored["gates"][0]["limit"]
    assert str(gate["outcome"].values) == stored["gates"][0]["outcome"]
    assert run.curvature["curvature_per_mm"].max() <= 61.0 + 1e-9
    assert run.report.is_file() and run.report in run.files
    assert run.verdict in run._repr_html_()
    assert len(run.plot().data) == 2


def test_a_run_is_verified(run, folder):
    assert mpfcad.verify(folder / "out").record == run.record


def test_the_exported_mesh_traced_alone_gives_the_same_kind_of_figures(run, folder, short_trace):
    found = mpfcad.trace(run.folder / "film.stl", str(folder / "stack.toml"), effort="quick")
    offset = run.record["provenance"]["traced"]["offset_mm"]
    again = mpfcad.trace(
        run.folder / "film.stl", str(folder / "stack.toml"), offset_mm=offset, effort="quick"
    )
    assert again.contrast == run.contrast
    assert found.mean_luminance_cd_m2.value == pytest.approx(
        again.mean_luminance_cd_m2.value, rel=0.1
    )


def test_mask_and_cad_alone(job, folder):
    assert "mask.oas" in {p.name for p in job.mask(folder / "mask", formats=["oas"]).files}
    assert "film.stl" in {p.name for p in job.cad(folder / "cad", formats=["stl"]).files}


def test_a_measurement(job, folder, short_trace):
    found = job.measure(["contrast"], folder / "measured", effort="quick")
    contrast = found.figures["contrast.lamp_mura_contrast"]
    assert contrast.low <= contrast.value <= contrast.high
    assert "contrast" in found._repr_html_()


def test_a_wrong_dict_is_one_line():
    with pytest.raises(mpfcad.InputError, match=r"^c60: map\.curvature_per_mm: -1"):
        mpfcad.Job({"name": "c60", "map": {"curvature_per_mm": -1.0}})
    with pytest.raises(ValueError, match="expected the same"):
        mpfcad.Job.of_curvature([60.0, 61.0], [0.0])


def test_cells_are_escaped():
    from mpfcad.api.figure import html_table

    assert "<script>" not in html_table("<script>", ["<script>"], [["<script>"]])


@pytest.mark.parametrize("name", ["figure", "job", "design", "sweep"])
def test_the_examples_of_the_docstrings_run(name):
    module = __import__(f"mpfcad.api.{name}", fromlist=["_"])
    result = doctest.testmod(module)
    assert result.attempted and not result.failed


def test_a_run_prints_what_decides_in_a_few_lines(run):
    title, contrast, mean, files = str(run).splitlines()
    assert title == f"wave: {run.verdict}"
    assert contrast.endswith(str(run.contrast)) and mean.endswith(str(run.mean_luminance_cd_m2))
    assert str(run.folder) in files and "report.html" in files
    assert repr(run) == str(run)


def test_every_result_prints_in_a_few_lines(run, job, tmp_path):
    figures = {f"figure_{n}": {"value": 1.0, "ci95": [0.0, 2.0]} for n in range(40)}
    (tmp_path / "measure.html").touch()
    measured = str(Measurement(tmp_path, {"name": "film"} | figures)).splitlines()
    assert len(measured) == 9 and "and 34 more" in measured[7]
    assert str(Trace(run.record)).splitlines()[1:] == str(run).splitlines()[1:3]
    assert len(str(Export(run.folder)).splitlines()) == 2
    value = {"name": "top_sheet_sigma", "value": 0.4, "ci95": [0.3, 0.5]}
    fitted = FitResult(tmp_path, {"name": "b", "values": [value], "predictions": []})
    assert str(fitted).splitlines()[1].split(maxsplit=1) == ["top_sheet_sigma", "0.4 [0.3, 0.5]"]
    assert len(str(fitted).splitlines()) == 3
    assert str(job) == "<Job wave>"
    untraced = run.record | {"lamp_mura_contrast": None, "mean_luminance_cd_m2": None}
    assert "not measured" in str(Run(untraced, run.folder))
