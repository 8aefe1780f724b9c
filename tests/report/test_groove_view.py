"""The three-dimensional view and the drawing with dimensions."""

import numpy as np
import pytest

from mpfcad.cad import write_stl
from mpfcad.film import Groove, Imperfection, MadeFilm, PrismFilm
from mpfcad.report.drawing.film.dimension_drawing import draw_dimensions
from mpfcad.report.drawing.film.groove_view import groove_view

BEF = Groove(0.050, 0.025)


def film_of(curvature, profile="filled", count=7):
    return PrismFilm(BEF, 0.2, 2.0, profile, np.full(count, float(curvature)))


def view(film, folder):
    write_stl(film, folder / "film.stl", 0.0087)
    return groove_view(folder / "film.stl", MadeFilm(film, Imperfection()))


@pytest.mark.parametrize(
    ("curvature", "profile", "bodies"),
    [
        (60, "filled", ["prism", "resin"]),
        (20, "filled", ["prism", "resin"]),
        (0, "filled", ["prism", "resin"]),
        (80, "filled", ["prism"]),
        (60, "ideal", ["film"]),
    ],
)
def test_each_body_is_shown_in_its_colour(tmp_path, curvature, profile, bodies):
    figure = view(film_of(curvature, profile), tmp_path)
    assert [trace.name for trace in figure.data] == bodies
    assert len({trace.color for trace in figure.data}) == len(bodies)


def enclosed(trace):
    """Return the volume that a trace's facets enclose [µm³]."""
    points = np.stack([trace.x, trace.y, trace.z], 1).astype(float)
    a, b, c = np.moveaxis(points[np.stack([trace.i, trace.j, trace.k], 1)], 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6)


@pytest.mark.parametrize("curvature", [20.0, 60.0])
def test_the_resin_has_its_true_volume(tmp_path, curvature):
    film = film_of(curvature)
    prism, resin = view(film, tmp_path).data
    shown = 3 * 0.12 * film.fill_volume / film.length / film.groove_count * 1e9
    assert enclosed(resin) == pytest.approx(shown, rel=0.005)
    assert enclosed(prism) == pytest.approx(150 * 120 * (30 + 12.5), rel=1e-3)


def test_the_same_file_gives_the_same_figure(tmp_path):
    assert view(film_of(60), tmp_path).to_json() == view(film_of(60), tmp_path).to_json()


def test_dimensions_are_written_out():
    text = draw_dimensions(MadeFilm(film_of(60), Imperfection()), 0)
    for words in ("pitch 50 µm", "depth 25 µm", "base 200 µm", "z0 6.25 µm", "16.67 µm", "C = 60"):
        assert words in text
    assert "contact" not in draw_dimensions(MadeFilm(film_of(30), Imperfection()), 0)
    assert "z0" in draw_dimensions(MadeFilm(film_of(90, "ideal"), Imperfection()), 0)
