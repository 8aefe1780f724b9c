"""Pieces of a film under LEDs, drawn from film.3mf: a stretch of them that can be looked at."""

import numpy as np
import pytest

from mpfcad.cad.file.library import write_library
from mpfcad.film import Groove
from mpfcad.film.field.library import PieceLibrary
from mpfcad.report.drawing.film.groove_view import GROOVES, LENGTH
from mpfcad.report.drawing.film.library_view import library_view


def test_long_pieces_are_cut_and_seen_whole(tmp_path):
    level, chosen = np.array([55.0, 60.0]), np.array([[0, 1], [1, 0], [0, 0], [1, 1]])
    library = PieceLibrary(Groove(0.05, 0.025), 0.2, 0.5, level, chosen, level[chosen])
    write_library(library, tmp_path / "film.3mf", 2.0)
    figure = library_view(tmp_path / "film.3mf", library)
    (drawn,) = figure.data
    size = [max(drawn[axis]) - min(drawn[axis]) for axis in "xyz"]
    assert np.allclose(size[:2], [GROOVES * 50, LENGTH * 1000])
    eye = figure.layout.scene.camera.eye
    assert eye.x == pytest.approx(1.15, rel=0.01)
