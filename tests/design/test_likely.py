"""A design for confidence: both designs judged on the same draws, kept, and the likelier chosen."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mpfcad.confidence import probability
from mpfcad.design import Iteration, Traced, scenario, series_rows
from mpfcad.design.optimum import map_on_cells
from mpfcad.job.design import Design
from mpfcad.job.reader import validate
from mpfcad.measure import POINTS
from mpfcad.pipeline.confidence import runs as confidence_runs
from mpfcad.pipeline.confidence.find import Asked
from mpfcad.pipeline.confidence.runs import Runs
from mpfcad.pipeline.design import judged, likely
from mpfcad.pipeline.design.work import DesignWork
from mpfcad.pipeline.progress import SILENT

DOCUMENT = {
    "schema": 1,
    "name": "sure",
    "goal": {"aim": "confidence"},
    "constraint": {"curvature_min_per_mm": 50.0, "curvature_max_per_mm": 66.0, "harmonics": 2},
    "stack": {"preset": "thesis-32in-mpf", "override": {"lamp_pitch_mm": 8.0}},
    "confidence": {"registration_mm": 0.4},
    "mask": {"period_um": 640.0},
}


@pytest.fixture
def work(tmp_path, lamps, monkeypatch):
    """Give the search of a design by a written-down model, all traces told by it."""
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    design = validate(Design, DOCUMENT, "sure.toml")
    made = DesignWork(design, tmp_path / "sure.toml", 1, SILENT)
    made.__dict__["response"] = lamps
    monkeypatch.setattr(probability, "_RESPONSES", 20)
    monkeypatch.setattr(likely, "_DRAWS", 100)
    monkeypatch.setattr(confidence_runs, "_SMOOTH", 0.05)
    monkeypatch.setattr(scenario, "_SOFT", (0.15,))
    asked = []

    def trace(rows, label, number, shift=0.0):
        series = np.array([rows.mean(), *np.zeros(2)])
        luminance = lamps.luminance(map_on_cells(series, lamps))
        mean = float(luminance.mean())
        return Traced(0.004, 0.0, 0.008, mean, 1.0, (mean, *np.zeros(8)), 1000)

    def run(runs, steps, _):
        asked.append(steps)
        # What all inputs together add, more of it the more C there is.
        size = 0.003 * float(np.sum(steps)) * runs.variants.plan.piece.curvature.mean() / 60
        curve = 1 + size * np.cos(2 * np.pi * np.linspace(0, 1, POINTS))
        return runs.reading.read(curve), runs.reading.spread(curve, np.full(POINTS, 1e-4))

    flat = SimpleNamespace(
        luminance=np.ones(POINTS), standard_error=np.full(POINTS, 1e-4),
        curve=SimpleNamespace(is_sharp=False), paths=1000,
    )  # fmt: skip
    monkeypatch.setattr(made, "trace", trace)
    monkeypatch.setattr(Runs, "trace", run)
    monkeypatch.setattr(judged, "luminance_over_pitch", lambda *_, **__: flat)
    return made, asked


def nominal(work):
    series = np.array([60.0, 2.0, 0.0])
    rows = series_rows(series)[1]
    return [
        Iteration("iteration 1", tuple(rows), tuple(series), None, None, work.trace(rows, "", 0))
    ]


def test_both_designs_are_judged_on_the_same_draws_and_the_likelier_is_chosen(work):
    made, asked = work
    done = nominal(made)
    found = likely.search_likely(made, done)
    assert [one.label for one in found.traced] == ["confidence 1", "confidence 2"]
    record = found.record
    shares = {n: record[n]["probability"]["marginal"]["value"] for n in ("nominal", "confidence")}
    assert record["chosen"] == max(shares, key=shares.get)
    assert len(record["nominal"]["traced_contrast"]) == judged.DRAWN
    # By the model the map that is found is at least as likely as the nominal one.
    assert record["predicted_share"][1] >= record["predicted_share"][0]
    for one in found.traced:
        assert min(one.rows) >= 50 and max(one.rows) <= 66
    # All is kept: nothing is traced for it again.
    asked.clear()
    again = likely.search_likely(made, done)
    assert not asked and again.record == record


@pytest.mark.slow
def test_draws_are_the_same_for_any_map(work):
    made, asked = work
    [one] = nominal(made)
    other = replace(one, rows=tuple(c - 1 for c in one.rows))
    parts = []
    for each in (one, other):
        asked.clear()
        judged.judge(made, each, Asked.of(made.job))
        parts.append(np.array(asked))
    assert len(parts[0]) > judged.DRAWN and np.array_equal(*parts)


def test_the_model_is_asked_about_prints_beyond_the_maps_range(work):
    made, _ = work
    low, high = made._model_range()
    fill = made.groove.fill_fraction(np.array([50.0, low]))
    assert fill[1] == pytest.approx(2 * fill[0]) and high == made.groove.curvature_empty
