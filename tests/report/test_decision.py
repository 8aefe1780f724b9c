"""The page that decides: what is said beside the verdict."""

import html
import re

import numpy as np
import pytest

from mpfcad.report.drawing.strip import strip_of
from mpfcad.report.film.decision import decision_values
from mpfcad.report.film.section import _pitch_rows
from mpfcad.report.film.wording import states_confidence
from mpfcad.report.page.environment import render


def trace(contrast, low, high):
    value = [7000.0 + 10 * (i % 3) for i in range(33)]
    return {
        "lamp_mura_contrast": {"value": contrast, "ci95": [low, high]},
        "mean_luminance_cd_m2": {"value": 7000.0, "ci95": [6990.0, 7010.0]},
        "degrees_of_freedom": 30.0,
        "luminance": {
            "position_pitch": [i / 32 for i in range(33)], "luminance_cd_m2": value,
            "standard_error_cd_m2": [10.0] * 33,
        },
        "curve": {"luminance_cd_m2": value},
    }  # fmt: skip


def record(low, high, outcome, **more):
    gates = [
        {"name": "lamp_mura_contrast", "value": (low + high) / 2, "ci95": [low, high],
         "limit": 0.012, "marginal_limit": 0.018, "outcome": outcome},
        {"name": "step_valid", "value": 1.0, "ci95": None, "limit": 1.0, "outcome": "FAIL"},
    ]  # fmt: skip
    inputs = [
        {"name": "stack.a_mm", "value": 1, "tag": "assumed", "source": ""},
        {"name": "stack.b_mm", "value": 1, "tag": "given", "source": ""},
        {"name": "mask.pattern", "value": "slot", "tag": "assumed", "source": ""},
    ]
    return {
        "name": "film", "verdict": "FAIL", "gates": gates, "relative_luminance": 1.05,
        "plain": trace(0.05, 0.045, 0.055), "baseline": trace(0.012, 0.010, 0.014),
        "process": None, "inputs": inputs, **trace((low + high) / 2, low, high), **more,
    }  # fmt: skip


def shown(found):
    page = render("report/decision.html.j2", record=found, decision=decision_values(found),
                  film={"plot": None}, states_confidence=states_confidence(found))  # fmt: skip
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", page)))


def test_what_the_files_leave_out_stands_beside_the_verdict():
    words = "film: solids and meshes leave out resin narrower than 0.2 µm"
    assert f"{words}." in shown(record(0.001, 0.008, "PASS", notes=[words]))
    assert "leave out" not in shown(record(0.001, 0.008, "PASS"))


def test_what_is_assumed_stands_beside_the_verdict():
    text = shown(record(0.001, 0.008, "PASS"))
    for words in (
        "the whole 95 % interval is within 0.012", "Not passed: STEP: valid solids (FAIL).",
        "1 of 2 values are assumed, not measured: a_mm.", "mask.pattern", "--confidence",
    ):  # fmt: skip
        assert words in text


@pytest.mark.parametrize(
    ("stack", "words", "rows"),
    [
        (None, "Baseline: a plain BEF in this backlight; the job names no other.", 2),
        ("slim", "Baseline: a plain BEF in slim, which the job names. The contrast", 3),
    ],
)
def test_the_page_says_what_the_film_is_compared_with(stack, words, rows):
    base = trace(0.012, 0.010, 0.014) | {
        "is_own": stack is None, "stack": stack or "own",
        "words": f"a plain BEF in {stack or 'this backlight'}",
    }  # fmt: skip
    found = record(0.001, 0.008, "PASS", baseline=base)
    text = shown(found)
    assert words in text
    assert "share of the baseline's luminance" in text
    assert len(decision_values(found)["scale"]["rows"]) == rows


def test_a_panel_s_page_says_which_pitch_was_judged_and_repeats_none():
    words = "worst pitch 3 of 4, 20.0 to 28.0 mm from the left"
    row = {"value": 0.01, "ci95": [0.0, 0.02], "from_to_mm": [20.0, 28.0], "judged": True}
    curve = {"luminance_cd_m2": [7000.0 + 10 * i for i in range(33)]}
    found = record(0.001, 0.008, "PASS", judged={"words": words}, pitches=[row], curve=curve)
    text = shown(found)
    assert f"Contrast: {words}. Luminance, pictures and curves: the panel's middle." in text
    assert "one pitch, repeated" not in text
    assert "the lamp pitch in the panel's middle" in text
    assert len(np.unique(strip_of(found))) == strip_of(found).size
    assert _pitch_rows(found) == [["20.0 … 28.0", "0.0100 [0.0000, 0.0200]", "yes"]]


def test_confidence_says_how_sure_and_what_it_hangs_on():
    probability = {
        name: {"limit": limit, "value": value, "ci95": [value - 0.1, value + 0.1]}
        for name, limit, value in (("pass", 0.012, 0.32), ("marginal", 0.018, 0.67))
    }
    confidence = {
        "probability": probability, "contrast": {"value": 0.011, "ci95": [0.002, 0.021]},
        "inputs": [{"name": "top_sheet_sigma", "sigma": 0.028, "share_of_variance": 0.53}],
        "measure_next": [{"measurement": "BTDF of the top sheet", "contrast_spread": 0.0171,
                          "contrast_spread_before": 0.0249}],
    }  # fmt: skip
    text = shown(record(0.001, 0.008, "PASS", confidence=confidence))
    for words in (
        "contrast at most 0.012: 32% likely (22% … 42%)", "top_sheet_sigma", "± 0.028", "53.0 %",
        "Measure next: BTDF of the top sheet", "0.0110 [0.0020, 0.0210]",
    ):  # fmt: skip
        assert words in text
    assert "--confidence" not in text


@pytest.mark.parametrize(
    ("low", "high", "end"), [(0.001, 0.008, 0.05775), (0.05, 0.06, 0.063), (0.5, 0.6, 0.63)]
)
def test_the_scale_holds_the_interval_and_both_limits(low, high, end):
    scale = decision_values(record(low, high, "FAIL"))["scale"]
    assert float(scale["end"]) == pytest.approx(end, rel=0.01)
    film = scale["rows"][0]
    assert film["left"] == pytest.approx(100 * low / end, abs=0.1)
    assert film["left"] + film["width"] <= 100
    assert [mark["at"] for mark in scale["marks"]] == pytest.approx(
        [100 * 0.012 / end, 100 * 0.018 / end], abs=0.1
    )


def test_films_are_shown_on_one_scale():
    strips = decision_values(record(0.001, 0.008, "PASS"))["strips"]
    assert [row["name"] for row in strips["rows"]] == [
        "this film: film", "plain BEF in this backlight", "the conventional stack",
    ]  # fmt: skip
    assert len({row["seen"] for row in strips["rows"]}) == 1
