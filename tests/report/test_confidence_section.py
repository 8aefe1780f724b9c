"""The report's section on confidence: every figure of the record, or that it was not asked for."""

from mpfcad.report.film.confidence_section import confidence_values
from mpfcad.report.film.wording import states_confidence
from mpfcad.report.page.environment import render

FOUND = {
    "probability": {
        "pass": {"limit": 0.012, "value": 0.32, "ci95": [0.13, 0.44]},
        "marginal": {"limit": 0.018, "value": 0.67, "ci95": [0.49, 0.79]},
    },
    "contrast": {"value": 0.0149, "ci95": [0.0061, 0.031]},
    "inputs": [
        {"name": "top_sheet_sigma", "value": 0.35, "sigma": 0.028, "share_of_variance": 0.75,
         "source": "haze of a data sheet"},
        {"name": "film_index", "value": 1.55, "sigma": 0.01, "share_of_variance": 0.25,
         "source": "<stated>"},
    ],
    "measure_next": [
        {"measurement": "BTDF of the top sheet", "inputs": ["top_sheet_sigma"],
         "contrast_spread_before": 0.0249, "contrast_spread": 0.0171,
         "probability_if_confirmed": 0.86},
    ],
    "left_out": ["resin_percent: of this kind of film no changed one is made"],
    "paths": 8_312_832,
}  # fmt: skip


def page(record):
    values = confidence_values(record)
    return render("report/confidence.html.j2", confidence=values, sliders=None, record=record,
                  states_confidence=states_confidence(record))  # fmt: skip


def test_the_section_shows_what_was_found():
    html = page({"confidence": FOUND})
    for text in (
        "0.32 [0.13, 0.44]", "0.67 [0.49, 0.79]", "0.0149 [0.0061, 0.0310]", "8.3 million",
        "BTDF of the top sheet", "0.0249 → 0.0171", "75.0%", "haze of a data sheet",
        "Not carried: resin_percent", "&lt;stated&gt;",
    ):  # fmt: skip
        assert text in html


def test_without_it_the_section_says_how_to_ask():
    assert confidence_values({}) is None
    assert "mpfcad run --confidence" in page({})
