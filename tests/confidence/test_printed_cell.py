"""Films under LEDs as printed: their resin, and the contrast that a known light then has."""

import numpy as np
import pytest
from led_job import flat, plan_of
from tone_process import GROOVE

from mpfcad.pipeline.confidence import cell_runs
from mpfcad.pipeline.confidence.cell_variant import CellVariants, cell_variants_of
from mpfcad.pipeline.confidence.printed import find_printed
from mpfcad.pipeline.progress import SILENT


def libraries(plan):
    return [film.drawn for film in plan.films]


def test_both_films_have_so_much_more_resin(tmp_path):
    plan = plan_of(tmp_path, 0.3)
    with cell_variants_of(plan, tmp_path) as variants:
        (factor,) = variants.print_factors()
        assert factor.sigma == pytest.approx(30.0)
        for library in libraries(plan):
            more = variants.resin.changed(library, {"resin_percent": 30.0})
            ratio = GROOVE.fill_fraction(more.wanted) / GROOVE.fill_fraction(library.wanted)
            assert np.allclose(ratio, np.exp(0.3), rtol=1e-6)
            assert more.fill_fraction == pytest.approx(
                np.exp(0.3) * library.fill_fraction, rel=2e-3
            )


def test_changed_films_are_what_is_traced_and_written_once(tmp_path):
    plan = plan_of(tmp_path, 0.3)
    with cell_variants_of(plan, tmp_path) as variants:
        (factor,) = variants.print_factors()
        lit, again = (variants.light({factor: -1.5}) for _ in range(2))
        films = [one for one in lit.elements if hasattr(one, "library")]
        assert len(films) == 2
        for film, library in zip(films, libraries(plan), strict=True):
            middle = np.array([np.interp(0.025, *section.T) for section in film.library.section])
            curvature = 2 * (film.library.high - middle[film.library.chosen]) / 0.025**2
            fill = GROOVE.fill_fraction(curvature).mean()
            assert fill == pytest.approx(np.exp(-0.45) * library.fill_fraction, rel=0.01)
        same = [one for one in again.elements if hasattr(one, "library")]
        assert all(a.library is b.library for a, b in zip(films, same, strict=True))


def test_the_width_of_the_process_is_that_of_the_contrast_as_printed(tmp_path, monkeypatch):
    plan = plan_of(tmp_path, 0.3)

    def trace(lit, order, paths, seed, threads, estimator):
        """Return light with a cosine along x of what the resin gains."""
        value = np.zeros(len(order))
        value[0] = 100.0
        value[np.flatnonzero((order == (1, 0)).all(axis=1))] = 5.0 * (lit - 1)
        return value, np.eye(len(order)) * 1e-6, 1000

    def light(variants, steps):
        return float(np.exp(0.3 * sum(steps.values())))

    monkeypatch.setattr(cell_runs, "trace_terms", trace)
    monkeypatch.setattr(CellVariants, "light", light)
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
