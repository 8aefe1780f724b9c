"""`mpfcad correct` from outside: what it refuses before any work."""

import json
import re

import numpy as np
import pytest

from mpfcad.cli import run_app
from mpfcad.design import Correction
from mpfcad.errors import InputError
from mpfcad.pipeline.correct.measured import observe_print
from mpfcad.pipeline.correct.printed import refuse_far
from mpfcad.pipeline.judge import Judging
from mpfcad.pipeline.progress import Silent


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
        (["empty", "--measured", "m.csv", "--lamp-at-mm", "3", "--solids", "2"],
         "--solids: 2: expected auto, or above 0 up to 1"),
        (["empty", "--measured", "m.csv", "--lamp-at-mm", "3", "--solids", "thin"],
         "--solids: thin"),
        *[(["empty", "--measured", "m.csv", "--lamp-at-mm", "3", option, value],
           f"{option}: {value}: expected above 0")
          for option, value in (("--pitch-mm", "nan"), ("--pitch-mm", "0"), ("--pitch-mm", "-3"),
                                ("--pixel-mm", "inf"), ("--cd-m2-per-count", "0"))],
    ],
)  # fmt: skip
def test_bad_input_is_one_line(files, capsys, arguments, words):
    assert run_app(["correct", *arguments]) == 2
    error = capsys.readouterr().err.strip()
    assert len(error.splitlines()) == 1
    assert words in error
    assert (files / "full/note.txt").read_text() == "mine"


@pytest.mark.parametrize("own", [None, 20.0])
def test_a_curve_of_another_backlight_is_refused(files, own):
    """A period of 16 mm, folded over 20 mm, would be a plausible curve of hardly any contrast."""
    with pytest.raises(InputError) as error:
        observe_print(files / "m.csv", Judging(pitch=own, lamp=0.0), 20.0)
    seen = re.search(r"variation, ([\d.]+) mm explains 100%: expected a curve of that backlight",
                     str(error.value))  # fmt: skip
    assert seen and float(seen[1]) == pytest.approx(16.0, rel=0.01)
    assert ("--pitch-mm" if own else "the lamp pitch in mm") in str(error.value)


def test_a_stated_pitch_of_another_backlight_is_refused(files):
    with pytest.raises(InputError, match=r"--pitch-mm: 16: expected the lamp pitch of .* 20 mm"):
        observe_print(files / "m.csv", Judging(pitch=16.0, lamp=0.0), 20.0)


def test_a_scale_a_little_off_is_said(files):
    class Notes(Silent):
        def __init__(self):
            self.said = []

        def note(self, text):
            self.said.append(text)

    notes = Notes()
    found = observe_print(files / "m.csv", Judging(lamp=0.0), 16.4, notes)
    assert found.pitch == 16.4
    assert "is -2.4% off the lamp pitch in mm" in notes.said[0]
    observe_print(files / "m.csv", Judging(lamp=0.0), 16.0, notes)
    assert len(notes.said) == 1


def test_a_measurement_of_another_film_is_refused(tmp_path):
    refuse_far(tmp_path / "m.csv", Correction(1.0, np.array([0.2, 0.1, 0.0, 0.0])))
    with pytest.raises(InputError, match=r"m.csv: .* by 81% of its mean .* measurement of this"):
        refuse_far(tmp_path / "m.csv", Correction(1.0, np.array([0.8, 0.1, 0.0, 0.0])))
