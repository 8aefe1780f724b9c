"""A job with a gate on colour: refused without bands, judged by its interval, run and shown."""

import json

import pytest

from mpfcad.cli import run_app
from mpfcad.errors import InputError
from mpfcad.job import read_job
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.record import colour_gate
from mpfcad.report.film.wording import GATES

STACK = (
    'extends = "thesis-32in-mpf"\nlayers = ["clear_plate", "film"]\n{light}[value]\n'
    "panel_width_mm = 4.0\npanel_length_mm = 2.0\n"
    "lamp_radius_mm = 0.2\nlamp_height_mm = 0.5\nlamp_count = 1\nlamp_pitch_mm = 4.0\n"
)
LIGHT = "[light]\nbands = 4\nspectrum = { planckian_k = 6500 }\n"
JOB = (
    'name = "colour"\n[map]\ncurvature_per_mm = 60.0\n[stack]\nfile = "small.toml"\n'
    '[cad]\nlength_mm = 0.5\n[mask]\nformats = ["oas"]\n[gates]\ncolour_max = {limit}\n'
)


def written(folder, light=LIGHT, limit=0.01, more=""):
    (folder / "small.toml").write_text(STACK.format(light=light) + more)
    (folder / "job.toml").write_text(JOB.format(limit=limit))
    return folder / "job.toml"


def figure(value, low, high):
    return {"colour_mura": {"value": value, "ci95": [low, high], "standard_error": 0.001}}


@pytest.mark.parametrize(
    ("found", "outcome"),
    [
        (figure(0.004, 0.003, 0.005), "PASS"),
        (figure(0.009, 0.008, 0.011), "INCONCLUSIVE"),
        (figure(0.02, 0.018, 0.022), "FAIL"),
        (None, "INCONCLUSIVE"),
    ],
)
def test_the_gate_is_decided_by_the_interval(found, outcome):
    gate = colour_gate(found, 0.01, "film.stl")
    assert gate.outcome == outcome
    assert gate.name in GATES


def test_a_limit_without_bands_is_refused(tmp_path):
    path = written(tmp_path, light="")
    message = r"gates\.colour_max: 0\.01: the stack small states no light\.bands"
    with pytest.raises(InputError, match=message):
        read_plan(read_job(path), path)


@pytest.mark.parametrize("limit", [0, -1, 2, "inf"])
def test_a_limit_that_is_none_is_refused(tmp_path, limit):
    path = written(tmp_path, limit=limit)
    with pytest.raises(InputError, match=r"gates\.colour_max"):
        read_job(path)


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "outcome"), [(0.05, "PASS"), (0.0001, "FAIL")])
def test_a_job_in_bands_is_run_judged_and_verified(tmp_path, limit, outcome, capsys):
    # Lamps of a film's width apart over a reflector that is yellow: the colour follows the lamps.
    yellow = "reflector_reflectance = { table_nm = [[400, 0.3], [550, 0.95], [700, 0.95]] }\n"
    path = written(tmp_path, limit=limit, more=yellow)
    out = tmp_path / "out"
    run_app(["run", str(path), "--out", str(out), "--effort", "quick"])
    record = json.loads((out / "verification.json").read_text("utf-8"))
    gate = next(gate for gate in record["gates"] if gate["name"] == "colour_mura")
    assert gate["outcome"] == outcome
    assert gate["ci95"] == record["colour"]["colour_mura"]["ci95"]
    assert len(record["colour"]["over_screen"]["u_prime"]) == 33
    assert "light.bands" in str(record["inputs"])
    page = (out / "report.html").read_text("utf-8")
    assert "Colour Mura" in page and "share of the power [%]" in page
    assert run_app(["verify", str(out)]) in (0, 1)
