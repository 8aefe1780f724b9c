"""Coverage at the ends of the range: 200 seeds of each extreme film, none NaN, intervals hold."""

import numpy as np
import pytest
from test_coverage import check, fit, held_by

from mpfcad.backlight import read_stack
from mpfcad.cad import write_stl
from mpfcad.film import Groove, PrismFilm
from mpfcad.measure import contrast_of_curve, light_film, reach
from mpfcad.optics.engine import trace
from mpfcad.optics.source import EYE, Source
from mpfcad.units import deg

RUNS = 200
POSITION = np.linspace(0, 1, 33)
#: One lamp, and where its top is [mm].
LAMP = {
    "lamp_count": 1,
    "lamp_pitch_mm": 4.0,
    "lamp_radius_mm": 0.2,
    "lamp_height_mm": 0.5,
    "panel_width_mm": 4.0,
    "panel_length_mm": 2.0,
}
TOP = 0.7


def ulp(value, side):
    return float(np.nextafter(value, side))


def film(curvature, profile="filled", width=0.05, count=80):
    groove = Groove(width, width / 2)
    return PrismFilm(groove, 0.2, 2.0, profile, np.full(count, curvature))


#: Film and thickness of the stack [mm]. The empty groove of 50 µm and 90° has C = 40 /mm as the
#: circle through its tips and its bottom; 80 is what a parabola's fill leaves.
CASES = {
    "C 40": (film(40.0), 20.0),
    "C below 40": (film(ulp(40.0, 0.0)), 20.0),
    "C above 40": (film(ulp(40.0, 50.0)), 20.0),
    "C 80": (film(80.0), 20.0),
    "C below 80": (film(ulp(80.0, 0.0)), 20.0),
    "ideal C 0": (film(0.0, "ideal"), 20.0),
    "ideal C 40": (film(40.0, "ideal"), 20.0),
    "one groove": (film(0.75, "filled", 4.0, 1), 20.0),
    "thickness at the tops": (film(60.0), ulp(TOP, 1.0)),
    "thin": (film(60.0), TOP + 1e-3),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_an_extreme_has_no_nan_and_its_intervals_hold(tmp_path, case):
    made, thickness = CASES[case]
    write_stl(made, tmp_path / "film.stl", 0.5 * deg)
    lit = light_film(read_stack("thesis-32in-mpf", thickness, LAMP), tmp_path / "film.stl")
    source = Source(EYE, POSITION * lit.stack.period.across, 1.0, acceptance=lit.stack.acceptance)
    found = [trace(lit.scene, source, 4, seed=2000 + i) for i in range(RUNS)]
    total = found[0]
    for tally in found[1:]:
        total = total + tally
    *fits, truth = [fit(lit, t) for t in (*found, total)]
    contrasts = [contrast_of_curve(one, i) for i, one in enumerate(fits)]
    means = [one.mean() for one in fits]
    figures = [(t.radiance, t.radiance_error, t.fraction) for t in found]
    ends = [(one.value, one.low, one.high) for one in (*contrasts, *means)]
    assert all(np.isfinite(part).all() for row in figures for part in row)
    assert np.isfinite(ends).all()
    wide = reach(found[0].radiance_freedom)
    check([np.abs(t.radiance - total.radiance) <= wide * t.radiance_error for t in found])
    check(held_by(means, truth.mean().value))
    top, bottom = truth.curve.max(), truth.curve.min()
    # Where the contrast is below the noise its intervals begin at 0 and miss on one side only.
    check(held_by(contrasts, (top - bottom) / (top + bottom)), 0.93, 0.985)
