"""A page about LEDs says LEDs, and offers nothing that they do not have."""

import pytest

from mpfcad.backlight import read_stack
from mpfcad.report.drawing.energy_drawing import draw_energy
from mpfcad.report.film.influence import influence_of
from mpfcad.report.film.section import _energy_rows
from mpfcad.report.film.wording import sources_of, states_confidence
from mpfcad.report.page.environment import render

PYRAMIDS = {"job": {"resolved": {"film": {"cell": "pyramid"}}}}
ENERGY = {"in": 1.0, "out": 0.7, "absorbed_by": {"lamps": 0.1, "reflector": 0.2}, "lost": 0.0}


def test_where_the_light_goes():
    drawn = draw_energy(ENERGY, "LEDs")
    assert "light of the LEDs" in drawn and "absorbed by LEDs: 10.0%" in drawn
    rows = _energy_rows([ENERGY], "LEDs")
    assert ["absorbed by LEDs", "0.1"] in rows
    assert not any("lamp" in words for words in (drawn, *(row[0] for row in rows)))


@pytest.mark.parametrize("preset", ["led-tv-20mm", "led-automotive-6mm", "mini-led-4mm"])
def test_what_an_input_would_change(preset):
    named = {key: influence_of(f"stack.{key}") for key in read_stack(preset).quantity}
    assert {key: words for key, words in named.items() if "lamp" in words} == {}
    cups = {key: words for key, words in named.items() if "cup" in key and "reflect" not in key}
    assert len(cups) == 4 and all("cups" in words for words in cups.values())


@pytest.mark.parametrize(
    ("more", "sources", "states"),
    [({}, "lamps", True), ({"cell": {"across_mm": 1.0}}, "LEDs", True),
     ({"cell": {"across_mm": 1.0}, **PYRAMIDS}, "LEDs", False), (PYRAMIDS, "lamps", True),
     ({"colour": {}}, "lamps", False), ({"judged": {"words": "worst pitch"}}, "lamps", False)],
)  # fmt: skip
def test_the_confidence_is_offered_where_it_can_be_had(more, sources, states):
    assert (sources_of(more), states_confidence(more)) == (sources, states)
    page = render("report/confidence.html.j2", confidence=None, sliders=None, record=more,
                  states_confidence=states_confidence(more))  # fmt: skip
    assert ("Not asked for" in page) is states
    assert ("takes tubes without a rim" in page) is not states
