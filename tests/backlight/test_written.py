"""A stack written as a file of its own reads as the same stack."""

import pytest
import tomli_w

from mpfcad.backlight import read_stack
from mpfcad.backlight.written import stack_tables
from mpfcad.errors import InputError


@pytest.mark.parametrize("preset", ["thesis-32in-mpf", "thesis-32in-mpf-plate"])
def test_it_reads_as_the_same_stack(tmp_path, preset):
    change = {"top_sheet_sigma": {"value": 0.3, "sigma": 0.01, "source": "fit"}}
    stack = read_stack(preset, thickness=16.0, overrides=change)
    path = tmp_path / "own.toml"
    path.write_text(tomli_w.dumps(stack_tables(stack)), "utf-8")
    again = read_stack(path)
    assert again.quantity == stack.quantity and again.layers == stack.layers


def test_leds_and_own_layers_are_refused():
    with pytest.raises(InputError, match="LEDs: expected a backlight of named layers over tubes"):
        stack_tables(read_stack("led-tv-20mm"))
