"""Comparisons under LEDs: what each case is, and the page of one whole comparison."""

import json

import numpy as np
import pytest

from mpfcad.optics.element import Film, LibraryFilm
from mpfcad.pipeline import TRACE_SETTINGS, Measuring, TraceSetting, compare_cases, read_cases
from mpfcad.pipeline.measure.led_case import plain_cases

JOB = (
    'name = "two"\n[map]\nseries_per_mm = [[60.0, 1.0], [1.5, 0.0]]\n[crossed]\n'
    '[stack]\npreset = "mini-led-4mm"\n[cad]\npiece_mm = 0.25\n'
)


@pytest.fixture
def cases(tmp_path):
    path = tmp_path / "job.toml"
    path.write_text(JOB)
    return read_cases(str(path))


def films(case):
    kinds = {Film: "bare", LibraryFilm: "printed"}
    return [kinds[type(one)] for one in case.lit.elements if type(one) in kinds]


def test_two_printed_films_come_alone_and_together(cases):
    alone, both = cases
    assert (films(alone), films(both)) == (["printed", "bare"], ["printed", "printed"])
    assert alone.name == "two, first film alone" and both.name == "two"
    assert alone.lit.case["mesh"] == both.lit.case["mesh"]


def test_they_are_held_against_their_own_stack(cases):
    none, bare = plain_cases(cases[-1].lit)
    assert films(none) == [] and films(bare) == ["bare", "bare"]
    turned = [one.rotation for one in bare.lit.elements if isinstance(one, Film)]
    assert turned == pytest.approx([0, np.pi / 2])
    sheets = [len(case.lit.elements) for case in (none, bare, cases[0])]
    assert sheets[0] + 2 == sheets[1] == sheets[2]


def test_one_printed_film_is_one_case(tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(JOB.replace("[crossed]\n", ""))
    assert [films(case) for case in read_cases(str(path))] == [["printed", "bare"]]


@pytest.mark.slow
def test_a_comparison_end_to_end(cases, tmp_path, monkeypatch):
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(0.004, 20_000))
    record = compare_cases(cases, tmp_path / "out", Measuring(effort="quick"))
    assert json.loads((tmp_path / "out" / "compare.json").read_text()) == record
    labels = [case["label"] for case in record["cases"]]
    assert [label.partition(" in ")[0] for label in labels] == [
        "no prism film", "bare prisms", "two, first film alone", "two"
    ]  # fmt: skip
    assert (
        record["baseline"] == labels[1] and record["cases"][1]["relative_luminance"]["value"] == 1
    )
    contrast = [case["contrast"]["lamp_mura_contrast"]["value"] for case in record["cases"]]
    assert contrast[0] > contrast[3]
    page = (tmp_path / "out" / "compare.html").read_text()
    assert page.count("data:image/png") >= 8 and "first film alone" in page
