"""A measured surface as few pieces, and its resin scaled to that of the mask."""

import numpy as np
import pytest

from mpfcad.film import Groove, PrismFilm
from mpfcad.film.imperfection import Imperfection, build_section
from mpfcad.film.measured_section import measured_bare_area, measured_resin
from mpfcad.film.quadratic import fewest_pieces

BEF = Groove(0.05, 0.025)


def sampled(curvature, count=51):
    x = np.linspace(-0.025, 0.025, count)
    return np.column_stack([x, BEF.height(x, curvature)])


def drawn(corner, x):
    """Return the height of pieces (k, 3) at x."""
    at = np.clip(np.searchsorted(corner[:, 0], x, "right") - 1, 0, len(corner) - 2)
    (x0, z0, bend), (x1, z1) = corner[at].T, corner[at + 1, :2].T
    return z0 + (z1 - z0) * (x - x0) / (x1 - x0) + bend / 2 * (x - x0) * (x - x1)


def test_a_parabola_is_one_piece_and_a_wall_another():
    """Contact at 10 µm, a point of the grid: wall, parabola to the centre, and mirrored."""
    point = sampled(4000 / 70)  # contact_position = 2 s/C - w = 10 µm
    corner = fewest_pieces(point, 1e-9, kept=(25,))
    assert corner[:, 0] == pytest.approx([-0.025, -0.01, 0.0, 0.01, 0.025], abs=1e-12)
    assert corner[:, 2] == pytest.approx([0.0, 4000 / 70, 4000 / 70, 0.0, 0.0], abs=1e-5)


def test_no_point_is_farther_off_than_said_and_fewer_pieces_than_chords():
    rng = np.random.default_rng(4)
    point = sampled(60.0)
    point[:, 1] += rng.normal(0, 2e-6, len(point))
    corner = fewest_pieces(point, 6e-6, kept=(25,))
    assert np.abs(drawn(corner, point[:, 0]) - point[:, 1]).max() <= 6e-6
    assert 0.0 in corner[:, 0]
    assert len(corner) <= 12 < len(fewest_pieces(point, 1e-12)) - 12


@pytest.mark.parametrize("share", [0.6, 1.0, 1.7])
def test_each_groove_holds_the_resin_of_its_curvature(share):
    """Area between section and bare surface = fill times groove, exactly, with curved pieces."""
    point = sampled(55.0)
    point[:, 1] += 3e-4 * np.sin(
        2 * np.pi * point[:, 0] / BEF.pitch
    )  # walls that are not the prism's
    measured = fewest_pieces(point, 5e-6, kept=(25,))
    assert np.count_nonzero(measured[:, 2]) >= 2
    film = PrismFilm(BEF, 0.2, 1.0, "filled", np.full(3, 55.0))
    fill = measured_resin(film, measured).area / BEF.area * share
    film = PrismFilm(BEF, 0.2, 1.0, "filled", np.full(3, float(BEF.curvature_of_fill(fill))))
    section = build_section(film, Imperfection(measured=measured))
    bare = film.base * BEF.pitch + measured_bare_area(film, measured)
    resin = np.diff(section.area_to(film.tip_position)) - bare
    assert resin == pytest.approx(np.full(3, fill * BEF.area), rel=1e-9)


def test_a_larger_groove_is_a_similar_one():
    """Every length times 1.1: a curvature over 1.1."""
    measured = fewest_pieces(sampled(58.0), 5e-6, kept=(25,))
    larger = measured * np.array([1.1, 1.1, 1 / 1.1])
    x = np.linspace(-0.025, 0.025, 301)
    assert drawn(larger, 1.1 * x) == pytest.approx(1.1 * drawn(measured, x), abs=1e-12)
