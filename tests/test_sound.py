"""Objects refuse nonsense where they are made."""

import doctest

import numpy as np
import pytest

import mpfcad.sound
from mpfcad.errors import InputError
from mpfcad.film import CellFilm, CurvatureField, CurvatureMap, Groove, PrismFilm
from mpfcad.optics.element import Sheet, Slab

BEF = Groove(0.05, 0.025)
X = np.array([0.0, 1.0])


def film(curvature=60.0, **changed):
    given = {"groove": BEF, "base": 0.2, "length": 1.0, "profile": "filled"} | changed
    return PrismFilm(curvature=np.atleast_1d(np.asarray(curvature, float)), **given)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: Groove(float("nan"), 0.025),
            "groove.pitch: nan: expected a finite number above 0",
        ),
        (lambda: Groove(0.05, 0.0), "groove.depth: 0: expected"),
        (lambda: film(-1.0), "film.curvature[0]: -1: expected a finite number from 0 up to 80"),
        (lambda: film([60.0, np.inf]), "film.curvature[1]: inf"),
        (lambda: film(81.0), "film.curvature[0]: 81"),
        (lambda: film(profile="filed"), "film.profile: 'filed': expected one of filled, ideal"),
        (lambda: film(length=-1.0), "film.length: -1"),
        (lambda: film(base="x"), "film.base: 'x': expected a number"),
        (lambda: CurvatureMap(X, [60.0, np.nan], "pitch", "repeat"), "map.curvature[1]: nan"),
        (lambda: CurvatureMap(X[::-1], [60.0, 61.0], "pitch", "repeat"), "map.position: step"),
        (lambda: CurvatureMap(X, [60.0], "pitch", "repeat"), "expected as many"),
        (lambda: CurvatureMap(X, [60.0, 61.0], "lamp", "repeat"), "map.extent: 'lamp'"),
        (lambda: CurvatureField(X, X, np.full((2, 3), 60.0)), "field.curvature: shape (2, 3)"),
        (lambda: CellFilm(BEF, 0.2, "cone", "ideal", 60.0, (1, 1)), "film.cell: 'cone'"),
        (lambda: CellFilm(BEF, 0.2, "pyramid", "ideal", np.nan, (1, 1)), "film.curvature: nan"),
        (lambda: Sheet(0.3, 0.9, 0.98), "sheet.index: 0.9: expected a finite number from 1"),
        (lambda: Sheet(0.3, 1.5, 1.01), "sheet.transmission: 1.01"),
        (lambda: Slab(1.49, 2.0, absorption=-1.0), "plate.absorption: -1"),
    ],
)
def test_nonsense_is_refused_where_it_is_made(make, words):
    with pytest.raises(InputError) as error:
        make()
    assert words in str(error.value)


def test_what_is_sound_is_made():
    assert film(80.0).groove_count == 1
    assert film(1e4, profile="ideal").curvature[0] == 1e4


def test_the_examples_run():
    assert not doctest.testmod(mpfcad.sound).failed
