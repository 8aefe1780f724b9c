"""The fit of the stack and the page of the thesis's figures beside ours."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from mpfcad.backlight import read_stack

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "benchmarks"))

from thesis import film_case  # noqa: E402
from thesis.figure import Figure  # noqa: E402
from thesis.film_case import keep  # noqa: E402
from thesis.fit import Target, fit_values, read_targets  # noqa: E402
from thesis.page import page  # noqa: E402
from thesis.picture import draw_curvature  # noqa: E402
from thesis.range_of_curvature import by_curvature  # noqa: E402
from thesis.response import contrast, fit_surface, read_curve  # noqa: E402
from thesis.trial import FACTORS, screening_design  # noqa: E402

HERE = ROOT / "benchmarks" / "thesis"


def shipped(name):
    return json.loads((HERE / name).read_text("utf-8"))


def test_the_design_tells_each_factor_from_the_others_and_from_products():
    design = screening_design()
    factors = design.shape[1]
    assert np.array_equal(design.T @ design, 24 * np.eye(factors))
    assert not design.sum(0).any()
    for i in range(factors):
        products = design[:, [i]] * np.delete(design, i, 1)
        assert not (design.T @ products).any()


def test_contrast_of_a_cosine_is_its_amplitude():
    assert contrast(np.array([0.01, 0, 0, 0])) == pytest.approx(0.01, rel=1e-12)
    # A second harmonic alone goes from +a to -a and back within half a pitch.
    assert contrast(np.array([0, -0.02, 0, 0])) == pytest.approx(0.02, rel=1e-12)


def test_a_curve_is_read_back():
    u = np.linspace(0, 1, 33)
    curve = 7000 * (1 + 0.01 * np.cos(2 * np.pi * u) - 0.003 * np.cos(6 * np.pi * u))
    found = read_curve(curve, np.full(33, 5.0))
    assert found == pytest.approx([np.log(7000), 0.01, 0, -0.003, 0], abs=1e-12)


#: Slopes of log luminance and the first harmonic with four values; the last moves nothing.
SLOPE = np.array([[0.02, 0.004], [-0.01, 0.003], [0.015, -0.005], [0.0, 0.0]])


def synthetic_trials(level, first, slope, noise, seed):
    rng = np.random.Generator(np.random.Philox(seed))
    code = np.vstack([screening_design()[:, :4], np.zeros((8, 4))])
    reading = noise * rng.standard_normal((len(code), 5))
    reading[:, :2] += [level, first] + code @ slope
    return code, np.full(len(code), 60.0), reading


def target(name, of, value, kind="equal"):
    return Target(name, name, 60.0, of, kind, value, 0.0, 1e-4)


def test_the_fit_recovers_the_values_that_made_the_figures():
    truth = np.array([0.6, -0.4, 0.3, 0.0])
    noise = 2e-5
    surfaces, targets = {}, []
    # Three films that follow the values differently: the figures hold three of the four.
    for turn, (level, first) in enumerate([(0.05, 0.04), (0.02, 0.03), (0.0, 0.05)]):
        slope = np.r_[np.roll(SLOPE[:3], turn, axis=0), SLOPE[3:]]
        name = f"film {turn}"
        surfaces[name] = fit_surface(*synthetic_trials(level, first, slope, noise, turn), noise)
        true_level, true_first = [level, first] + truth @ slope
        targets.append(target(name, "luminance", float(np.exp(true_level))))
        targets.append(target(name, "contrast", float(true_first)))
    fit = fit_values(surfaces, targets, 4)
    assert fit.code[:3] == pytest.approx(truth[:3], abs=0.05)
    low, high = fit.interval.T
    assert np.all((low <= truth) & (truth <= high))
    assert np.all(fit.held[:3] > 0.98)
    # What moves nothing is not held: it stays at the prior's centre, its interval is the prior's.
    assert fit.held[3] < 0.05 and abs(fit.code[3]) < 0.05
    assert np.all(np.abs(fit.data_interval[3]) >= 1.25)


def test_an_anchored_surface_meets_its_readings_in_luminance_alone():
    code, curvature, reading = synthetic_trials(0.0, 0.01, SLOPE, 1e-5, 3)
    surface = fit_surface(code, curvature, reading, 1e-5)
    there, seen = np.full((4, 4), 0.5), np.full((4, 5), 0.3)
    moved = surface.anchored(there, np.full(4, 60.0), seen)
    assert moved(there[0], 60.0)[0] == pytest.approx(0.3, abs=1e-12)
    before, after = surface(-there[0], 60.0), moved(-there[0], 60.0)
    shift = 0.3 - surface(there[0], 60.0)[0]
    assert after == pytest.approx(before + shift * np.eye(5)[0], abs=1e-12)


def test_a_limit_pulls_only_from_its_wrong_side():
    limit = target("film", "contrast", 0.02, "at_most")
    assert limit.residual(0.01, 0.0) == 0
    assert limit.residual(0.0202, 0.0) == pytest.approx(2)
    floor = target("film", "contrast", 0.02, "at_least")
    assert floor.residual(0.03, 0.0) == 0
    assert floor.residual(0.0198, 0.0) == pytest.approx(-2)


def test_the_good_range_of_curvature_is_found():
    # Contrast 0.006 + 0.01 c² with c = (C - 65)/15: 0.012 at c² = 0.6.
    code = np.vstack([screening_design()[:8, :2], np.zeros((2, 2))])
    curvature = np.repeat([50.0, 57.5, 65.0, 72.5, 80.0], len(code))
    c = (curvature - 65) / 15
    rng = np.random.Generator(np.random.Philox(5))
    reading = 1e-6 * rng.standard_normal((len(curvature), 5))
    reading[:, 1] += 0.006 + 0.01 * c**2
    found = by_curvature(fit_surface(np.tile(code, (5, 1)), curvature, reading, 1e-6), np.zeros(2))
    edge = 15 * np.sqrt(0.6)
    assert found["best_per_mm"][0] == pytest.approx(65, abs=0.26)
    assert found["range_low_per_mm"][0] == pytest.approx(65 - edge, abs=0.26)
    assert found["range_high_per_mm"][0] == pytest.approx(65 + edge, abs=0.26)


def test_the_published_figures_have_one_place():
    targets = {t.name: t for t in read_targets()}
    assert targets["conventional: contrast"].value == 0.012
    for case, luminance in (("MPF", 7243), ("MPF-Plate", 7070)):
        entry = targets[f"{case}, C = 60: luminance"]
        assert abs(entry.value - luminance / 6875) <= entry.rounding
    assert all(
        t.allowance > 0 and t.kind in ("equal", "at_most", "at_least") for t in read_targets()
    )


def test_the_trials_stand_about_the_presets_and_the_fit_is_in_its_own():
    centre, fitted = read_stack("thesis-32in-mpf"), read_stack("thesis-fitted-mpf")
    found = {row["name"]: row for row in shipped("fit.json")["values"]}
    for factor in FACTORS:
        assert factor.centre == centre[factor.name]
        assert fitted[factor.name] == float(f"{found[factor.name]['fitted']:.4g}")


def test_the_page_is_what_its_results_make():
    results, fit = shipped("results.json"), shipped("fit.json")
    docs = ROOT / "docs"
    assert (docs / "reproduction.md").read_text("utf-8") == page(results, fit, "reproduction.svg")
    assert (docs / "reproduction.svg").read_text("utf-8") == draw_curvature(results, fit)


def test_a_verdict_rests_on_the_interval():
    def verdict(low, value, high):
        return Figure(value, low, high).beside(0.012, 0.0005, 0.003, 4)

    assert verdict(0.010, 0.012, 0.014) == "agrees, within 0.0020"
    # The published figure is in the interval, and so is much else.
    assert verdict(0.001, 0.009, 0.016) == "open, within 0.0110"
    assert verdict(0.013, 0.0145, 0.016) == "near"
    assert verdict(0.0125, 0.0135, 0.0145) == "agrees, within 0.0025"
    assert verdict(0.016, 0.018, 0.020) == "differs"


@pytest.mark.parametrize("above", [True, False])
def test_a_limit_within_the_interval_is_open(above):
    sign = 1 if above else -1

    def verdict(low, value, high):
        ends = sorted((5 + sign * low, 5 + sign * high))
        return Figure(5 + sign * value, *ends).beyond(5, above=above, digits=1)

    assert verdict(0.5, 1, 2) == "agrees, by 0.5 or more"
    assert verdict(-1, 0.5, 2) == "open, value agrees"
    assert verdict(-2, -0.5, 1) == "open, value differs"
    assert verdict(-2, -1, -0.5) == "differs"


def test_a_demand_is_met_by_value_and_by_interval_apart():
    assert Figure(2, 1.5, 2.5).keeps(1, 3) == (True, "met")
    assert Figure(2, 0.5, 2.5).keeps(1, 3) == (True, "open")
    assert Figure(0.9, 0.5, 2.5).keeps(1, 3) == (False, "open")
    assert Figure(0.5, 0.2, 0.9).keeps(1, 3) == (False, "not met")
    assert Figure(4, 3.5, 4.5).keeps(1, 3) == (False, "not met")


def test_a_kept_figure_is_of_the_code_that_made_it(tmp_path, monkeypatch):
    monkeypatch.setattr(film_case, "CACHE", tmp_path)
    monkeypatch.setattr(film_case, "code_hash", lambda *packages: "old")
    assert keep("case", [1], lambda: {"figure": 1}) == {"figure": 1}
    assert keep("case", [1], lambda: {"figure": 2}) == {"figure": 1}
    monkeypatch.setattr(film_case, "code_hash", lambda *packages: "new")
    assert keep("case", [1], lambda: {"figure": 3}) == {"figure": 3}


def test_the_shipped_figures_are_of_the_standard_effort():
    results = shipped("results.json")
    assert results["effort"] == "standard"
    for cases in results["set"].values():
        assert all(case["paths"] >= results["path_limit"] for case in cases.values())
