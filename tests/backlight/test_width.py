"""Standard uncertainties of a stack's numbers: stated, from a range, or of their kind."""

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.backlight.width import width_of
from mpfcad.errors import InputError

STACK = "thesis-32in-mpf"


def test_numbers_have_the_width_of_their_kind():
    stack = read_stack(STACK)
    sizes = {name: width_of(stack, name).sigma for name in stack.quantity}
    assert sizes["thickness_mm"] == sizes["lamp_height_mm"] == 0.3
    assert sizes["plate_thickness_mm"] == 0.1
    assert sizes["top_sheet_sigma"] == pytest.approx(0.08 * stack["top_sheet_sigma"])
    assert sizes["film_index"] == sizes["reflector_reflectance"] == 0.01
    assert sizes["reflector_specular_fraction"] == 0.1
    for exact in ("lamp_count", "lamp_pitch_mm", "panel_width_mm", "meter_spot_mm"):
        assert sizes[exact] == 0


def test_what_leds_are_has_a_width_and_what_is_not_there_has_none(tmp_path):
    stack = read_stack("led-automotive-6mm")
    sizes = {name: width_of(stack, name).sigma for name in stack.quantity}
    assert sizes["led_half_angle_deg"] == 3.0 and sizes["led_reflectance"] == 0.05
    assert sizes["led_width_mm"] == sizes["led_length_mm"] == sizes["led_height_mm"] == 0.1
    assert sizes["thickness_mm"] == pytest.approx(0.3)
    for exact in (
        "led_hole_radius_mm", "led_cup_height_mm", "led_flux_lm", "led_pitch_across_mm",
        "led_flux_spread", "led_position_error_mm",
    ):  # fmt: skip
        assert sizes[exact] == 0
    file = tmp_path / "cups.toml"
    file.write_text(
        'extends = "led-automotive-6mm"\n[source]\nkind = "leds"\ncup = "square"\n'
        "[value]\nled_cup_height_mm = 3.0\nled_cup_radius_mm = 2.0\nled_hole_radius_mm = 0.5\n"
        "led_peak_angle_deg = 70.0\n"
    )
    stack = read_stack(file)
    sizes = {name: width_of(stack, name).sigma for name in stack.quantity}
    assert sizes["led_cup_height_mm"] == sizes["led_cup_rim_radius_mm"] == 0.1
    assert sizes["led_cup_reflectance"] == 0.01 and sizes["led_hole_reflectance"] == 0.03
    assert sizes["led_hole_radius_mm"] == 0.05 and sizes["led_peak_angle_deg"] == 3.0


def test_a_thin_module_is_known_better_than_a_cavity():
    stack = read_stack("mini-led-4mm")
    sizes = {name: width_of(stack, name).sigma for name in stack.quantity}
    assert sizes["thickness_mm"] == pytest.approx(0.07)
    assert sizes["plate_thickness_mm"] == pytest.approx(0.05)
    assert sizes["led_width_mm"] == sizes["led_height_mm"] == pytest.approx(0.02)


def test_a_plate_with_its_own_thickness_is_no_cavity(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(
        'extends = "thesis-32in-mpf"\n'
        'layers = [{kind = "plate", name = "lid", thickness_mm = 2.0}, "film"]\n'
    )
    assert width_of(read_stack(file), "lid.thickness_mm").sigma == 0.1


def test_a_stated_width_and_a_range_stand_above_it():
    change = {
        "film_index": {"value": 1.55, "sigma": 0.002},
        "thickness_mm": {"value": 20.0, "range": [19.0, 21.0]},
        "lamp_height_mm": {"value": 3.5, "sigma": 0},
    }
    stack = read_stack(STACK, overrides=change)
    assert width_of(stack, "film_index") == (0.002, "stated")
    assert width_of(stack, "thickness_mm").sigma == pytest.approx(2 / np.sqrt(12))
    assert width_of(stack, "lamp_height_mm").sigma == 0


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ({"value": 20, "sigma": -1}, "sigma: -1: expected a number of 0 or more"),
        ({"value": 20, "sigma": "x"}, "sigma: 'x': expected a number"),
        ({"value": 20, "range": [21, 22]}, "expected to hold the value 20"),
        ({"value": 20, "range": 3}, r"range: 3: expected \[lowest, highest\]"),
        ({"value": 20, "range": [19, 21], "sigma": 1}, "sigma and range: expected one"),
        ({"value": 20, "sigma": 1e300}, "sigma: 1e\\+300: expected at most 999.9"),
        (
            {"value": 20, "range": [0.05, 30]},
            r"range: \[0.05, 30\]: expected to lie within 0.1 … 1000",
        ),
        ({"value": 20, "range": [10, 2000]}, "expected to lie within 0.1 … 1000"),
        ({"value": 20, "width": 1}, "expected keys: range, sigma, source, tag, value"),
    ],
)
def test_a_wrong_width_is_refused(entry, says):
    with pytest.raises(InputError, match=says) as error:
        read_stack(STACK, overrides={"thickness_mm": entry})
    assert "thickness_mm" in str(error.value)


def test_a_sheets_own_sigma_is_a_value_and_may_have_a_width(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(
        'extends = "thesis-32in-mpf"\n'
        'layers = ["clear_plate", {kind = "sheet", name = "under", sigma = 0.3}, "film"]\n'
        "[value.under]\nindex = {value = 1.5, sigma = 0.002}\n"
    )
    stack = read_stack(file)
    assert stack["under.sigma"] == 0.3
    assert width_of(stack, "under.sigma").sigma == pytest.approx(0.08 * 0.3)
    assert width_of(stack, "under.index").sigma == 0.002
