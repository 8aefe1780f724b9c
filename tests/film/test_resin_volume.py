"""Films as made hold the resin that the mask gives."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, Imperfection, MadeFilm, PrismFilm, check_curvature

BEF = Groove(0.050, 0.025)
WIDER = Groove.of_angle(0.0501, np.radians(89.0))


def film_of(curvature, groove=BEF):
    return PrismFilm(groove, 0.2, 0.5, "filled", curvature)


def resin_by_section(made):
    """Volume of the film less that of prisms with the same radii, by 1e5 heights a groove."""
    groove, tip, valley = made.film.groove, *_radii(made)
    x = (np.arange(100_000) + 0.5) * groove.pitch / 100_000
    local = np.abs(x - groove.half_width)
    slope, size = groove.wall_slope, np.hypot(1, groove.wall_slope)
    bare = slope * local
    low = valley * size - np.sqrt(np.maximum(valley**2 - local**2, 0))
    bare = np.where(local < valley * slope / size, low, bare)
    out = groove.half_width - local
    high = groove.depth - tip * size + np.sqrt(np.maximum(tip**2 - out**2, 0))
    bare = np.where(out < tip * slope / size, high, bare)
    surface = made.section().height(x + groove.pitch) - made.film.base
    return float(np.mean(surface - bare))


def _radii(made):
    return made.imperfection.tip_radius, made.imperfection.valley_radius


@pytest.mark.parametrize("curvature", [15.0, 39.9, 45.0, 60.0, 75.0])
@pytest.mark.parametrize(
    ("groove", "radii"), [(WIDER, (0.0015, 0.001)), (BEF, (0.003, 0.0)), (BEF, (0.0, 0.004))]
)
def test_a_film_as_made_keeps_the_resin(curvature, groove, radii):
    wanted = film_of(np.full(5, curvature)).resin_height
    made = MadeFilm(film_of(np.full(5, curvature), groove), Imperfection(*radii))
    kept = made.with_resin(wanted)
    assert resin_by_section(kept) == pytest.approx(wanted[0], rel=1e-5)
    width, length = kept.size
    assert kept.section().volume - kept.bare_volume == pytest.approx(
        wanted[0] * width * length, rel=1e-7
    )
    assert np.ptp(kept.film.curvature) < 1e-6


def test_without_imperfection_the_curvature_stays():
    curvature = np.linspace(10, 79, 40)
    film = film_of(curvature)
    kept = MadeFilm(film, Imperfection()).with_resin(film.resin_height)
    assert kept.film.curvature == pytest.approx(curvature, rel=1e-6)


def test_more_resin_than_a_groove_holds_is_refused():
    shallow = film_of(np.full(3, 60.0), Groove(0.05, 0.020))
    with pytest.raises(
        InputError, match=r"groove 0: the mask gives 12\.5 µm of resin: expected at"
    ):
        MadeFilm(shallow, Imperfection()).with_resin(np.full(3, 0.0125))


@pytest.mark.parametrize("groove", [Groove(2.0, 1.0), Groove(2.0, 0.5)])
def test_large_grooves_have_small_curvatures(groove):
    check_curvature(0.8, groove, "filled", "job.toml: map.curvature_per_mm")
    with pytest.raises(InputError, match="looks like 1/µm"):
        check_curvature(groove.curvature_empty / 2000, groove, "filled", "x")


def test_a_limit_is_passed_by_digits_that_show_it():
    with pytest.raises(InputError, match=r"80\.000000001: not printable: expected 0 … 80 "):
        check_curvature(80.000000001, BEF, "filled", "x")
    # Rounding alone passes no limit: 90° grooves of any pitch may be empty.
    groove = Groove.of_angle(0.03, np.pi / 2)
    check_curvature(2 / 0.015 * (1 + 2e-16), groove, "filled", "x")
