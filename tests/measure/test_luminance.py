"""The measurement from a file on disk to figures with their uncertainty."""

import numpy as np
import pytest
from harness import BARE, film_file, groove

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError, TraceError
from mpfcad.measure import POINTS, TraceRun, contrast_of_curve, light_film, luminance_over_pitch

STACK = "thesis-32in-mpf"


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    folder = tmp_path_factory.mktemp("film")
    return film_file(folder / "film.stl", [groove(60.0)] * 20, base=0.2)


def measured(mesh, stack=None, goal=1.0, **run):
    lit = light_film(stack or read_stack(STACK), mesh)
    return luminance_over_pitch(lit, TraceRun(**run), half_width_goal=goal)


@pytest.fixture(scope="module")
def result(mesh):
    return measured(mesh, seed=7)


def test_points_span_one_pitch(result):
    assert len(result.position_pitch) == POINTS == 33
    assert result.position_pitch[[0, 16, 32]] == pytest.approx((0, 0.5, 1))
    assert (result.standard_error > 0).all()
    assert result.accelerator == "chain"


def test_figures_follow_from_the_points(result):
    assert result.contrast == contrast_of_curve(result.curve, 7)
    error = result.mean_luminance.standard_error
    assert abs(result.mean_luminance.value - result.luminance[:-1].mean()) < 3 * error
    assert result.mean_luminance.low < result.mean_luminance.value < result.mean_luminance.high


def test_energy_is_a_balance(result):
    energy = result.energy
    assert energy["lost"] == 0
    assert energy["absorbed"] == pytest.approx(sum(energy["absorbed_by"].values()))
    total = energy["out"] + energy["absorbed"] + energy["lost"] + energy["imbalance"]
    assert total == pytest.approx(energy["in"], abs=1e-12)
    assert abs(energy["imbalance"]) < 5 * energy["imbalance_standard_error"]


def test_threads_change_nothing_and_seeds_do(mesh, result):
    again = measured(mesh, seed=7, threads=3)
    assert np.array_equal(again.luminance, result.luminance)
    assert again.contrast == result.contrast and again.energy == result.energy
    other = measured(mesh, seed=8)
    assert not np.array_equal(other.luminance, result.luminance)


def test_rounds_go_on_to_the_goal_or_the_limit(mesh, result):
    seen = []
    # A half-width of 0 is reached by none: all the way it is the limit that is expected.
    limited = measured(mesh, goal=0.0, path_limit=result.paths + 1, seed=7, progress=seen.append)
    assert min(state.expected for state in seen) == result.paths + 1
    assert limited.paths == 2 * result.paths == seen[-1].paths
    assert limited.contrast.half_width == seen[-1].error
    assert seen[0].paths < result.paths and seen[0].expected == result.paths + 1
    assert [state.paths for state in seen] == sorted(state.paths for state in seen)
    # The second round is added to the first: errors shrink by about √2.
    assert np.median(limited.standard_error / result.standard_error) == pytest.approx(
        0.71, abs=0.05
    )


def test_more_lamp_luminance_is_more_luminance(mesh, result):
    stack = read_stack(STACK, overrides={"lamp_luminance_cd_m2": 2 * 20100.0})
    bright = measured(mesh, stack, seed=7)
    assert bright.luminance == pytest.approx(2 * result.luminance, rel=1e-12)


def test_a_bad_mesh_is_refused_before_tracing(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        light_film(read_stack(STACK), tmp_path / "none.stl")


def test_lost_paths_are_an_error(tmp_path, monkeypatch):
    from mpfcad.optics import engine

    real = engine.trace

    def leaky(*arguments, **options):
        tally = real(*arguments, **options)
        tally.flow[2] += 1e-5 * tally.total_paths
        return tally

    monkeypatch.setattr(engine, "trace", leaky)
    path = film_file(tmp_path / "film.stl", [BARE] * 20)
    with pytest.raises(TraceError, match="lost"):
        measured(path)
