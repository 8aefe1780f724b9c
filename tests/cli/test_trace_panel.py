"""`mpfcad trace` on a finite panel says what is judged and where the worst pitch is."""

import json

import pytest
from harness import film_file, groove

from mpfcad.cli import run_app
from mpfcad.pipeline.effort import TraceSetting
from mpfcad.pipeline.measure import trace as module

STACK = """extends = "thesis-32in-mpf"
extent = "panel"
[value]
lamp_count = 4
panel_width_mm = 130.76
rim_mm = """


@pytest.fixture
def traced(tmp_path, monkeypatch, capsys):
    setting = {"quick": TraceSetting(half_width_goal=1.0, path_limit=1)}
    monkeypatch.setattr(module, "TRACE_SETTINGS", setting)
    film = film_file(tmp_path / "film.stl", [groove(60.0)] * 20, base=0.2)

    def run(rim, *more):
        path = tmp_path / "panel.toml"
        path.write_text(f"{STACK}{rim}\n")
        words = ["trace", film, "--stack", path, "--effort", "quick", "--threads", "1", *more]
        code = run_app(list(map(str, words)))
        return code, *capsys.readouterr()

    return run


def test_the_worst_pitch_is_named_with_its_place(traced):
    # The outer lamps stand 16.345 mm from the sides, so a rim of 20 mm leaves the middle's pitch.
    code, out, _ = traced(20)
    assert code == 0
    assert "worst pitch 2 of 3, 49.0 to 81.7 mm from the left; 2 in the rim of 20 mm" in out
    found = json.loads(traced(16, "--json")[1])
    assert [one["judged"] for one in found["pitches"]] == [True] * 3
    worst = max(found["pitches"], key=lambda one: one["value"])
    assert found["judged"]["worst_from_to_mm"] == worst["from_to_mm"]
    assert (found["judged"]["first_pitch"], found["judged"]["last_pitch"]) == (1, 3)


def test_a_rim_that_leaves_no_pitch_is_one_line(traced):
    code, out, err = traced(60)
    assert (code, out) == (2, "")
    assert "rim_mm: 60: expected at most 49.035, so that a whole lamp pitch" in err
    assert len(err.splitlines()) == 1
