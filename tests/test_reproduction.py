"""The page of the thesis's figures beside ours: what its traces and its two fits make it."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from mpfcad.backlight import read_stack

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "benchmarks"))

from thesis import film_case  # noqa: E402
from thesis.by_curvature import by_curvature, contrast  # noqa: E402
from thesis.figure import Figure  # noqa: E402
from thesis.film_case import keep  # noqa: E402
from thesis.page import page  # noqa: E402
from thesis.picture import draw_curvature  # noqa: E402
from thesis.two_fits import NAMES  # noqa: E402

HERE = ROOT / "benchmarks" / "thesis"


def shipped(name):
    return json.loads((HERE / name).read_text("utf-8"))


def test_contrast_of_a_cosine_is_its_amplitude():
    assert contrast(np.array([0.01, 0])) == pytest.approx(0.01, rel=1e-12)
    # A second harmonic alone goes from +a to -a and back within half a pitch.
    assert contrast(np.array([0, -0.02])) == pytest.approx(0.02, rel=1e-12)


#: Where the thesis's films are traced [1/mm].
TRACED = np.array([50.0, 57.0, 60.0, 65.0, 70.0, 81.0])


def made_up(noise, seed):
    """Return readings whose contrast is 0.006 + 0.01 c² with c = (C - 65)/15, and their errors."""
    rng = np.random.Generator(np.random.Philox(seed))
    reading = noise * rng.standard_normal((len(TRACED), 3))
    reading[:, 1] += 0.006 + 0.01 * ((TRACED - 65) / 15) ** 2
    return reading, np.full((len(TRACED), 3), noise)


def test_the_good_range_of_curvature_is_found():
    found = by_curvature(TRACED, *made_up(1e-6, 5))
    edge = 15 * np.sqrt(0.6)
    assert found["best_per_mm"][0] == pytest.approx(65, abs=0.26)
    assert found["range_low_per_mm"][0] == pytest.approx(65 - edge, abs=0.26)
    assert found["range_high_per_mm"][0] == pytest.approx(65 + edge, abs=0.26)


def test_the_bands_hold_the_curve_that_the_noisy_traces_are_of(monkeypatch):
    """At 57 /mm in 400 noisy sets; 3 sigma of a share of 0.95 are 0.033."""
    monkeypatch.setattr("thesis.by_curvature.CURVATURE", np.array([57.0]))
    monkeypatch.setattr("thesis.by_curvature._FINE", np.array([57.0]))
    truth = 0.006 + 0.01 * (8 / 15) ** 2
    held = 0
    for seed in range(400):
        band = by_curvature(TRACED, *made_up(0.0005, seed), seed=seed)["contrast"]
        held += band["low"][0] <= truth <= band["high"][0]
    assert 0.917 <= held / 400 <= 0.983


def test_the_preset_is_the_fit_to_the_simulated_figures():
    fitted = read_stack("thesis-fitted-mpf")
    for row in shipped("fit-simulated.json")["values"]:
        assert fitted[row["name"]] == float(f"{row['value']:.4g}")


def test_both_fits_are_of_the_standard_effort_and_settled():
    for name in NAMES:
        fit = shipped(f"fit-{name}.json")
        assert fit["effort"] == "standard" and fit["settled"]


def test_the_page_is_what_its_results_make():
    results = shipped("results.json")
    fits = {name: shipped(f"fit-{name}.json") for name in NAMES}
    docs = ROOT / "docs"
    assert (docs / "reproduction.md").read_text("utf-8") == page(results, fits, "reproduction.svg")
    assert (docs / "reproduction.svg").read_text("utf-8") == draw_curvature(results)


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
