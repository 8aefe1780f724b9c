"""The meter's spot and places: whole grooves, whole pitches, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, crossed_mesh, film_file, film_mesh, groove

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import TraceRun, light_film, luminance_over_pitch
from mpfcad.measure.meter import meter_spot, pitch_positions, refuse_dark
from mpfcad.optics.repeat import groove_pitch

STACK = "thesis-32in-mpf"


@pytest.mark.parametrize("grooves", [[BARE] * 20, [groove(60.0)] * 3, [groove(60.0), BARE] * 4])
def test_the_pitch_is_found_in_the_mesh(tmp_path, grooves):
    assert groove_pitch(film_mesh(tmp_path, grooves)) == pytest.approx(0.050, abs=1e-6)


def test_cells_have_a_pitch_too(tmp_path):
    assert groove_pitch(crossed_mesh(tmp_path, lean=0.0, fall=0.0)) == pytest.approx(0.050)


@pytest.mark.parametrize(
    ("asked", "width"), [(1.0, 1.0), (0.98, 1.0), (0.51, 0.5), (0.01, 0.05), (0, 0)]
)
def test_a_spot_is_whole_grooves(tmp_path, asked, width):
    stack = read_stack(STACK, overrides={"meter_spot_mm": asked})
    spot = meter_spot(stack, film_mesh(tmp_path, [BARE] * 2))
    assert spot.width == pytest.approx(width, abs=1e-6)
    assert spot.is_rounded == (abs(asked - width) > 1e-6)


def test_a_rounded_spot_is_said(tmp_path):
    mesh = tmp_path / "film.stl"

    film_file(mesh, [BARE] * 20, base=0.2)
    lit = light_film(read_stack(STACK, overrides={"meter_spot_mm": 0.98}), mesh)
    assert any("0.98: rounded to whole grooves: 1 mm" in note for note in lit.notes)


def test_a_spot_wider_than_the_panel_is_refused():
    stack = read_stack(STACK, overrides={"meter_spot_mm": 400.0})
    with pytest.raises(InputError, match=r"meter_spot_mm: 400: expected at most .* 392\.26 mm"):
        meter_spot(stack, None)


def test_a_finite_panel_is_measured_from_the_first_lamp_to_the_last():
    whole = pitch_positions(read_stack(STACK, overrides={"extent": "panel"}))
    assert (whole[0], whole[-1], len(whole)) == (-5, 6, 353)
    one = pitch_positions(read_stack(STACK, overrides={"extent": "panel", "lamp_count": 1}))
    assert (one[0], one[-1], len(one)) == (0, 1, 33)
    assert len(pitch_positions(read_stack(STACK))) == 33


def test_a_pitch_beyond_the_panel_is_refused():
    change = {"extent": "panel", "lamp_count": 1, "panel_width_mm": 40.0}
    with pytest.raises(InputError, match="expected a whole pitch of 32"):
        pitch_positions(read_stack(STACK, overrides=change))


def test_a_pitch_without_light_is_refused():
    position = np.linspace(-1, 1, 65)
    luminance = np.ones(65)
    luminance[33:] = 0
    refuse_dark("x", position, luminance)  # The pitch's first point still has light.
    luminance[32] = 0
    with pytest.raises(InputError, match="pitch 2 from the left: expected lamps"):
        refuse_dark("x", position, luminance)


def test_a_panel_s_contrast_is_that_of_its_worst_pitch(tmp_path):

    mesh = film_file(tmp_path / "film.stl", [groove(60.0)] * 20, base=0.2)
    change = {"extent": "panel", "lamp_2_luminance_factor": 0.3, "lamp_count": 4}
    stack = read_stack(STACK, overrides=change)
    found = luminance_over_pitch(light_film(stack, mesh), TraceRun(seed=3), half_width_goal=1.0)
    assert len(found.pitches) == 3 and len(found.luminance) == 33
    # The dim lamp's neighbour on the edge sees most of it, or the middle's; never the far pitch.
    assert found.contrast.value == pytest.approx(max(p.value for p in found.pitches), abs=0.03)
    assert found.pitches[2].value < found.contrast.low
    assert replace(found.curve, misfit=2.0).mean().half_width > found.curve.mean().half_width
