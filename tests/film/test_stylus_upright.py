"""Which way up a trace lies, and whether it shows grooves: by the likelihood of both readings."""

from dataclasses import replace

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, ReadingOption, StylusTip, fit_stylus_trace, read_stylus_trace
from mpfcad.film.stylus.tip import dilate

BEF = Groove(0.050, 0.025)
FINE = 5e-5


def traced(curvature, radius=0.0, grooves=8, step=5e-4, angle=60.0, gain=1.0, wave=0.0, noise=3e-5):
    """Return positions and heights [mm] of grooves under a tip, tilted, with waviness."""
    x = np.arange(-0.05, (grooves + 0.3) * BEF.pitch + 0.05, FINE)
    z = BEF.height((x + 0.013) % BEF.pitch - BEF.half_width, curvature)
    if radius:
        z = dilate(z, FINE, StylusTip(radius, np.radians(angle)), periodic=False)
    kept = slice(round(0.05 / FINE), -round(0.05 / FINE), round(step / FINE))
    x, z = x[kept], z[kept] + 0.01 * x[kept] + wave * np.sin(2 * np.pi * x[kept] / 0.31 + 1)
    return x, gain * z + np.random.default_rng(8).normal(0, noise, len(x))


def read(tmp_path, x, z, **option):
    table = np.stack([x, z], 1) * 1e3
    np.savetxt(tmp_path / "t.csv", table, "%.5f", ",", header="x_um,z_um", comments="")
    return read_stylus_trace(tmp_path / "t.csv", BEF, option=ReadingOption(**option))


def fitted(tmp_path, x, z, **option):
    trace = read(tmp_path, x, z, **option)
    return fit_stylus_trace(trace, BEF, correct=option.get("correct", False))


def refused(tmp_path, x, z, **option):
    with pytest.raises(InputError) as error:
        fitted(tmp_path, x, z, **option)
    words = str(error.value)
    assert "expected" in words and "\n" not in words
    return words


@pytest.mark.slow
@pytest.mark.parametrize("correct", [False, True])
def test_gain_and_waviness_turn_nothing(tmp_path, correct):
    """By the shape of its valleys alone this trace was called upside down, and read as 66.96."""
    x, z = traced(56.53, 5e-3, 12, 1e-3, gain=0.959, wave=0.5e-3)
    found = fitted(tmp_path, x, z, tip=StylusTip(5e-3), correct=correct).curvature
    assert found.low <= 56.53 <= found.high
    assert found.high - found.low < 8


