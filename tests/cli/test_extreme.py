"""Extreme films and backlights: figures that are finite, or one line; never NaN, never a crash."""

import json
import math

import numpy as np
import pytest

from mpfcad.cli import run_app
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting

STACK = """[stack.override]
lamp_count = 1
lamp_pitch_mm = 4.0
lamp_radius_mm = 0.2
lamp_height_mm = 0.5
panel_width_mm = {width}
panel_length_mm = 2.0
"""
ONE_POINT = "position_mm,curvature_per_mm\n0.0,60\n"
TOP = 0.7  # of the lamps [mm]


def ulp(value, side):
    return repr(float(np.nextafter(value, side)))


def job(curvature="60.0", width="4.0", **table):
    text = f'name = "extreme"\n[map]\ncurvature_per_mm = {curvature}\n'
    for name, content in table.items():
        text += f"[{name}]\n{content}\n"
    return text + STACK.format(width=width)


#: What is printed or ideal, and at the ends of the range: the empty groove of 50 µm and 90° has
#: C = 40 /mm as the circle through its tips and its bottom, 80 is what a parabola's fill leaves.
CASES = {
    "C 0": job("0.0"),
    "C -0": job("-0.0"),
    "C above 0": job(ulp(0.0, 1.0)),
    "C below 0": job(ulp(0.0, -1.0)),
    "C 40": job("40.0"),
    "C below 40": job(ulp(40.0, 0.0)),
    "C above 40": job(ulp(40.0, 50.0)),
    "C 80": job("80.0"),
    "C below 80": job(ulp(80.0, 0.0)),
    "C above 80": job(ulp(80.0, 90.0)),
    "ideal C 0": job("0.0", film='profile = "ideal"'),
    "ideal C 40": job("40.0", film='profile = "ideal"'),
    "ideal C 80": job("80.0", film='profile = "ideal"'),
    "one groove": job(film="pitch_um = 2000.0\ndepth_um = 1000.0", width="2.0"),
    "one-point map": job().replace("curvature_per_mm = 60.0", 'file = "one.csv"'),
    "no web": job(mask="min_web_um = 0.0"),
    "no web at C 80": job("80.0", mask="min_web_um = 0.0"),
    "thickness at the tops": job(stack=f"thickness_mm = {TOP}"),
    "thickness below the tops": job(stack=f"thickness_mm = {ulp(TOP, 0.0)}"),
    "thickness above the tops": job(stack=f"thickness_mm = {ulp(TOP, 1.0)}"),
}


def finite(value):
    if isinstance(value, dict):
        return all(finite(entry) for entry in value.values())
    if isinstance(value, list):
        return all(finite(entry) for entry in value)
    return not isinstance(value, float) or math.isfinite(value)


def outcome(folder, command, capsys):
    """Run; return the record where there is one, and assert one line where there is none."""
    code = run_app([*command, "--out", str(folder / "out")])
    error = [line for line in capsys.readouterr().err.splitlines() if line.startswith("mpfcad: ")]
    assert code in (0, 1, 2), error
    if code == 2:
        assert len(error) == 1 and len(error[0]) <= 300 and error[0].isprintable()
        assert "nan" not in error[0].lower().split() and not (folder / "out").exists()
        return None
    record = json.loads((folder / "out" / "verification.json").read_text())
    assert finite(record)
    return record


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_an_extreme_is_finite_or_one_line(tmp_path, monkeypatch, capsys, case):
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(1.0, 20_000))
    (tmp_path / "job.toml").write_text(CASES[case])
    (tmp_path / "one.csv").write_text(ONE_POINT)
    record = outcome(tmp_path, ["run", str(tmp_path / "job.toml"), "--effort", "quick"], capsys)
    if case in ("C 80", "C below 80"):
        assert record is not None
    if case == "C above 80":  # a digit that curvature.csv does not hold
        assert record["job"]["given"]["map"]["curvature_per_mm"] > 80
    if case in ("C below 0", "C above 0", "thickness at the tops", "thickness below the tops"):
        assert record is None


@pytest.mark.slow
@pytest.mark.parametrize("what", ["contrast", "flux"])
def test_one_led_is_finite_or_one_line(tmp_path, capsys, what):
    (tmp_path / "led.toml").write_text(
        'extends = "mini-led-4mm"\nextent = "panel"\n[value]\nled_count_x = 1\nled_count_y = 1\n'
    )
    (tmp_path / "job.toml").write_text(job())
    assert run_app(["cad", str(tmp_path / "job.toml"), "--out", str(tmp_path / "film")]) == 0
    capsys.readouterr()
    code = run_app(["trace", str(tmp_path / "film" / "film.stl"), "--stack",
                    str(tmp_path / "led.toml"), "--json"])  # fmt: skip
    out = capsys.readouterr()
    if code == 2:
        assert out.err.startswith("mpfcad: ") and out.err.count("\n") == 1
    else:
        assert code == 0 and finite(json.loads(out.out))
