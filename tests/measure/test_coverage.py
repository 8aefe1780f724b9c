"""Coverage: 95 % intervals of traced runs hold the truth in 93 to 97 % of many small runs."""

import numpy as np
import pytest
from harness import film_file, groove

from mpfcad.backlight import read_stack
from mpfcad.measure import contrast_of_harmonics, fit_harmonics, light_film
from mpfcad.optics.engine import trace
from mpfcad.optics.recorder import FLOW_ELEMENTS, FLOW_LAMPS, FLOW_UP
from mpfcad.optics.source import EYE, LAMPS, Source

RUNS = 400
#: Of 95 % in a normal distribution.
REACH = 1.96


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    mesh = film_file(tmp_path_factory.mktemp("film") / "film.stl", [groove(60.0)] * 20, base=0.2)
    return light_film(read_stack("thesis-32in-mpf"), mesh)


def runs(lit, kind, points, blocks):
    """Return the tallies of runs with seeds of their own, and their sum."""
    source = Source(kind, points * lit.stack.lamp_pitch, 1.0, acceptance=lit.stack.acceptance)
    found = [trace(lit.scene, source, blocks, seed=1000 + i) for i in range(RUNS)]
    total = found[0]
    for tally in found[1:]:
        total = total + tally
    return found, total


def check(held, slack=2.5):
    """Assert the share of intervals that held the truth; a count of it scatters: 2.5 sigma."""
    held = np.ravel(held)
    share = held.mean()
    print(f"{share:.4f} of {held.size}")
    assert share >= 0.93 - slack * np.sqrt(0.93 * 0.07 / held.size)
    assert share <= 0.97 + slack * np.sqrt(0.97 * 0.03 / held.size)


def luminance_held(found, total):
    # What all runs give together stands for the truth: it is known 20 times better than by one.
    return [np.abs(t.radiance - total.radiance) <= REACH * t.radiance_error for t in found]


def fraction_held(found, total, flow):
    return [
        abs((t.fraction - total.fraction)[flow]) <= REACH * t.fraction_error[flow] for t in found
    ]


def test_intervals_of_a_points_luminance_hold_it(lit):
    found, total = runs(lit, EYE, np.linspace(0, 0.5, 9), 4)
    check(luminance_held(found, total))


def test_intervals_of_the_light_that_comes_out_hold_it(lit):
    found, total = runs(lit, LAMPS, np.zeros(1), 16)
    check(fraction_held(found, total, FLOW_UP))


@pytest.mark.slow
def test_intervals_of_a_point_over_the_whole_pitch_and_of_the_contrast(lit):
    position = np.linspace(0, 1, 33)
    found, total = runs(lit, EYE, position, 2)
    held = np.array(luminance_held(found, total))
    # 13,200 intervals: the share itself is known to 0.2 %.
    assert 0.93 <= held.mean() <= 0.97
    print(f"point: {held.mean():.4f} of {held.size}")
    truth = contrast_of_harmonics(fit_harmonics(position, total.radiance, total.radiance_error))
    intervals = [
        contrast_of_harmonics(fit_harmonics(position, t.radiance, t.radiance_error), i)
        for i, t in enumerate(found)
    ]
    check([found.low <= truth.value <= found.high for found in intervals])


@pytest.mark.slow
@pytest.mark.parametrize("flow", [FLOW_UP, FLOW_LAMPS, FLOW_ELEMENTS])
def test_intervals_of_each_share_of_the_light(lit, flow):
    found, total = runs(lit, LAMPS, np.zeros(1), 20)
    check(fraction_held(found, total, flow))
