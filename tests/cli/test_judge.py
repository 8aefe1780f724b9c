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
