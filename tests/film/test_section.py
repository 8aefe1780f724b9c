"""Sections of exact pieces: the plain film in closed form, rounded films by their laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import Groove, Imperfection, PrismFilm, build_section

BEF = Groove(0.050, 0.025)
CURVATURES = st.lists(st.one_of(st.just(0.0), st.floats(0.001, 80.0)), min_size=1, max_size=4)
RADII = st.one_of(st.just(0.0), st.floats(0.0002, 0.006))


def film(curvature, profile="filled"):
    return PrismFilm(BEF, 0.2, 2.0, profile, np.atleast_1d(np.asarray(curvature, float)))


def numeric_area(section):
    x = np.unique(np.concatenate([np.linspace(0, section.width, 20001), section.x]))
    return np.trapezoid(section.height(x) - section.underside, x)


@given(curvature=CURVATURES, profile=st.sampled_from(["filled", "ideal"]))
def test_without_imperfection_it_is_the_plain_film(curvature, profile):
    made = film(curvature, profile)
    section = build_section(made, sliver=0.0)
    assert section.volume == pytest.approx(made.volume, rel=1e-12)
    assert section.thickness == pytest.approx(made.thickness, rel=1e-14)
    x = np.linspace(0, made.width, 1001)[1:-1]
    assert np.abs(section.height(x) - made.height(x)).max() < 1e-14


@given(curvature=CURVATURES, profile=st.sampled_from(["filled", "ideal"]), tip=RADII, valley=RADII)
def test_rounded_films(curvature, profile, tip, valley):
    plain = film(curvature, profile)
    section = build_section(plain, Imperfection(tip, valley))
    x = np.linspace(0, plain.width, 2001)[1:-1]
    off = section.height(x) - plain.height(x)
    # Rounding takes away at the tips only, and adds in the valleys only.
    beside = np.abs((x / BEF.pitch + 0.5) % 1 - 0.5) * BEF.pitch
    assert off[beside > 2.3 * tip + 1e-8].min(initial=0) > -1e-5 * (1 if tip else 1e-6) - 1e-6
    assert off[np.abs(beside - BEF.half_width) > valley + 1e-8].max(initial=0) < 1e-12
    assert section.area == pytest.approx(numeric_area(section), rel=1e-5)
    # One outline: pieces meet, and the film repeats.
    piece = np.arange(section.piece_count)
    assert np.abs(section.height_on(piece, section.x[:-1]) - section.z[:-1]).max() < 1e-12
    assert np.abs(section.height_on(piece, section.x[1:]) - section.z[1:]).max() < 1e-12
    assert section.z[0] == section.z[-1]
    if tip:
        slope = [np.arctan(section.slope_on(piece, at)) for at in (section.x[:-1], section.x[1:])]
        # No convex corner is left but those whose arc would be narrower than 2 x 10 nm.
        assert (slope[0][1:] - slope[1][:-1]).min(initial=0) * tip > -2.1e-5


def test_rounded_straight_prism_in_closed_form():
    """A 90° tip of radius r loses (1 - π/4) r² and (√2 - 1) r; a valley gains the same."""
    bare = film(80.0)
    for radius in (0.001, 0.005):
        tip = build_section(bare, Imperfection(radius))
        lost = (1 - np.pi / 4) * radius**2
        assert bare.volume / bare.length - tip.area == pytest.approx(lost, rel=1e-9)
        assert bare.thickness - tip.thickness == pytest.approx((np.sqrt(2) - 1) * radius, rel=1e-9)
        valley = build_section(bare, Imperfection(0.0, radius))
        assert valley.area - bare.volume / bare.length == pytest.approx(lost, rel=1e-9)


def test_resin_hides_a_rounded_valley():
    plain = film([45.0, 60.0])
    assert build_section(plain, Imperfection(0.0, 0.002)).area == pytest.approx(
        plain.volume / plain.length, rel=1e-12
    )


@given(curvature=CURVATURES, tip=RADII, shrinkage=st.floats(0, 0.05), backing=st.floats(0.1, 10))
def test_negative_and_positive_are_the_block(curvature, tip, shrinkage, backing):
    positive = build_section(film(curvature), Imperfection(tip))
    level = positive.thickness
    negative = positive.turned_over(level, backing).scaled(1 / (1 - shrinkage))
    block = positive.width * positive.length * (level + backing)
    together = positive.volume + negative.volume * (1 - shrinkage) ** 3
    assert together == pytest.approx(block, rel=1e-12)
    again = negative.scaled(1 - shrinkage).turned_over(level, 0.0)
    x = np.linspace(0, positive.width, 501)
    assert np.abs(again.height(x) - positive.height(x)).max() < 1e-12


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (Imperfection(0.1), "tip_radius: 100 µm: larger than groove 0 allows"),
        (Imperfection(0.0, 0.02), "valley_radius: 20 µm: larger than the groove allows"),
        (Imperfection(0.00001), "tip_radius: 0.01 µm: expected 0 or at least 0.2 µm"),
        (Imperfection(float("nan")), "tip_radius: nan"),
    ],
)
def test_radii_that_do_not_fit(made, words):
    with pytest.raises(InputError, match=words):
        build_section(film([60.0, 80.0]), made)


def test_a_surface_through_the_underside_is_refused():
    with pytest.raises(InputError, match="above the underside"):
        build_section(film(900.0, "ideal"))
