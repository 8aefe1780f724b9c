"""`mpfcad correct` from outside: what it refuses before any work."""

import json

import numpy as np
import pytest

from mpfcad.cli import run_app


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x = np.arange(0.0, 70.0, 0.25)
    value = 6000 * (1 + 0.01 * np.cos(2 * np.pi * x / 16))
    rows = np.stack([x, value], 1)
    np.savetxt("m.csv", rows, "%.4f", ",", header="position_mm,luminance_cd_m2", comments="")
    (tmp_path / "empty").mkdir()
    (tmp_path / "old").mkdir()
    (tmp_path / "old/verification.json").write_text(json.dumps({"job": {"given": {}}}))
    (tmp_path / "full").mkdir()
    (tmp_path / "full/note.txt").write_text("mine")
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["empty", "--measured", "m.csv", "--lamp-at-mm", "3"], "expected an export of mpfcad run"),
        (["old", "--measured", "m.csv", "--lamp-at-mm", "3"], "old"),
        (["empty", "--measured", "m.csv", "--lamp-at-mm", "3", "--out", "full"], "full: folder"),
        (["empty", "--measured", "m.csv", "--lamp-at-mm", "3", "--pixel-mm", "1", "--crop", "1"],
         "--crop"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(files, capsys, arguments, words):
    assert run_app(["correct", *arguments]) == 2
    error = capsys.readouterr().err.strip()
    assert len(error.splitlines()) == 1
    assert words in error
    assert (files / "full/note.txt").read_text() == "mine"
