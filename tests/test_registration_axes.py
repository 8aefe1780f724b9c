"""What the axes of registration do to a point of a sweep: where the film lies, how lamps stand."""

import numpy as np
import pytest

import mpfcad.measure
from mpfcad.pipeline.point.trace import Point, trace_point
from mpfcad.pipeline.point.tube import local_shift

STACK = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 12.0\npanel_length_mm = 10.0\n'
    "lamp_count = 3\nlamp_pitch_mm = 4.0\n"
)


@pytest.fixture
def point(tmp_path):
    (tmp_path / "small.toml").write_text(STACK)

    def build(**coordinate):
        job = {
            "name": "axes",
            "map": {"curvature_per_mm": 60.0},
            "stack": {"file": str(tmp_path / "small.toml")},
            "cad": {"length_mm": 0.05, "angle_tolerance_deg": 5.0},
        }
        return Point(coordinate, job, str(tmp_path / "sweep.toml"), 0.0, 10_000)

    return build


class Stop(Exception):
    pass


#: Axis -> its value, and the shift [mm] where it is largest: at the panel's sides (6 mm from its
#: middle), at the lamps' ends (5 mm), at the outer of three lamps.
AXES = {
    "shift_mm": (0.25, 0.25),
    "stretch_percent": (0.5, 0.03),
    "rotation_deg": (0.2, 5 * np.tan(np.radians(0.2))),
    "lamp_pitch_error_mm": (0.1, 0.1),
}


@pytest.mark.parametrize("axis", AXES)
def test_an_axis_moves_the_film_by_its_largest_local_shift(point, monkeypatch, axis):
    value, shift = AXES[axis]
    plan = point().plan()
    for sign in (1, -1):
        assert local_shift(plan, {axis: sign * value}) == pytest.approx(sign * shift, rel=1e-12)
    assert local_shift(plan, {}) == 0
    assert local_shift(plan, {axis: value, "shift_mm": 1.0}) == pytest.approx(
        1.0 if axis == "shift_mm" else 1.0 + shift
    )
    lit = {}

    def light(stack, mesh, offset):
        lit.update(pitch=stack.period.across, offset=offset)
        raise Stop

    monkeypatch.setattr(mpfcad.measure, "light_film", light)
    with pytest.raises(Stop):
        trace_point(point(**{axis: value}))
    assert lit["offset"] == pytest.approx(plan.offset + shift, abs=1e-12)
    error = value if axis == "lamp_pitch_error_mm" else 0.0
    assert lit["pitch"] == pytest.approx(4.0 + error)
