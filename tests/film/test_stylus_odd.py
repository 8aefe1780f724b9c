"""Grooves that are not of the others' kind: left out and said, or refused."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, StylusTip, StylusTrace, fit_stylus_trace
from mpfcad.film.stylus.misfit import GrooveNumbers
from mpfcad.film.stylus.tip import dilate

BEF = Groove(0.050, 0.025)
TIP = StylusTip(2e-3)
FINE = 1e-4


def traced(curvature, change=lambda x, z: z, grooves=7):
    """Return a trace of grooves of a curvature [1/mm] each, (grooves + 2,), then changed."""
    x = np.arange(0.0, (grooves + 2) * BEF.pitch, FINE)
    number = (x / BEF.pitch).astype(int)
    each = np.broadcast_to(curvature, grooves + 2)
    z = BEF.height(x - (number + 0.5) * BEF.pitch, each[number])
    z = dilate(change(x, z), FINE, TIP, periodic=False)
    kept = slice(round(0.04 / FINE), -round(0.04 / FINE), 4)
    noise = np.random.default_rng(3).normal(0, 3e-5, len(x[kept]))
    return StylusTrace(x[kept], z[kept] + noise, "t.csv", TIP)


def without_prism(height):
    """Return what takes the prism at 0.25 mm down to a height [mm] above the valleys."""
    return lambda x, z: np.where(np.abs(x - 0.25) < 0.025, np.minimum(z, height), z)


def dirt(x, z):
    return z + 3e-3 * np.exp(-(((x - 0.17) / 8e-3) ** 2))


@pytest.mark.parametrize("change", [without_prism(13e-3), without_prism(7e-3), dirt])
def test_a_damaged_groove_is_left_out_and_said(change):
    """They were read with an interval as wide as [39, 61] /mm, and nothing was said."""
    fit = fit_stylus_trace(traced(58.0, change), BEF)
    (words,) = [note for note in fit.notes if "left out" in note]
    assert "µm off on average" in words
    assert fit.curvature.value == pytest.approx(58.0, abs=0.1)
    assert fit.curvature.high - fit.curvature.low < 0.3
    assert fit.fill_fraction.value == pytest.approx(float(BEF.fill_fraction(58.0)), abs=1e-3)


def test_grooves_have_one_number_in_every_message_and_a_list_where_they_are_apart():
    """Those left out had the number of the lattice, the farthest one that of those whole."""

    def twice(x, z):
        return z + sum(3e-3 * np.exp(-(((x - at) / 8e-3) ** 2)) for at in (0.07, 0.27))

    # The file begins at 40 µm: a fifth of the groove that ends at 50 µm is its first.
    each = np.full(9, 52.0)
    each[6] = 66.0
    words = " / ".join(fit_stylus_trace(traced(each, twice), BEF).notes)
    assert "grooves 2 and 6 of 9 (x 50 … 100 and 250 … 300 µm) left out" in words
    assert "groove 7 of 9 (x 300 … 350 µm) is farthest from the mean" in words


@pytest.mark.parametrize(
    ("number", "words"),
    [([1], "groove 2 of 4 (x 60 … 110 µm)"), ([0, 1], "grooves 1 and 2 of 4 (x 40 … 110 µm)"),
     ([3, 0, 1], "grooves 1, 2 and 4 of 4 (x 40 … 110 and 160 … 170 µm)")],
)  # fmt: skip
def test_numbers_are_told_with_their_places(number, words):
    numbers = GrooveNumbers(0.010, 0.050, (0.040, 0.170), 0.100)
    assert numbers.words(0.035 + 0.050 * np.array(number) - 0.100) == words


@pytest.mark.parametrize(
    ("at", "words"),
    [(0.0381, "groove 1 of 3 (x 40 … 90 µm)"), (0.191, "groove 3 of 3 (x 140 … 190 µm)")],
)
def test_a_sliver_at_an_end_counts_with_the_groove_beside_it(at, words):
    numbers = GrooveNumbers(0.040, 0.050, (0.039, 0.191), 0.0)
    assert numbers.words(np.array([at])) == words


def test_grooves_of_two_kinds_are_refused():
    with pytest.raises(InputError, match=r"C are 30 … 58.* /mm, ± 1\d /mm from groove to groove"):
        fit_stylus_trace(traced([58.0, 30.0, 58.0, 30.0, 58.0, 30.0, 58.0, 30.0, 58.0]), BEF)


def test_grooves_that_differ_a_little_are_said_and_held():
    each = 56.0 * (1 + 0.12 * np.array([1, -1, 1, -1, 1, -1, 1, -1, 1]))
    fit = fit_stylus_trace(traced(each), BEF)
    assert any("from groove to groove; groove" in note for note in fit.notes)
    assert fit.curvature.low < 56.0 < fit.curvature.high


def test_grooves_alike_are_not_said_to_differ():
    fit = fit_stylus_trace(traced(58.0), BEF)
    assert not any("groove" in note for note in fit.notes)


def test_nearly_full_grooves_do_not_differ_by_a_little():
    """2 /mm are a quarter of C = 8 /mm, and 4 % of the fill: such were refused."""
    each = 8.0 + np.array([2, -2, 2, -2, 2, -2, 2, -2, 2])
    fit = fit_stylus_trace(traced(each), BEF)
    assert fit.curvature.low < 8.0 < fit.curvature.high
