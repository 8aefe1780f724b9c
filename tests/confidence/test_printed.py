"""The film as printed: what the process does not know of it reaches contrast and words."""

from dataclasses import replace

import numpy as np
import pytest
from tone_process import CALIBRATION, GROOVE

from mpfcad.confidence.response import shrink_each
from mpfcad.errors import InputError
from mpfcad.film import Process, prior_belief, read_process
from mpfcad.job import build_job
from mpfcad.measure import POINTS, TraceRun, light_film, luminance_over_pitch
from mpfcad.pipeline.confidence.printed import find_printed
from mpfcad.pipeline.confidence.runs import Runs
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad
from mpfcad.report.film.wording import print_sentence


def document(**tables):
    return {
        "schema": 1,
        "name": "p",
        "map": {"rows": [[0.0, 64.0], [4.0, 52.0], [8.0, 64.0]]},
        "stack": {"preset": "thesis-32in-mpf", "override": {"lamp_pitch_mm": 8.0}},
        **tables,
    }


def plan_of(folder, **tables):
    return read_plan(build_job(document(**tables), "job.toml"), folder / "job.toml")


@pytest.fixture
def luminance(tmp_path):
    plan = plan_of(tmp_path)
    write_cad(plan, tmp_path, ("stl",), SILENT)
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    found = luminance_over_pitch(lit, TraceRun(seed=1), half_width_goal=1.0)
    # A film as flat as can be: what is found below is the print's alone.
    return replace(found, luminance=np.ones(POINTS), standard_error=np.full(POINTS, 1e-4))


@pytest.fixture
def printed_with(tmp_path, luminance, monkeypatch):
    """Find the film as printed, the light a cosine of what the resin at the pitch's ends gains."""

    def trace(runs, steps, _):
        change = dict(
            zip(
                [f.name for f in runs.factors],
                np.multiply(steps, [f.sigma for f in runs.factors]),
                strict=True,
            )
        )
        resin = runs.variants._changed(change).fill_fraction[0]
        more = resin / runs.variants.plan.piece.fill_fraction[0] - 1
        curve = 1 + 0.05 * more * np.cos(2 * np.pi * np.linspace(0, 1, POINTS))
        return runs.reading.read(curve), runs.reading.spread(curve, np.full(POINTS, 1e-4))

    monkeypatch.setattr(Runs, "trace", trace)

    def find(deviation):
        (tmp_path / "process.toml").write_text(CALIBRATION.format(deviation))
        plan = plan_of(tmp_path, process={"calibration": "process.toml"})
        return find_printed(tmp_path, plan, luminance, 2, SILENT)

    return find


def test_modes_hold_the_width_that_the_belief_states():
    belief = prior_belief(0.6, 0.2)
    process = Process.build_tone(GROOVE, belief, "test")
    ratio = np.linspace(0.1, 0.8, 30)
    modes = process.fill_modes(ratio)
    variance = process.fill_deviation(ratio) ** 2
    assert np.sum(modes**2) <= np.sum(variance) * (1 + 1e-12)
    assert np.sum(modes**2) > 0.9 * np.sum(variance)
    # Principal axes: the errors of two modes have nothing in common.
    assert abs(modes[0] @ modes[-1]) < 1e-9 or len(modes) == 1


def test_a_process_without_a_width_has_no_modes():
    assert read_process(None, GROOVE).fill_modes(0.1) is None


def test_one_effect_among_noise_is_kept():
    effect = np.array([[0.01, 0.001, -0.001, 0.0]])
    covariance = np.diag([4e-6] * 4)[None]
    found, left = shrink_each(effect, covariance)
    np.testing.assert_allclose(found, [[0.0096, 0.0, 0.0, 0.0]])
    # Of the effect 1 - 3/25 of the noise is in doubt; of what is not told from none, 2/5 and more.
    assert np.diag(left[0])[0] == pytest.approx(0.88 * 4e-6, rel=1e-3)
    assert (np.diag(left[0])[1:] >= 0.4 * 4e-6).all() and (np.diag(left[0])[1:] < 0.42 * 4e-6).all()


def test_the_width_of_the_process_is_that_of_the_contrast_as_printed(printed_with):
    wide = printed_with(0.3)
    assert wide["inputs"][0]["sigma"] == pytest.approx(30.0)
    # Contrast 0.05 · |e^(0.3 z) - 1|; the second order stands for the exponential.
    assert wide["contrast"]["ci95"][1] == pytest.approx(0.05 * np.expm1(0.3 * 1.96), rel=0.1)
    # At most 0.018: -1.49 <= z <= 1.025.
    found = wide["probability"]["marginal"]
    assert found["limit"] == 0.018 and found["value"] == pytest.approx(0.779, abs=0.04)


def test_a_process_that_states_no_width_is_not_traced(tmp_path):
    assert find_printed(tmp_path, plan_of(tmp_path), None, 1, SILENT) is None


def test_a_second_width_beside_the_process_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"confidence.resin_percent: 5: expected to be left out"):
        plan_of(tmp_path, mask={"mesh": "150-31"}, process={"solids_fraction": 0.5},
                confidence={"resin_percent": 5.0})  # fmt: skip
    assert plan_of(tmp_path, confidence={"resin_percent": 5.0}).process is not None


def test_the_verdict_says_what_the_print_makes_of_it():
    record = {"process": {}, "printing": {"curvature_half_width_per_mm": 7.9}}
    assert "± 7.9 /mm (95 %): the verdict leaves it out" in print_sentence(record)
    record["printed"] = {
        "contrast": {"value": 0.01, "ci95": [0.005, 0.031]},
        "probability": {"marginal": {"limit": 0.018, "value": 0.35, "ci95": [0.3, 0.4]}},
    }
    assert "between 0.0050 and 0.0310 (95 %)" in print_sentence(record)
    assert "35%" in print_sentence(record)
    assert print_sentence({**record, "confidence": {}}) == ""
    assert "is not known" in print_sentence({"process": {}, "printing": None})
