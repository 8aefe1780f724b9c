"""`mpfcad judge` from outside."""

import json

import numpy as np
import pytest

from mpfcad.cli import run_app

PITCH = 16.0


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x = np.arange(0.0, 70.0, 0.25)
    for name, contrast in (("good", 0.005), ("bad", 0.03)):
        value = 6000 * (1 + contrast * np.cos(2 * np.pi * (x - 2) / PITCH))
        value += np.random.default_rng(3).normal(0, 3, len(x))
        np.savetxt(f"{name}.csv", np.stack([x, value], 1), "%.4f", ",",
                   header="position_mm,luminance_cd_m2", comments="")  # fmt: skip
    place = np.arange(33) / 32
    predicted = {
        "luminance": {
            "position_pitch": place.tolist(),
            "luminance_cd_m2": (5000 * (1 + 0.005 * np.cos(2 * np.pi * place))).tolist(),
            "standard_error_cd_m2": [4.0] * 33,
        },
        "lamp_mura_contrast": {"value": 0.005, "ci95": [0.004, 0.006]},
        "gates": [{"name": "lamp_mura_contrast", "limit": 0.01, "marginal_limit": 0.02}],
    }
    (tmp_path / "export").mkdir()
    (tmp_path / "export/verification.json").write_text(json.dumps(predicted))
    return tmp_path


def test_verdict_and_exit_code(files, capsys):
    assert run_app(["judge", "good.csv"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("read good.csv: 2 columns, mm, ','")
    assert printed[1].startswith("PASS: lamp-Mura contrast 0.00")
    assert "(found), 4 whole pitches" in printed[2]
    assert run_app(["judge", "bad.csv", "--pitch-mm", "16"]) == 1
    assert "FAIL" in capsys.readouterr().out


def test_against_an_export(files, capsys):
    arguments = ["judge", "good.csv", "--against", "export", "--json", "--page", "p.html",
                 "--out", "r.json"]  # fmt: skip
    assert run_app(arguments) == 0
    record = json.loads(capsys.readouterr().out)
    assert record == json.loads((files / "r.json").read_text())
    assert record["gates"][0]["limit"] == 0.01
    against = record["against"]
    assert against["luminance_ratio"] == pytest.approx(1.2, rel=1e-3)
    assert against["residual_rms"] < 5e-4
    first = (files / "p.html").read_bytes()
    assert b"good.csv: PASS" in first
    assert run_app(arguments) == 0
    assert (files / "p.html").read_bytes() == first


def lamps(folder, pitch):
    """State the lamp pitch [mm] of the export's job."""
    path = folder / "export/verification.json"
    predicted = json.loads(path.read_text())
    predicted["job"] = {"stack": {"quantity": {"lamp_pitch_mm": {"value": pitch}}}}
    path.write_text(json.dumps(predicted))


@pytest.mark.parametrize("pitch", [14.0, 15.0, 18.0])
def test_a_prediction_of_other_lamps_is_refused(files, capsys, pitch):
    """Found, 16 mm; the contrast of another backlight says nothing of this one."""
    lamps(files, pitch)
    assert run_app(["judge", "good.csv", "--against", "export", "--page", "p.html"]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and len(printed.err.splitlines()) == 1 and len(printed.err) < 320
    for words in ("good.csv", "--against export", f"off {pitch:g} mm", "expected lamps of one"):
        assert words in printed.err
    assert not (files / "p.html").exists()


@pytest.mark.parametrize(("pitch", "said"), [(16.0, False), (15.9, False), (15.5, True)])
def test_a_lamp_pitch_a_little_off_is_said(files, capsys, pitch, said):
    lamps(files, pitch)
    assert run_app(["judge", "good.csv", "--against", "export", "--json"]) == 0
    notes = json.loads(capsys.readouterr().out).get("notes", [])
    assert any("lamp pitch" in note and f"{pitch:g} mm" in note for note in notes) == said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.csv"], "none.csv: no such file"),
        (["good.csv", "--pitch-mm", "200"], "whole lamp pitch of 200 mm"),
        (["good.csv", "--against", "."], "verification.json: no luminance"),
        (["good.csv", "--pixel-mm", "0"], "--pixel-mm: 0: expected above 0"),
        (["good.csv", "--cell-mm", "3"], "--cell-mm"),
        (["good.csv", "--limit", "2"], "--limit"),
    ],
)
def test_bad_input_is_one_line(files, capsys, arguments, words):
    assert run_app(["judge", *arguments]) == 2
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert words in error


@pytest.mark.parametrize(("fall", "said"), [(0.0, False), (0.02, True)])
def test_a_slow_trend_is_said(files, capsys, fall, said):
    """Vignetting, or lamps of one side that are brighter, counts as lamp Mura of a pitch."""
    x = np.arange(0.0, 70.0, 0.25)
    value = 6000 * (1 + 0.02 * np.cos(2 * np.pi * (x - 2) / PITCH)) * (1 - fall * x / 70)
    value += np.random.default_rng(4).normal(0, 3, len(x))
    rows = np.stack([x, value], 1)
    np.savetxt("t.csv", rows, "%.4f", ",", header="position_mm,luminance_cd_m2", comments="")
    run_app(["judge", "t.csv", "--pitch-mm", "16", "--json"])
    notes = json.loads(capsys.readouterr().out).get("notes", [])
    assert any("lamp pitch and the next differs by up to 0.4" in note for note in notes) == said
