"""The eye's threshold for stripes: values worked out by hand from Barten's formula."""

import math

import pytest

from mpfcad.measure import describe_eye, threshold_contrast


@pytest.mark.parametrize(
    ("distance", "threshold"), [(500.0, 0.0053), (1200.0, 0.00243), (2000.0, 0.00171)]
)
def test_stripes_of_a_lamp_pitch(distance, threshold):
    assert threshold_contrast(32.69, distance, 400.0) == pytest.approx(threshold, rel=0.01)


def test_fine_stripes_vanish_and_there_is_a_best_pitch():
    values = [threshold_contrast(pitch, 1000.0, 300.0) for pitch in (0.3, 1, 5, 20, 100)]
    assert values[0] > 0.5
    assert min(values) == values[2]


def test_more_light_shows_less_contrast():
    assert threshold_contrast(5, 1000, 300) < threshold_contrast(5, 1000, 3)


def test_described():
    found = describe_eye(32.69, 1200.0, 8000.0)
    assert found["luminance_at_eye_cd_m2"] == 400.0
    assert math.isclose(found["threshold_contrast"], threshold_contrast(32.69, 1200.0, 400.0))
