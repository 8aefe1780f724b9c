"""The stylus's tip undone: closed form against morphology, and intervals against known truth."""

import re

import numpy as np
import pytest
from simulated_trace import simulate

from mpfcad.errors import InputError
from mpfcad.film import Groove, StylusTip, StylusTrace, average_groove, fit_stylus_trace
from mpfcad.film.stylus.dilated import DilatedGroove
from mpfcad.film.stylus.tip import dilate, erode
from mpfcad.units import deg

BEF = Groove(0.050, 0.025)
COUNT = 8000
FINE = (np.arange(COUNT) + 0.5) / COUNT * BEF.pitch - BEF.half_width
STEP = BEF.pitch / COUNT


@pytest.mark.parametrize("angle", [60, 90])
@pytest.mark.parametrize("radius", [0.7e-3, 2e-3, 12.5e-3])
@pytest.mark.parametrize("curvature", [10.0, 45.0, 60.0, 79.9])
def test_closed_form_is_the_dilation(curvature, radius, angle):
    tip = StylusTip(radius, angle * deg)
    traced = dilate(BEF.height(FINE, curvature), STEP, tip, periodic=True)
    closed = DilatedGroove(BEF, "filled", tip).height(FINE, curvature)
    # The sampled surface's prism tip is half a step lower at most.
    assert np.abs(traced - closed).max() < STEP


def test_a_parabola_sharper_than_the_ball_too():
    tip = StylusTip(12.5e-3)
    traced = dilate(BEF.height(FINE, 150.0, "ideal"), STEP, tip, periodic=True)
    closed = DilatedGroove(BEF, "ideal", tip).height(FINE, 150.0)
    assert np.abs(traced - closed).max() < 2 * STEP


def test_erosion_is_the_surface_where_the_tip_touched():
    """It never lies below the surface, dilates to the same trace again, and touches at the tips."""
    tip = StylusTip(5e-3)
    surface = BEF.height(FINE, 60.0)
    traced = dilate(surface, STEP, tip, periodic=True)
    back = erode(traced, STEP, tip, periodic=True)
    assert np.all(back >= surface - 1e-12)
    assert dilate(back, STEP, tip, periodic=True) == pytest.approx(traced, abs=1e-12)
    assert np.mean(back - surface < 1e-6) > 0.5
    assert back[0] == pytest.approx(surface[0], abs=1e-12)


def traced(curvature, tip, groove=BEF, *, gain=1.0, noise=0.0, seed=1):
    """Return a noise-free trace of a groove; `gain` multiplies the heights."""
    x = np.arange(0.0, 0.3, 2.5e-4)
    local = (x + 0.007) % groove.pitch - groove.half_width
    z = DilatedGroove(groove, "filled", tip).height(local, curvature) * gain + 0.01 * x
    z += np.random.default_rng(seed).normal(0, noise, len(x)) if noise else 0.0
    return StylusTrace(x, z, "t.csv", tip)


@pytest.mark.parametrize("radius", [2e-3, 5e-3, 12.5e-3])
def test_a_stated_tip_is_undone(radius):
    fit = fit_stylus_trace(traced(58.0, StylusTip(radius)), BEF)
    # A ball of 12.5 µm sees little of the meniscus: the priors of its shape move C by so much.
    assert fit.curvature.value == pytest.approx(58.0, abs=2e-3)
    assert fit.fill_fraction.value == pytest.approx(float(BEF.fill_fraction(58.0)), abs=2e-5)
    assert fit.tip == StylusTip(radius)


def test_an_unknown_tip_widens_and_is_said():
    trace = traced(38.0, StylusTip(2e-3), noise=5e-5)
    unknown = StylusTrace(trace.position, trace.height, "t.csv")
    told, fit = fit_stylus_trace(trace, BEF), fit_stylus_trace(unknown, BEF)
    assert "tip not stated" in fit.notes[0]
    assert not any("tip" in note for note in told.notes)
    assert fit.curvature.low <= 38.0 <= fit.curvature.high
    assert told.curvature.low <= 38.0 <= told.curvature.high
    assert fit.curvature.high - fit.curvature.low >= told.curvature.high - told.curvature.low


def test_a_tip_that_did_not_trace_it_is_found():
    trace = traced(60.0, None)
    wrong = StylusTrace(trace.position, trace.height, "t.csv", StylusTip(2.5e-3))
    fit = fit_stylus_trace(wrong, BEF)
    # A shape is the model's to 15 nm at best, which a ball of 1 µm does not leave of a free trace.
    assert re.search(r"; tips from sharp to [01]\.", fit.notes[0])
    assert "sharper than its tip of 2.5 µm" in fit.notes[0]
    assert fit.curvature.low <= 60.0 + 1e-6
    assert fit.curvature.high >= 60.0 - 1e-6


def test_a_ball_that_does_not_reach_the_resin_says_so():
    """12.5 µm rest on both walls 5.2 µm above the valley: above C = 63 /mm nothing is seen."""
    fit = fit_stylus_trace(traced(72.0, StylusTip(12.5e-3), noise=2e-5), BEF)
    assert fit.curvature.low < 64.5
    assert fit.curvature.high > 79.5


