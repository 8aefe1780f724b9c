"""Sweeps under LEDs: what each axis does to films and board, and one sweep end to end."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.film import Groove
from mpfcad.job.sweep import LED_AXES, read_sweep
from mpfcad.pipeline.plan.departure import Departure, PrintError
from mpfcad.pipeline.point.led import departure_of
from mpfcad.pipeline.point.trace import build_point

HEAD = 'schema = 1\nname = "few"\n'
MAP = "[map]\nseries_per_mm = [[60.0, 1.0, 0.3], [1.5, 0.0, 0.0]]\n[crossed]\n"
REST = '[stack]\npreset = "mini-led-4mm"\n[cad]\npiece_mm = 0.25\nlevels = 256\n'


def point(tmp_path, axis, body=MAP + REST):
    """Return the first point of a sweep with these axes."""
    path = tmp_path / "sweep.toml"
    path.write_text(f"{HEAD}[axis]\n{axis}\n{body}")
    sweep = read_sweep(path)
    return build_point(sweep, path, next(sweep.points()))


def films(tmp_path, axis):
    """Return the maps of both films by the panel's axes, (80, 80) at the grooves of each."""
    plan = point(tmp_path, axis).plan()
    first, across = plan.drawn.wanted, plan.crossed.drawn.wanted
    return first, across[:, ::-1].T  # its x is the panel's y, its y against the panel's x


def test_films_are_moved_alone_and_with_the_board(tmp_path):
    none = films(tmp_path, "led_seed = [1.0]")
    # 0.5 mm is 10 grooves of the first film and 2 pieces of the one across.
    moved = films(tmp_path, "shift_x_mm = [0.5]")
    assert np.allclose(moved[0], np.roll(none[0], 10, axis=0)) and np.array_equal(moved[1], none[1])
    moved = films(tmp_path, "crossed_shift_y_mm = [0.5]")
    assert np.array_equal(moved[0], none[0]) and np.allclose(moved[1], np.roll(none[1], 10, axis=1))
    board = films(tmp_path, "board_shift_x_mm = [-0.5]")
    assert np.allclose(board[0], np.roll(none[0], 10, axis=0))
    assert np.allclose(board[1], np.roll(none[1], 2, axis=0))
    with_both = films(tmp_path, "board_shift_x_mm = [0.5]\nshift_x_mm = [0.5]")
    assert np.allclose(with_both[0], none[0])


def test_turn_and_stretch_are_largest_at_the_corner():
    stack = read_stack("led-automotive-6mm")
    half = stack.panel_width / 2, stack.panel_length / 2
    turned = departure_of(stack, {"turn_deg": 0.1, "shift_x_mm": 0.2}, "w")
    tangent = math.tan(math.radians(0.1))
    assert turned.film(0).shift == pytest.approx((0.2 - tangent * half[1], tangent * half[0]))
    assert turned.film(1).shift == (0, 0)
    stretched = departure_of(stack, {"stretch_percent": 0.1}, "w")
    assert stretched.film(1).shift == pytest.approx((half[0] / 1000, half[1] / 1000))


def test_resin_and_curvature_are_off_as_asked(tmp_path):
    groove = Groove(0.05, 0.025)
    none = films(tmp_path, "led_seed = [1.0]")[0]
    more = films(tmp_path, "resin_percent = [10.0]")[0]
    fill = [np.asarray(groove.fill_fraction(c)) for c in (none, more)]
    assert np.allclose(fill[1], 1.1 * fill[0], rtol=1e-9)
    assert np.allclose(films(tmp_path, "curvature_error_per_mm = [0.7]")[0], none + 0.7)
    wide = films(tmp_path, "pattern_percent = [20.0]")[0]
    assert np.allclose(wide - 60, 1.2 * (none - 60), atol=1e-9)
    # Bare prisms are as bare as it gets.
    assert films(tmp_path, "curvature_error_per_mm = [30.0]")[0].max() == groove.curvature_empty


