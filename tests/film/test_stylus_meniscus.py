"""Menisci of any shape: dilated in closed form, fitted, and their fill held."""

import numpy as np
import pytest

from mpfcad.film import Groove, StylusTip, StylusTrace, fit_stylus_trace
from mpfcad.film.meniscus import segment_share
from mpfcad.film.stylus.dilated import DilatedGroove
from mpfcad.film.stylus.meniscus import Meniscus
from mpfcad.film.stylus.tip import dilate
from mpfcad.units import deg

BEF = Groove(0.050, 0.025)
COUNT = 8000
FINE = (np.arange(COUNT) + 0.5) / COUNT * BEF.pitch - BEF.half_width
STEP = BEF.pitch / COUNT


def surface(meniscus):
    """Return the groove's surface at `FINE`, bare above the contact."""
    contact, level, slope = (
        float(part[0]) for part in (meniscus.contact, meniscus.level, meniscus.slope)
    )
    x, k, q = np.clip(FINE, -contact, contact), meniscus.roundness, meniscus.flatness
    size = contact * np.hypot(1, slope) / slope
    resin = level - k * (np.sqrt(size**2 - x**2) - np.sqrt(size**2 - contact**2))
    resin -= slope * contact * (1 - k - q) / 2 * (1 - (x / contact) ** 2)
    resin -= slope * contact * q / 4 * (1 - (x / contact) ** 4)
    return np.where(np.abs(FINE) <= contact, resin, BEF.wall_slope * np.abs(FINE))


@pytest.mark.parametrize(
    ("roundness", "flatness"), [(-0.3, 0.0), (0.0, 0.0), (0.5, 0.2), (1.0, 0.0), (0.0, 0.9)]
)
@pytest.mark.parametrize("above", [-0.6, 0.0, 0.4])
@pytest.mark.parametrize("u", [0.3, 1.0, 1.3, 1.7])
def test_every_meniscus_holds_its_fill_and_is_dilated_in_closed_form(u, above, roundness, flatness):
    meniscus = Meniscus.holding(BEF, np.array([u]), above, roundness, flatness)
    z = surface(meniscus)
    fill = float(np.mean(z - np.abs(FINE))) / BEF.room
    assert fill == pytest.approx(float(BEF.fill_fraction(u * BEF.curvature_covered)), abs=2e-6)
    for tip in (StylusTip(2e-3), StylusTip(12.5e-3, 90 * deg)):
        closed = DilatedGroove(BEF, "filled", tip).over(FINE, meniscus)
        assert np.abs(dilate(z, STEP, tip, periodic=True) - closed).max() < STEP


def test_with_no_wetting_more_or_less_it_is_the_parabola_through_the_tips():
    u = np.array([0.2, 0.9, 1.0, 1.1, 1.6, 1.9])
    one = Meniscus.holding(BEF, u, 0.0, 0.0)
    other = Meniscus.through_tips(BEF, u * BEF.curvature_covered, "filled")
    for name in ("contact", "level", "slope"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-9)


def arc(fill, angle):
    """Return a circular arc's half width of contact [mm] and its slope angle there [rad]."""
    beta = np.arctan(BEF.wall_slope) - angle
    contact = BEF.half_width * np.sqrt(fill / (1 - segment_share(np.array(beta))))
    return float(contact), float(beta)


def traced(fill, angle, tip, seed=8):
    """Return a trace of arcs at rest that meet the walls at an angle [rad]."""
    contact, beta = arc(fill, angle)
    size = contact / np.sin(beta)
    fine = 5e-5
    x = np.arange(-0.05, 0.46, fine)
    local = np.abs((x + 0.013) % BEF.pitch - BEF.half_width)
    inside = np.minimum(local, contact)
    z = contact - np.sqrt(size**2 - inside**2) + np.sqrt(size**2 - contact**2)
    z = dilate(np.where(local <= contact, z, local), fine, tip, periodic=False)
    kept = slice(1000, -1000, 10)
    noise = np.random.default_rng(seed).normal(0, 3e-5, len(x[kept]))
    return StylusTrace(x[kept], z[kept] + 0.01 * x[kept] + noise, "t.csv", tip)


