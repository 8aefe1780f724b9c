"""Which pitches of a finite panel are judged: those within the rim."""

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure.judged import judged_pitches
from mpfcad.measure.meter import pitch_positions

STACK = "thesis-32in-mpf"


def judged(**change):
    stack = read_stack(STACK, overrides={"extent": "panel", **change})
    return judged_pitches(stack, pitch_positions(stack))


def test_without_an_end_there_is_no_rim():
    assert judged_pitches(read_stack(STACK), np.linspace(0, 1, 33)) is None


def test_a_tenth_of_the_width_is_not_judged():
    found = judged()
    # Lamps 1 and 12 stand 16.3 mm from the sides: the pitches beside them reach into the rim.
    assert found.rim == pytest.approx(39.226)
    assert (found.first, found.stop, found.count) == (1, 10, 11)
    assert found.place(1) == pytest.approx((49.025, 81.715))
    assert found.words(4) == (
        "worst pitch 5 of 11, 147.1 to 179.8 mm from the left; 2 in the rim of 39.226 mm not judged"
    )


def test_a_rim_of_none_judges_every_pitch():
    found = judged(rim_mm=0.0)
    assert (found.first, found.stop) == (0, 11)
    assert found.words(0).endswith("; all judged")


def test_the_middle_s_pitch_is_judged_whatever_the_default():
    found = judged(lamp_count=2, panel_width_mm=40.0)
    assert (found.first, found.stop) == (0, 1)
    assert found.rim == pytest.approx((40 - 32.69) / 2)


def test_a_rim_that_leaves_no_pitch_is_refused():
    with pytest.raises(InputError, match=r"rim_mm: 190: expected at most 179\.785, so that"):
        judged(rim_mm=190.0)