@pytest.mark.parametrize("told", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_blunt_tip_over_bare_walls_is_upside_down_when_it_is(tmp_path, told):
    """The ball's arcs over the prism tips, turned over, look like resin of C = 61 /mm."""
    x, z = traced(74.0, 12.5e-3, 4, gain=-1.0)
    words = refused(tmp_path, x, z, tip=StylusTip(12.5e-3) if told else None)
    assert "upside down" in words
    if told:
        found = fitted(tmp_path, x, z, tip=StylusTip(12.5e-3), correct=True).curvature
        assert found.low <= 74.0 <= found.high


@pytest.mark.parametrize(
    ("curvature", "grooves"),
    [(8.3, 3), *(pytest.param(*each, marks=pytest.mark.slow) for each in ((25.3, 6), (2.5, 8)))],
)
def test_covered_grooves_under_a_blunt_tip_are_no_other_unit(tmp_path, curvature, grooves):
    x, z = traced(curvature, 12.5e-3, grooves, angle=90.0)
    tip = StylusTip(12.5e-3, np.radians(90.0))
    found = fitted(tmp_path, x, z, tip=tip).curvature
    assert found.low <= curvature <= found.high


def test_heights_a_little_above_bare_are_told_from_a_tenth(tmp_path):
    x, z = traced(46.0, grooves=4, step=1e-3)
    assert "z is 0.1 times its size" in refused(tmp_path, x, z / 10)


def shape(name, phase):
    """Return heights -1 … 1 of what is no groove over the phase, 0 … 1."""
    turn = phase % 1
    return {
        "sine": np.sin(2 * np.pi * turn),
        "saw": 2 * turn - 1,
        "square": np.where(turn < 0.5, 1.0, -1.0),
        "trapezoid": np.clip(2 * (4 * np.abs(turn - 0.5) - 1), -1, 1),
        "skew": np.where(turn < 0.3, turn / 0.3, (1 - turn) / 0.7) * 2 - 1,
        "flat bottoms": 2 * np.maximum(np.abs(2 * turn - 1) - 0.4, 0) / 0.6 - 1,
        "shallow prisms": 4 * np.abs(turn - 0.5) - 1,
        "long trapezoid": np.clip(3 * (4 * np.abs(turn - 0.5) - 1), -1, 1),
    }[name]


SLOW = [
    pytest.param(n, marks=pytest.mark.slow)
    for n in ("saw", "trapezoid", "flat bottoms", "shallow prisms")
]


@pytest.mark.parametrize("name", ["sine", *SLOW])
def test_what_repeats_and_is_no_groove_is_refused(tmp_path, name):
    x = np.arange(0.0, 0.21, 1e-3)
    z = 0.010 * shape(name, x / BEF.pitch + 0.2) + 0.01 * x
    z += np.random.default_rng(4).normal(0, 3e-5, len(x))
    words = refused(tmp_path, x, z, correct=True)
    assert "relief" in words or "upside down" in words or "of their size" in words


OTHERS = [("square", -1.0), *(("trapezoid", s) for s in (1, -1)), ("long trapezoid", 1.0)]


@pytest.mark.parametrize(
    ("name", "sign"),
    [("square", 1.0), *(pytest.param(*each, marks=pytest.mark.slow) for each in OTHERS)],
)
def test_what_fits_neither_way_is_not_called_upside_down(tmp_path, name, sign):
    """A square wave was: of its two bad readings one is always less bad than noise allows."""
    x = np.arange(0.0, 0.11, 1e-3)
    z = sign * 0.010 * shape(name, x / BEF.pitch + 0.2)
    z += np.random.default_rng(4).normal(0, 3e-5, len(x))
    words = refused(tmp_path, x, z)
    assert "upside down:" not in words
    assert "shows no grooves" in words
    assert "tips up, C = " in words


def arcs(sag, radius=0.0, grooves=4):
    """Return a trace of circular menisci through the tips, of a sag [mm], and their mean fill."""
    x = np.arange(-0.05, (grooves + 0.3) * BEF.pitch + 0.05, FINE)
    local = (x + 0.013) % BEF.pitch - BEF.half_width
    size = (BEF.half_width**2 + sag**2) / (2 * sag)
    bare = BEF.depth - BEF.half_width + np.abs(local)
    z = np.maximum(bare, BEF.depth - sag + size - np.sqrt(size**2 - local**2))
    whole = slice(round(grooves * BEF.pitch / FINE))
    fill = float(np.mean((z - bare)[whole])) / (BEF.depth / 2)
    if radius:
        z = dilate(z, FINE, StylusTip(radius), periodic=False)
    kept = slice(1000, -1000, 10)
    return x[kept], z[kept] + np.random.default_rng(8).normal(0, 3e-5, len(x[kept])), fill


@pytest.mark.slow
@pytest.mark.parametrize("sag", [9.4e-3, 11.25e-3, 12.5e-3, 14.1e-3])
def test_a_circular_meniscus_is_a_groove(tmp_path, sag):
    """By a parabola it left 3 … 5 % of the relief, and its fill was not held."""
    x, z, fill = arcs(sag, 2e-3)
    found = fitted(tmp_path, x, z, tip=StylusTip(2e-3))
    assert not any("are these such grooves?" in note for note in found.notes)
    # A deviation of noise more than 95 %.
    half = (found.fill_fraction.high - found.fill_fraction.low) / 4
    assert found.fill_fraction.low - half <= fill <= found.fill_fraction.high + half


@pytest.mark.parametrize("height", [25e-3, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_a_single_step_is_refused(tmp_path, height):
    """It was C = 1.58 [0, 10.4] /mm."""
    x = np.arange(0.0, 0.21, 1e-3)
    z = np.where(x < 0.1, 0.0, height) + np.random.default_rng(4).normal(0, 3e-5, len(x))
    refused(tmp_path, x, z, tip=StylusTip(0.0))


@pytest.mark.slow
def test_grooves_of_which_half_are_covered_flat_are_refused(tmp_path):
    x, z = traced(56.0, grooves=6, step=1e-3)
    refused(tmp_path, x, np.where(x < 0.15, z, z[x < 0.15].max()))


def test_prisms_without_resin_are_empty_either_way(tmp_path):
    x, z = traced(80.0, grooves=4)
    fit = fitted(tmp_path, x, z, tip=StylusTip(0.0))
    assert fit.fill_fraction.value < 1e-3
    assert any("upside down the trace would fit as well" in note for note in fit.notes)


@pytest.mark.slow
def test_two_readings_that_contradict_each_other_are_both_named(tmp_path):
    """Bare walls under 5 µm, or, turned over, resin of C = 68 /mm under a sharp tip."""
    x, z = traced(80.0, 5e-3, 4, 1e-3)
    trace = read(tmp_path, x, z, upright=True)
    assert not trace.either
    assert fit_stylus_trace(trace, BEF).curvature.high >= 79.5
    with pytest.raises(InputError) as error:
        fit_stylus_trace(replace(trace, either=True), BEF)
    words = str(error.value)
    assert "tips up, C = " in words and "upside down, C = " in words and "--upright" in words


def test_a_trace_steeper_than_its_cone_is_said(tmp_path):
    x, z = traced(60.0, 5e-3, 4, angle=90.0, gain=1.03)
    fit = fitted(tmp_path, x, z, tip=StylusTip(5e-3, np.radians(90.0)))
    assert "steeper than the tip's cone of 90° can draw" in fit.notes[0]
    assert fit.curvature.low <= 60.0 <= fit.curvature.high