@pytest.mark.parametrize(("curvature", "angle"), [(60.0, 20.0), (47.0, 0.0), (64.0, 0.0)])
def test_arcs_below_the_tips_are_read_with_their_fill(curvature, angle):
    """By a parabola through the tips they read 62.8, 49 with a fill of 0.18 for 0.22, and over."""
    fill = float(BEF.fill_fraction(curvature))
    found = fit_stylus_trace(traced(fill, angle * deg, StylusTip(2e-3)), BEF)
    # A deviation or two of noise either way.
    assert found.curvature.value == pytest.approx(curvature, abs=0.1)
    assert found.fill_fraction.low - 2e-4 <= fill <= found.fill_fraction.high + 2e-4
    assert found.fill_fraction.high - found.fill_fraction.low < 0.02
    shape = found.meniscus
    assert not shape.through_tips
    below = BEF.half_width - arc(fill, angle * deg)[0]
    assert shape.below_tips.low - 1e-4 <= below <= shape.below_tips.high + 1e-4
    assert shape.wall_angle.low - 1 * deg <= angle * deg <= shape.wall_angle.high + 1 * deg
    assert "a parabola through the tips does not fit" in shape.words


@pytest.mark.parametrize(("sag", "power"), [(8e-3, 4), (10e-3, 3), (15e-3, 4)])
def test_a_meniscus_that_dried_flat_is_read_with_its_fill(sag, power):
    """A fourth power read a fill of 0.456 [0.431, 0.477] for 0.490."""
    fine = 5e-5
    x = np.arange(-0.05, 0.46, fine)
    local = np.abs((x + 0.013) % BEF.pitch - BEF.half_width)
    z = np.maximum(local, BEF.depth - sag * (1 - (local / BEF.half_width) ** power))
    whole = slice(1000, 1000 + round(8 * BEF.pitch / fine))
    fill = float(np.mean((z - local)[whole])) / BEF.room
    z = dilate(z, fine, StylusTip(2e-3), periodic=False)
    kept = slice(1000, -1000, 10)
    noise = np.random.default_rng(8).normal(0, 3e-5, len(x[kept]))
    found = fit_stylus_trace(StylusTrace(x[kept], z[kept] + noise, "t.csv", StylusTip(2e-3)), BEF)
    half = (found.fill_fraction.high - found.fill_fraction.low) / 4
    assert found.fill_fraction.low - half <= fill <= found.fill_fraction.high + half
    assert found.fill_fraction.high - found.fill_fraction.low < 0.03
    if power == 4:
        assert found.meniscus.flatness.value == pytest.approx(1.0, abs=0.1)


def test_a_fit_does_not_stay_at_level_resin():
    """An ellipse under 12.5 µm read 58.99 ± 0.03 for 58, as level resin: 150 of χ² worse."""
    fine, tip, part = 2e-5, StylusTip(12.5e-3), 0.97
    x = np.arange(-0.02, 0.233, fine)
    local = np.abs((x + 0.031) % BEF.pitch - BEF.half_width)
    depth = 1 - np.sqrt(1 - part**2)
    rise = (1 - np.sqrt(1 - (part * local / BEF.half_width) ** 2)) / depth
    z = np.maximum(local, BEF.depth - 17.834e-3 * (1 - rise))
    fill = float(np.mean((z - local)[: round(5 * BEF.pitch / fine)])) / BEF.room
    z = dilate(z, fine, tip, periodic=False)[round(0.02 / fine) : round(0.233 / fine) : 12]
    x = 2.4e-4 * np.arange(len(z))
    z += np.random.default_rng(1).normal(0, 3e-5, len(z)) + 0.01 * x
    found = fit_stylus_trace(StylusTrace(x, z, "t.csv", tip), BEF)
    assert found.fill_fraction.low <= fill <= found.fill_fraction.high
    assert found.fill_fraction.value == pytest.approx(fill, rel=0.03)
