"""Films under LEDs as printed: their resin, and the contrast that a known light then has."""

import numpy as np
import pytest
from tone_process import CALIBRATION, GROOVE

from mpfcad.job import build_job
from mpfcad.measure.cell.estimator import Choice, Estimator
from mpfcad.measure.cell.luminance import CellResult
from mpfcad.measure.cell.series import CellSeries
from mpfcad.measure.estimate import Estimate
from mpfcad.pipeline.confidence import printed_cell
from mpfcad.pipeline.confidence.printed import find_printed
from mpfcad.pipeline.confidence.printed_cell import CellRuns
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT

ORDER = np.array([[i, k] for i in (0, 1, 3) for k in (0, 1, 3)])
WAY = Choice(Estimator.forward, "asked for")


def plan_of(folder, deviation=None, **tables):
    process = {}
    if deviation is not None:
        (folder / "process.toml").write_text(CALIBRATION.format(deviation))
        process = {"process": {"calibration": "process.toml"}}
    document = {
        "name": "p",
        "map": {"series_per_mm": [[60.0, 1.0], [1.5, 0.0]]},
        "crossed": {},
        "stack": {"preset": "mini-led-4mm"},
        "cad": {"piece_mm": 0.5, "levels": 256},
        **process,
        **tables,
    }
    return read_plan(build_job(document, "job.toml"), folder / "job.toml")


def flat():
    """Return the light over a cell as flat as can be: what is found is the print's alone."""
    coefficient = np.zeros(len(ORDER))
    coefficient[0] = 100.0
    series = CellSeries(ORDER, coefficient, np.eye(len(ORDER)) * 1e-6, 99.0, 0.0)
    one, cell = Estimate(0.0, 0.0, 0.0, 0.0), np.ones((24, 24))
    return CellResult((4.0, 4.0), series, one, one, cell, cell, {}, 1_000_000, "", True, WAY)


def libraries(plan):
    return [film.drawn for film in plan.films]


def test_both_films_have_so_much_more_resin(tmp_path):
    plan = plan_of(tmp_path, 0.3)
    runs = CellRuns(plan, libraries(plan), flat(), 1, SILENT)
    assert runs.factors[0].sigma == pytest.approx(30.0)
    for library in libraries(plan):
        more = runs.changed(library, np.array([1.0]))
        ratio = GROOVE.fill_fraction(more.wanted) / GROOVE.fill_fraction(library.wanted)
        assert np.allclose(ratio, np.exp(0.3), rtol=1e-6)
        assert more.fill_fraction == pytest.approx(np.exp(0.3) * library.fill_fraction, rel=2e-3)


def test_changed_films_are_what_is_traced(tmp_path):
    plan = plan_of(tmp_path, 0.3)
    runs = CellRuns(plan, libraries(plan), flat(), 1, SILENT)
    lit = runs.light(np.array([-1.5]))
    films = [one for one in lit.elements if hasattr(one, "library")]
    assert len(films) == 2
    for film, library in zip(films, libraries(plan), strict=True):
        middle = np.array([np.interp(0.025, *section.T) for section in film.library.section])
        curvature = 2 * (film.library.high - middle[film.library.chosen]) / 0.025**2
        fill = GROOVE.fill_fraction(curvature).mean()
        assert fill == pytest.approx(np.exp(-0.45) * library.fill_fraction, rel=0.01)


def test_the_width_of_the_process_is_that_of_the_contrast_as_printed(tmp_path, monkeypatch):
    plan = plan_of(tmp_path, 0.3)

    def trace(lit, order, paths, seed, threads, estimator):
        """Return light with a cosine along x of what the resin gains."""
        value = np.zeros(len(order))
        value[0] = 100.0
        value[np.flatnonzero((order == (1, 0)).all(axis=1))] = 5.0 * (lit - 1)
        return value, np.eye(len(order)) * 1e-6, 1000

    monkeypatch.setattr(printed_cell, "trace_terms", trace)
    monkeypatch.setattr(CellRuns, "light", lambda runs, steps: float(np.exp(0.3 * steps[0])))
    found = find_printed(tmp_path, plan, flat(), 2, SILENT)
    # Contrast 0.05 · |e^(0.3 z) - 1|; the second order stands for the exponential.
    assert found["contrast"]["ci95"][1] == pytest.approx(0.05 * np.expm1(0.3 * 1.96), rel=0.1)
    likely = found["probability"]["marginal"]
    assert likely["limit"] == 0.018 and likely["value"] == pytest.approx(0.779, abs=0.04)
    assert found["paths"] == 3000 and found["inputs"][0]["sigma"] == pytest.approx(30.0)


def test_a_process_that_states_no_width_is_not_traced(tmp_path):
    assert find_printed(tmp_path, plan_of(tmp_path), flat(), 1, SILENT) is None
    cells = {"film": {"cell": "pyramid"}, "map": {"curvature_per_mm": 40.0}, "crossed": None}
    assert find_printed(tmp_path, plan_of(tmp_path, **cells), flat(), 1, SILENT) is None