def test_a_board_of_several_cells_has_the_same_map_at_each_led(tmp_path):
    axis = '"stack.override.led_flux_spread" = [0.1]\nled_repeat = [2.0]\nled_seed = [7.0]\n'
    plan = point(tmp_path, axis + "dead_led = [3.0]").plan()
    one = point(tmp_path, "led_seed = [1.0]").plan()
    for many, single in zip(plan.films, one.films, strict=True):
        assert np.array_equal(many.drawn.chosen, np.tile(single.drawn.chosen, (2, 2)))
    led = plan.stack.source.placed
    assert plan.stack.period == (8.0, 8.0) and led[2, 2] == 0 and np.ptp(led[[0, 1, 3], 2]) > 0.01
    other = Departure(seed=8).of_board(plan.stack, "w").source.placed
    assert not np.allclose(other[:, 2], led[:, 2])
    assert Departure((PrintError(),)).of_board(plan.stack, "w") is plan.stack


def test_keys_tell_points_apart(tmp_path):
    axes = ["shift_x_mm = [0.5]", "shift_x_mm = [0.25]", "crossed_shift_x_mm = [0.5]",
            "led_repeat = [2.0]", "resin_percent = [1.0]"]  # fmt: skip
    keys = {point(tmp_path, axis).key() for axis in axes}
    assert len(keys) == len(axes)
    same = point(tmp_path, axes[0])
    assert same.key() == replace(same, where=str(tmp_path / "other.toml")).key()


WRONG = [
    ("lamp_count = [3.0]", MAP + REST, "lamp_count: LEDs light the stack"),
    ("shift_mm = [3.0]", MAP + REST, "shift_mm: LEDs light the stack"),
    ("led_repeat = [1.5]", MAP + REST, "led_repeat: 1.5: expected a whole number of 1 or more"),
    ("dead_led = [2.0]", MAP + REST, "source.dead: LED 2: expected at most 1"),
    ("turn_deg = [0.1]", "[map]\ncurvature_per_mm = 60\n", "turn_deg: tubes light the stack"),
    ("resin_percent = [2000.0]", MAP + REST, "expected 0 … 80 /mm"),
    ("resin_percent = [-100.0]", MAP + REST, "resin_percent: -100: leaves no resin: expected ab"),
    ("resin_percent = [-150.0]", MAP + REST, "resin_percent: -150: leaves no resin: expected ab"),
    ("curvature_error_per_mm = [100.0]", MAP + REST, "curvature_error_per_mm: 100: no C is left"),
    ("curvature_error_per_mm = [-100.0]", MAP + REST, "error_per_mm: -100: no C is left within 0"),
    ("some = [1.0]", MAP + REST, "axis some: expected table.field of a job or one of"),
    ('"stack.thickness_mm" = [1.4]', "[design]\n" + REST, "expected a map, or mpfcad design"),
    ('"stack.override.led_pitch_across_mm" = [4.01]', MAP + REST, "whole number of grooves"),
]


@pytest.mark.parametrize(("axis", "body", "match"), WRONG)
def test_what_is_wrong_is_refused_in_a_line(tmp_path, axis, body, match):
    with pytest.raises(InputError, match=match) as error:
        point(tmp_path, axis, body).plan()
    assert "\n" not in str(error.value)


def test_every_axis_is_one_of_a_departure(tmp_path):
    stack = read_stack("mini-led-4mm")
    for axis in LED_AXES:
        if axis != "fill_fraction":
            assert departure_of(stack, {axis: 1.0}, "w") != departure_of(stack, {}, "w"), axis


@pytest.mark.slow
def test_a_sweep_end_to_end(tmp_path):
    from xarray import open_dataset

    from mpfcad.pipeline.sweep.run import run_sweep

    path = tmp_path / "sweep.toml"
    axis = "crossed_shift_x_mm = [0.0, 1.0]"
    trace = "[trace]\nhalf_width = 0.0\npaths_million = 0.2\n"
    path.write_text(f"{HEAD}[axis]\n{axis}\n{MAP}{trace}{REST}")
    record = run_sweep(read_sweep(path), path, tmp_path / "out", workers=1)
    assert [one["local_shift_mm"] for one in record["points"]] == [0.0, 1.0]
    assert json.loads((tmp_path / "out" / "sweep.json").read_text()) == record
    data = open_dataset(tmp_path / "out" / "sweep.nc", engine="scipy")
    assert data.luminance.dims == (
        "crossed_shift_x_mm", "position_across_period", "position_along_period"
    )  # fmt: skip
    mean = data.luminance.mean(("position_across_period", "position_along_period"))
    assert np.allclose(mean, data.mean_luminance, rtol=0.02)
