"""What is made of a stated tip that the trace doubts, of how far off it may be, and of none."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, StylusTip, StylusTrace, fit_stylus_trace
from mpfcad.film.stylus.dilated import DilatedGroove
from mpfcad.film.stylus.tip import dilate, parse_radius
from mpfcad.units import um

BEF = Groove(0.050, 0.025)


def traced(curvature, radius, told, *, either=False):
    """Return a trace by a ball of a radius [µm], said to be another, or (radius, off)."""
    x = np.arange(0.0, 0.3, 2.5e-4)
    local = (x + 0.007) % BEF.pitch - BEF.half_width
    z = DilatedGroove(BEF, "filled", StylusTip(radius * um)).height(local, curvature) + 0.01 * x
    z += np.random.default_rng(2).normal(0, 2e-5, len(x))
    tip = None
    if told is not None:
        stated, off = told if isinstance(told, tuple) else (told, 0.0)
        tip = StylusTip(stated * um, radius_off=off * um)
    return StylusTrace(x, z, "t.csv", tip, either=either)


def test_a_tip_stated_too_small_is_doubted_and_both_are_held():
    """A covered groove of 30 /mm under 5 µm that are called 2: it read 34.3 [32.5, 37.2]."""
    fit = fit_stylus_trace(traced(30.0, 5.0, 2.0), BEF)
    assert any("rounded by 3 µm beside the stated tip of 2 µm" in note for note in fit.notes)
    assert fit.curvature.low < 30.0 < fit.curvature.high


@pytest.mark.parametrize(("radius", "stated"), [(2.0, 2.0), (2.5, 2.0), (12.5, 12.5)])
def test_a_tip_about_right_is_not(radius, stated):
    fit = fit_stylus_trace(traced(30.0, radius, stated), BEF)
    assert not any("stated tip" in note for note in fit.notes)


def test_what_a_radius_may_be_off_is_in_the_interval():
    exact, off = (
        fit_stylus_trace(traced(58.0, 3.0, told), BEF).curvature for told in (2.5, (2.5, 0.5))
    )
    assert not exact.low <= 58.0 <= exact.high
    assert off.low <= 58.0 <= off.high
    assert off.value == exact.value


def test_a_radius_is_stated_with_how_far_off_it_may_be():
    assert parse_radius("2.5") == (2.5 * um, 0.0)
    assert parse_radius("2.5±0.5") == parse_radius("2.5+-0.5") == (2.5 * um, 0.5 * um)
    for text in ("", "2.5±", "2±3", "-1", "1±0±0", "nan", "two"):
        with pytest.raises(InputError, match="--tip-radius-um"):
            parse_radius(text)


def test_without_a_tip_the_value_is_the_median_of_the_usual_ones():
    """The sharp tip's was taken, which lies highest: 58.9 for 58."""
    fit = fit_stylus_trace(traced(58.0, 0.7, None), BEF)
    assert fit.tip is not None
    assert fit.curvature.value == pytest.approx(58.0, abs=0.1)
    assert fit.curvature.high > 58.5


def test_a_tip_that_is_stated_is_not_asked_for():
    """Bare walls under 5 µm fit upside down as well, as resin of 68 /mm."""
    with pytest.raises(InputError, match="fit alike: expected --upright once"):
        fit_stylus_trace(traced(79.9, 5.0, 5.0, either=True), BEF)


@pytest.mark.parametrize(("curvature", "radius"), [(58.0, 4.0), (66.0, 3.5)])
def test_without_a_tip_one_between_the_usual_ones_is_held(curvature, radius):
    """By 2.5 µm, the largest usual one that fits, it read up to 4 /mm too high."""
    fit = fit_stylus_trace(traced(curvature, radius, None), BEF)
    assert fit.curvature.low <= curvature + 0.3
    assert fit.curvature.value - curvature < 3.0


@pytest.mark.parametrize("seed", [5, 6])
def test_without_a_tip_a_clean_trace_is_told_well(seed):
    """A tip of 2.5 µm, kept since no shape is exact, was made up for by scale: C from 29.7 on."""
    fine = 5e-5
    x = np.arange(-0.02, 0.28, fine)
    z = DilatedGroove(BEF, "filled", StylusTip(2 * um)).height(
        (x + 0.013) % BEF.pitch - BEF.half_width, 40.0
    )[400::5]
    z = z + np.random.default_rng(seed).normal(0, 5e-6, len(z))
    fit = fit_stylus_trace(StylusTrace(x[400::5], z, "t.csv", None), BEF)
    assert fit.curvature.value == pytest.approx(40.0, abs=0.2)
    assert 34.0 < fit.curvature.low < 40.0 < fit.curvature.high < 43.0


@pytest.mark.parametrize("told", [3.5, None])
def test_a_shape_that_is_not_quite_the_models_doubts_no_tip(told):
    """A power of 3.37 under 3.5 µm, noise 5 nm: only tips of 0.7 … 1.4 µm were said to fit."""
    fine, sag = 1e-4, 11.0e-3
    x = np.arange(-0.03, 0.28, fine)
    local = np.abs((x + 0.013) % BEF.pitch - BEF.half_width)
    surface = np.maximum(local, BEF.depth - sag * (1 - (local / BEF.half_width) ** 3.37))
    whole = slice(300, 300 + round(5 * BEF.pitch / fine))
    fill = float(np.mean((surface - local)[whole])) / BEF.room
    z = dilate(surface, fine, StylusTip(3.5 * um), periodic=False)[300:-300:3]
    z += np.random.default_rng(2).normal(0, 5e-6, len(z))
    tip = None if told is None else StylusTip(told * um)
    fit = fit_stylus_trace(StylusTrace(x[300:-300:3], z, "t.csv", tip), BEF)
    assert fit.fill_fraction.low <= fill <= fit.fill_fraction.high
    if told is not None:
        assert not any("tip" in note for note in fit.notes)