def test_a_gain_of_three_percent_is_named_and_both_readings_held():
    fit = fit_stylus_trace(traced(60.0, StylusTip(2e-3), gain=1.03, noise=2e-5), BEF)
    assert any("walls are +3.0% off" in note for note in fit.notes)
    # Were the film so, its dilated parabola, 60/(1 - 0.12) times 1.03, would be one of 61.6.
    assert fit.curvature.low <= 60.0 <= fit.curvature.high
    assert fit.curvature.low <= 61.5 <= fit.curvature.high
    right = fit_stylus_trace(
        traced(60.0, StylusTip(2e-3), gain=1.03, noise=2e-5), BEF, correct=True
    )
    # The dilation was multiplied too: a little of that is left.
    assert right.curvature.value == pytest.approx(60.0, abs=0.4)


def test_a_film_of_another_pitch_is_named():
    other = Groove(0.051, 0.0255)
    fit = fit_stylus_trace(traced(55.0, StylusTip(0.0), other), BEF)
    assert any("positions read +2.0%" in note for note in fit.notes)
    assert fit.curvature.value == pytest.approx(55.0, abs=0.01)
    assert fit.pitch == pytest.approx(0.051, abs=1e-6)


def test_a_gain_of_ten_percent_is_refused():
    with pytest.raises(InputError, match=r"walls are \+10.0% off .* --correct"):
        fit_stylus_trace(traced(60.0, None, gain=1.1), BEF)


def test_the_measured_groove_is_without_the_tip():
    """Made of a trace by 5 µm: the groove itself to 20 nm, where the trace is 2 µm off."""
    found = average_groove(traced(60.0, StylusTip(5e-3)), BEF, "filled")
    truth = BEF.height(found[:, 0], 60.0)
    assert np.abs(found[:, 1] - truth - (found[:, 1] - truth).mean()).max() < 2e-4


@pytest.mark.parametrize("gain", [1.03, 0.97])
def test_a_measured_groove_with_heights_off_scale_is_refused(gain):
    with pytest.raises(InputError, match=r"walls are .3\.\d% off .* film\.depth_um"):
        average_groove(traced(58.0, StylusTip(2e-3), gain=gain, noise=2e-5), BEF, "filled")


@pytest.mark.parametrize("curvature", [66.0, 80.0])
def test_resin_that_a_blunt_tip_does_not_reach_may_be_none(curvature):
    """A ball of 12.5 µm draws the same arc over all of these grooves."""
    fit = fit_stylus_trace(traced(curvature, StylusTip(12.5e-3), noise=2e-5), BEF)
    assert fit.fill_fraction.low < 1e-6
    assert fit.curvature.low < 66.0 and fit.curvature.high > 79.9


def test_dirt_in_one_groove_does_not_tell_that_the_others_hold_resin():
    """With a fill of its own for the dirty groove it was 70.6 [70.2, 70.9] for 72.9."""
    trace = traced(72.9, StylusTip(7e-3), noise=1e-4)
    trace.height[:] += 3e-4 * np.exp(-(((trace.position - 0.118) / 4e-3) ** 2))
    fit = fit_stylus_trace(trace, BEF)
    assert fit.curvature.low <= 72.9 <= fit.curvature.high
    assert fit.fill_fraction.low < 1e-3


def test_little_resin_that_the_tip_reaches_is_not_none():
    fit = fit_stylus_trace(traced(66.0, StylusTip(2e-3), noise=2e-5), BEF)
    assert fit.curvature.low < 66.0 < fit.curvature.high < 70.0


def test_a_blunt_cone_hides_steeper_walls():
    """Walls 3 % steeper than a 90° cone: the trace shows the cone; the fill's interval knows."""
    steep = Groove(0.05, 0.0258)
    tip = StylusTip(2e-3, np.radians(90))
    fit = fit_stylus_trace(traced(60.0, tip, steep, noise=2e-5), BEF)
    truth = float(steep.fill_fraction(60.0))
    assert fit.fill_fraction.value < truth < fit.fill_fraction.high
    assert any("cone may hide how steep" in note for note in fit.notes)
    sharp = fit_stylus_trace(traced(60.0, StylusTip(2e-3), steep, noise=2e-5), BEF)
    assert not any("cone" in note for note in sharp.notes)
    assert sharp.fill_fraction.value == pytest.approx(truth, abs=0.002)


def covered(seeds, **fault):
    """Return how often the intervals of C and of the fill hold the truth."""
    held = np.zeros(2)
    for seed in seeds:
        known = simulate(seed, **fault)
        fit = fit_stylus_trace(known.trace, BEF)
        c, fill = fit.curvature, fit.fill_fraction
        held += [c.low <= known.curvature <= c.high, fill.low <= known.fill <= fill.high]
    return held


def test_intervals_hold_the_truth_with_all_faults():
    """6 traces: each should hold with 95 %, so fewer than 4 has a chance of 2e-3."""
    assert np.all(covered(range(6)) >= 4)


@pytest.mark.slow
@pytest.mark.parametrize("marks", [0.0, 0.04])
def test_intervals_hold_the_truth_as_often_as_they_say(marks):
    """200 traces, 190 ± 3.1: within four standard deviations below.

    Not above: where pitch or depth are off, intervals hold the film's scale and the instrument's.
    """
    held = covered(range(1000, 1200), marks=marks)
    print(held)
    assert np.all(held >= 178)
