"""Resin at rest: an arc that meets the walls at its angle and holds the groove's resin."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, Imperfection, MadeFilm, PrismFilm
from mpfcad.film.imperfection import build_section
from mpfcad.film.meniscus import meniscus, meniscus_section
from mpfcad.film.section import ARC, LINE
from mpfcad.units import deg

BEF, FLAT = Groove(0.050, 0.025), Groove(0.050, 0.010)
CURVATURE = np.array([80.0, 74.0, 60.0, 50.0, 40.0, 25.0, 6.0])


def film(groove=BEF, curvature=CURVATURE):
    curvature = np.minimum(curvature, groove.curvature_empty)
    return PrismFilm(groove, 0.1, 2.0, "filled", curvature)


@pytest.mark.parametrize("groove", [BEF, FLAT])
@pytest.mark.parametrize("angle", [0.0, 10.0, 30.0, 45.0])
def test_every_groove_holds_its_resin(groove, angle):
    made = film(groove)
    if angle * deg > np.arctan(groove.wall_slope):
        made = film(groove, np.linspace(0.9, 1.0, 7) * groove.curvature_empty)
    section = meniscus_section(made, angle * deg, 0.0)
    area = np.diff(section.area_to(made.tip_position)) / groove.pitch - made.base - groove.depth / 2
    np.testing.assert_allclose(area, made.fill_fraction * groove.depth / 2, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 10.0, 30.0])
def test_the_arc_meets_the_walls_at_the_contact_angle(angle):
    made = film()
    section = meniscus_section(made, angle * deg, 0.0)
    contact, _ = meniscus(made, angle * deg)
    free = contact < BEF.half_width
    arcs = np.flatnonzero(section.kind == ARC)
    slope = section.slope_on(arcs, section.x[arcs + 1])
    held = (contact > 0) & free
    np.testing.assert_allclose(np.arctan(slope[: held.sum()]), 45 * deg - angle * deg, atol=1e-9)
    # Held by the tips it stands flatter than its own angle lets it.
    assert (np.arctan(slope[held.sum() :]) < 45 * deg - angle * deg + 1e-9).all()
    assert not free[-1] or angle > 0


def test_level_resin_is_flat_up_to_the_brim():
    made = film()
    section = meniscus_section(made, np.arctan(BEF.wall_slope), 0.0)
    assert (section.kind == LINE).all()
    contact, _ = meniscus(made, np.arctan(BEF.wall_slope))
    np.testing.assert_allclose(contact, BEF.half_width * np.sqrt(made.fill_fraction), rtol=1e-12)


def test_the_same_fill_is_another_curvature_by_another_surface():
    one = film(curvature=np.array([60.0]))
    bottom = [
        build_section(one, Imperfection(contact_angle=angle)).height(np.array([0.025]))[0]
        for angle in (None, 0.0, 30 * deg, 45 * deg)
    ]
    # The vertex of the parabola through the tips lies lowest of all but the wetting arc.
    assert bottom[1] < bottom[0] < bottom[2] < bottom[3]


def test_resin_that_stands_above_the_tips_is_refused():
    with pytest.raises(InputError, match=r"groove 6: resin of this contact angle stands .* above"):
        meniscus_section(film(), 89 * deg, 0.0)


def test_a_spread_of_resin_is_carried_and_cut_with_the_film():
    factor = np.linspace(0.9, 1.1, 7)
    made = MadeFilm(film(), Imperfection(), factor).with_resin(film().resin_height)
    wanted = film().fill_fraction * factor
    np.testing.assert_allclose(made.film.fill_fraction, wanted, rtol=1e-9, atol=1e-12)
    assert made.cut(2, 3, 1.0).resin_factor.tolist() == factor[2:5].tolist()
