"""The groove's closed forms against the thesis's table, quadrature, and their own inverses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.film import Groove, PrismFilm

BEF = Groove(0.050, 0.025)
#: C through the tips, fill fraction, least-squares curvature, with the digits that are printed.
TABLE = [
    (0, "1.000", "0"),
    (15, "0.750", "15"),
    (30, "0.500", "30"),
    (40, "0.333", "40"),
    (45.13, "0.250", "45.6"),
    (52.38, "0.150", "55.1"),
    (57.04, "0.100", "61.1"),
    (58, "0.0911", "62.2"),
    (60, "0.0741", "64.4"),
    (63.34, "0.050", "67.7"),
    (70, "0.0170", "72.5"),
    (80, "0", "75"),
]
curvatures = st.floats(0, 80)
grooves = st.builds(Groove, st.floats(0.01, 0.1), st.floats(0.005, 0.05))


def digits(text):
    return len(text.partition(".")[2])


@pytest.mark.parametrize(("curvature", "fill", "fitted"), TABLE)
def test_table_holds_to_its_printed_digits(curvature, fill, fitted):
    # Half a unit of the last digit, and 1e-4 relative for the C that is itself rounded.
    for printed, value in (
        (fill, BEF.fill_fraction(curvature)),
        (fitted, BEF.fitted_curvature(curvature)),
    ):
        assert abs(value - float(printed)) <= 0.5 * 10 ** -digits(printed) + 1e-4 * abs(value)


@given(grooves, st.floats(0, 1))
def test_fill_is_the_area_between_surface_and_walls(groove, share):
    curvature = share * groove.curvature_empty
    x = (np.arange(20_000) + 0.5) / 20_000 * groove.half_width
    resin = groove.height(x, curvature) - groove.wall_slope * x
    assert np.mean(resin) * groove.half_width * 2 / groove.area == pytest.approx(
        float(groove.fill_fraction(curvature)), abs=1e-7
    )


@given(st.floats(0, 1))
def test_fill_inverse(fill):
    assert BEF.fill_fraction(BEF.curvature_of_fill(fill)) == pytest.approx(fill, abs=1e-13)


@given(curvatures, st.sampled_from(["filled", "ideal"]))
def test_fitted_curvature_is_what_a_least_squares_fit_finds(curvature, profile):
    x = (np.arange(4001) + 0.5) / 4001 * BEF.half_width
    fit = np.polyfit(x**2, BEF.height(x, curvature, profile), 1)
    assert 2 * fit[0] == pytest.approx(float(BEF.fitted_curvature(curvature, profile)), abs=1e-4)


@given(st.floats(0, 75))
def test_fitted_curvature_inverse(fitted):
    curvature = BEF.curvature_of_fitted(fitted)
    assert BEF.fitted_curvature(curvature) == pytest.approx(fitted, abs=1e-9)


def test_fitted_curvature_out_of_reach_is_refused():
    with pytest.raises(ValueError, match="75"):
        BEF.curvature_of_fitted(75.1)


@given(curvatures, st.floats(0, 0.0249))
def test_slope_is_the_derivative_and_height_is_even(curvature, x):
    step = 1e-7
    kink = abs(x - float(BEF.contact_position(curvature))) < 2 * step or x < 2 * step
    numeric = (BEF.height(x + step, curvature) - BEF.height(x - step, curvature)) / (2 * step)
    assert kink or numeric == pytest.approx(float(BEF.slope(x, curvature)), abs=1e-6)
    assert BEF.height(-x, curvature) == BEF.height(x, curvature)


@given(curvatures, st.sampled_from(["filled", "ideal"]))
def test_surface_passes_through_the_tips(curvature, profile):
    assert BEF.height(BEF.half_width, curvature, profile) == BEF.depth


@given(st.lists(curvatures, min_size=1, max_size=5), st.sampled_from(["filled", "ideal"]))
def test_film_volume_is_the_mean_height(curvature, profile):
    film = PrismFilm(BEF, 0.2, 3.0, profile, np.array(curvature))
    x = (np.arange(film.groove_count * 10_000) + 0.5) / 10_000 * BEF.pitch
    mean = np.mean(film.height(x))
    assert mean * film.width * film.length == pytest.approx(film.volume, rel=1e-7)


def test_cut_keeps_its_place_on_the_panel():
    film = PrismFilm(BEF, 0.2, 3.0, "filled", np.arange(10.0))
    piece = film.cut(2, 3, 1.0).cut(1, 2, 0.5)
    assert piece.curvature.tolist() == [3.0, 4.0]
    assert (piece.origin, piece.length) == (pytest.approx(0.15), 0.5)
