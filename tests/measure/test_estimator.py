"""Which way a cell of LEDs is traced: as it can be, as asked for, or with less work."""

from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, film_mesh

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import Estimator, TraceRun, camera_image, light_film, luminance_over_cell
from mpfcad.pipeline import Measuring, default_what, measure_film, read_case
from mpfcad.pipeline.effort import MEASURE_SETTINGS, TRACE_SETTINGS, MeasureSetting, TraceSetting
from mpfcad.record import describe_cell

RUN = TraceRun(path_limit=270_000)


def stack(folder, layers, **values):
    """Write a stack of the automotive board with other layers and values."""
    path = folder / "own.toml"
    lines = [f"{name} = {value}" for name, value in values.items()]
    words = ", ".join(layer if layer.startswith("{") else f'"{layer}"' for layer in layers)
    path.write_text(
        f'extends = "led-automotive-6mm"\nlayers = [{words}]\n[value]\n' + "\n".join(lines) + "\n"
    )
    return path


def lit(folder, layers, **values):
    return light_film(read_stack(stack(folder, layers, **values)), None)


def traced(lit, estimator=Estimator.auto):
    return luminance_over_cell(lit, replace(RUN, estimator=estimator), half_width_goal=0.0001)


BARE_ON_TOP = ("clear_plate", "bottom_sheet", "film",
               '{ kind = "bef", name = "across", rotation_deg = 90 }')  # fmt: skip


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """Give bare crossed prisms with no sheet on top."""
    folder = tmp_path_factory.mktemp("bare")
    film_mesh(folder, [BARE])
    return light_film(read_stack(stack(folder, BARE_ON_TOP)), folder / "film.stl")


def test_bare_crossed_prisms_on_top_are_traced_from_the_meter(bare):
    found = traced(bare)
    record = describe_cell(found, 1)
    assert record["estimator"]["name"] == "backward"
    assert "across, is no sheet" in record["estimator"]["reason"]
    assert record["estimator"]["work"] is None
    # Error ∝ 1/√paths.
    more = (found.contrast.half_width / 0.0001) ** 2
    assert record["estimator"]["paths_to_goal"] == pytest.approx(found.paths * more, rel=1e-6)
    energy = record["energy"]
    assert abs(energy["imbalance"]) < 5 * energy["imbalance_standard_error"] and energy["out"] > 0.3
    assert np.mean(record["cell"]["luminance_cd_m2"]) == pytest.approx(
        record["mean_luminance_cd_m2"]["value"]
    )
    with pytest.raises(InputError, match="across: LEDs are traced to a scattering sheet on top"):
        traced(bare, Estimator.forward)


def test_the_camera_sees_them(bare):
    picture = camera_image(bare, RUN, 0.5)
    cell = traced(bare)
    error = picture.standard_error.mean() / picture.luminance.size**0.5
    assert abs(picture.luminance.mean() - cell.mean_luminance.value) < 6 * error


def test_a_pilot_run_chooses_without_touching_the_trace(tmp_path):
    board = lit(tmp_path, ["bottom_sheet", "top_sheet"])
    auto, forward = traced(board), traced(board, Estimator.forward)
    assert auto.choice.estimator is Estimator.forward
    work = dict(auto.choice.work)
    assert work[Estimator.backward] > 3 * work[Estimator.forward] > 0
    assert auto.choice.reason.startswith("backward takes ")
    assert np.array_equal(auto.series.coefficient, forward.series.coefficient)
    assert auto.contrast == forward.contrast and forward.choice.reason == "asked for"
    threads = luminance_over_cell(board, replace(RUN, threads=2), half_width_goal=0.0001)
    assert threads.choice == auto.choice and threads.contrast == auto.contrast


def test_a_pilot_run_tells_the_less_work(tmp_path):
    # LEDs beside each other leave little to chance: what it says holds in the traces themselves.
    board = lit(tmp_path, ["top_sheet"], led_width_mm=12.1, led_length_mm=12.1, led_height_mm=0)
    found = traced(board)
    work = dict(found.choice.work)
    best = min(work, key=work.get)
    assert found.choice.estimator is best is Estimator.backward
    assert found.paths_to_goal is not None


def test_leds_that_the_meter_hardly_meets_are_refused_with_what_it_takes(tmp_path):
    board = lit(tmp_path, ["bottom_sheet", "clear_plate"], led_width_mm=0.02,
                led_length_mm=0.02)  # fmt: skip
    with pytest.raises(InputError, match=r"find an LED: a contrast takes 2000 .* paths") as told:
        traced(board)
    assert len(str(told.value)) <= 300


def test_leds_seen_as_they_are_have_no_series(tmp_path):
    board = lit(tmp_path, ["clear_plate"])
    with pytest.raises(InputError, match="the LEDs are seen as they are") as told:
        traced(board)
    assert len(str(told.value)) <= 300


def test_a_stack_without_a_top_sheet_is_measured(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(0.05, 300_000))
    monkeypatch.setitem(MEASURE_SETTINGS, "quick", MeasureSetting(*(10.0,) * 8))
    film_mesh(tmp_path, [BARE])
    case = read_case(str(tmp_path / "film.stl"), str(stack(tmp_path, BARE_ON_TOP)), None, 0.0)
    assert "psf" not in default_what(case)
    record = measure_film(case, ("contrast", "camera"), tmp_path / "out", Measuring(effort="quick"))
    assert record["contrast"]["estimator"]["name"] == "backward"
    assert "Paths from the meter: the topmost" in (tmp_path / "out" / "measure.html").read_text()
    with pytest.raises(InputError, match="scattering sheet on top"):
        measure_film(case, ("psf",), tmp_path / "psf", Measuring(effort="quick"))
    with pytest.raises(InputError, match="--estimator: sideways: expected auto, forward or back"):
        measure_film(case, ("contrast",), tmp_path / "b", Measuring(estimator="sideways"))
    tubes = read_case("thesis-32in-bef")
    with pytest.raises(InputError, match="lit by tubes"):
        measure_film(tubes, ("contrast",), tmp_path / "t", Measuring(estimator="backward"))
