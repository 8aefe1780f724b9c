"""Maps that the search finds: known ones again, flat ones, and none outside the constraints."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpfcad.design import (
    Constraint,
    Correction,
    Goal,
    Traced,
    best_of,
    bound_contrast,
    correction_of,
    cosine_basis,
    find_optimum,
    predict,
    row_position,
    search_by_inversion,
    search_by_response,
    series_rows,
)
from mpfcad.design.cosine import project
from mpfcad.design.optimum import contrast_of, map_on_cells
from mpfcad.design.reach import find_reach
from mpfcad.design.thesis import invert

PITCH = 32.69
WIDE = Constraint(20.0, 80.0, 20.0, 3)


def flattening(response, series):
    """Return the correction that makes a series' luminance flat."""
    basis = cosine_basis(response.grid.centre, len(series) - 1)
    luminance = response.luminance(basis @ series)
    waves = cosine_basis(response.grid.centre, 6)[:, 1:]
    relative = 2 * (luminance / luminance.mean()) @ waves / len(waves)
    return Correction(1.0, -relative)


def test_a_known_map_is_recovered_from_its_own_luminance(lamps):
    known = np.array([47.0, 6.0, -3.0, 1.5])
    start = np.array([47.0, 0.0, 0.0, 0.0])
    found = find_optimum(start, lamps, flattening(lamps, known), WIDE, Goal(), PITCH)
    position = row_position()
    # The mean of C hardly shows in the luminance's shape; the map about its mean does.
    shape = cosine_basis(position, 3)[:, 1:] @ (found - known)[1:]
    assert np.abs(shape).max() < 0.5
    assert predict(found, lamps, flattening(lamps, known)).contrast < 1e-4


def test_a_uniform_source_keeps_a_flat_map(uniform):
    for start in ([50.0, 0, 0, 0], [50.0, 6.0, -3.0, 2.0]):
        found = find_optimum(
            np.array(start, float), uniform, Correction.none(), WIDE, Goal(), PITCH
        )
        assert np.ptp(series_rows(found)[1]) < 0.1


def test_lamps_are_hidden_and_weight_buys_luminance(lamps):
    start = np.array([50.0, 0, 0, 0])
    plain = find_optimum(start, lamps, Correction.none(), WIDE, Goal(), PITCH)
    bright = find_optimum(start, lamps, Correction.none(), WIDE, Goal(0.004, 0.2), PITCH)
    plain, bright = (predict(s, lamps, Correction.none()) for s in (plain, bright))
    assert plain.contrast < 1e-3 < predict(start, lamps, Correction.none()).contrast
    assert bright.mean > plain.mean


def test_a_shift_to_be_borne_lowers_the_worst_contrast(lamps):
    start, none = np.array([50.0, 0, 0, 0]), Correction.none()
    shift = 3.0
    plain = find_optimum(start, lamps, none, WIDE, Goal(), PITCH)
    robust = find_optimum(start, lamps, none, WIDE, Goal(registration=shift), PITCH)
    worst = [predict(s, lamps, none, shift / PITCH).contrast for s in (plain, robust)]
    assert worst[1] < worst[0]


@settings(max_examples=25, deadline=None)
@given(
    st.floats(20, 45),
    st.floats(1, 40),
    st.floats(0.05, 20),
    st.integers(1, 6),
    st.lists(st.floats(0, 120), min_size=4, max_size=9),
)
def test_projected_maps_keep_the_constraints(low, span, change, harmonics, wanted):
    constraint = Constraint(low, low + span, change, harmonics)
    position = np.linspace(0, 1, len(wanted))
    check(series_rows(project(position, wanted, constraint, PITCH))[1], constraint)


@pytest.mark.parametrize("change", [0.3, 2.0])
@pytest.mark.parametrize("goal", [Goal(), Goal(0.0, 1.0), Goal(registration=0.5)])
def test_optima_keep_the_constraints(lamps, change, goal):
    constraint = Constraint(40.0, 55.0, change, 4)
    start = np.append(47.5, np.zeros(4))
    found = find_optimum(start, lamps, Correction.none(), constraint, goal, PITCH)
    check(series_rows(found)[1], constraint)


def check(rows, constraint):
    position = row_position() * PITCH
    assert (rows == rows[::-1]).all()
    assert constraint.curvature_min <= rows.min() and rows.max() <= constraint.curvature_max
    assert np.abs(np.diff(rows) / np.diff(position)).max() <= constraint.change_max


class Bench:
    """A 'full trace': the model with harmonics that it knows nothing of, counted in paths."""

    def __init__(self, response, relative):
        self.response, self.truth = response, Correction(1.02, np.array(relative))
        self.paths = 0

    def __call__(self, rows, label, number, shift):
        centre = self.response.grid.centre
        curvature = np.interp((centre - shift / PITCH) % 1, row_position(), rows)
        luminance = self.response.luminance(curvature)
        luminance = self.truth.apply(centre, luminance, shifted=shift != 0)
        coefficient = [luminance.mean()]
        for k in range(1, 5):
            for wave in (np.cos, np.sin):
                coefficient.append(2 * np.mean(luminance * wave(2 * np.pi * k * centre)))
        contrast = (luminance.max() - luminance.min()) / (luminance.max() + luminance.min())
        self.paths += 1000
        return Traced(contrast, contrast, contrast, luminance.mean(), 0.0, tuple(coefficient), 1000)


RELATIVE = [0.01, -0.006, 0.002, 0.001]


def test_the_search_learns_from_the_trace(lamps):
    bench = Bench(lamps, RELATIVE)
    done = search_by_response(
        lamps, WIDE, Goal(), PITCH, bench, iterations=4, contrast_target=0.002
    )
    assert done[0].traced.contrast > 0.005
    assert best_of(done, Goal()).traced.contrast <= 0.002
    assert len(done) <= 3


def test_the_search_traces_the_shifted_map_and_lowers_the_worst(lamps):
    odd = np.array([0.004, 0.0, 0.0, 0.0])
    shift, stop = 4.0, {"iterations": 3, "contrast_target": 1e-6}
    found = []
    for goal in (Goal(), Goal(registration=shift)):
        bench = Bench(lamps, RELATIVE)
        bench.truth = Correction(1.02, np.array(RELATIVE), odd)
        done = search_by_response(lamps, WIDE, goal, PITCH, bench, **stop)
        best = best_of(done, goal)
        moved = bench(np.array(best.rows), "", 0, shift)
        found.append(max(best.traced.contrast, moved.contrast))
    assert best.shifted == moved and best.worst.contrast == found[1]
    assert found[1] < found[0]
    correction = correction_of(done, lamps, shift / PITCH)
    assert correction.relative == pytest.approx(RELATIVE, abs=1e-4)
    assert correction.odd == pytest.approx(odd, abs=1e-4)


def test_fewer_traces_than_the_published_method_and_less_contrast(lamps):
    bench, published = Bench(lamps, RELATIVE), Bench(lamps, RELATIVE)
    stop = {"iterations": 4, "contrast_target": 0.001}
    ours = search_by_response(lamps, WIDE, Goal(), PITCH, bench, **stop)
    theirs = search_by_inversion([30, 40, 50, 60, 70], WIDE, PITCH, published, **stop)
    assert bench.paths < published.paths
    theirs = [one for one in theirs if len(one.series) > 1]
    assert best_of(ours, Goal()).traced.contrast <= best_of(theirs, Goal()).traced.contrast


def test_inversion_takes_the_film_that_has_the_target():
    uniform = np.array([40.0, 50.0, 60.0])
    luminance = np.array([[120.0, 90.0], [110.0, 80.0], [90.0, 70.0]])
    assert invert(uniform, luminance, 100.0) == pytest.approx([55.0, 40.0])


def test_no_map_goes_beyond_the_reach(lamps):
    # Lamps far stronger than the film can hide: the reach says so, and the optimum obeys it.
    truth = Correction(1.0, np.array([0.4, 0.0, 0.0, 0.0]))
    reach = find_reach(lamps, truth, 20.0, 80.0)
    assert reach.ratio[1] < 1 and not reach.overlaps
    best = find_optimum(np.array([50.0, 0, 0, 0]), lamps, truth, WIDE, Goal(), PITCH)
    least = (1 - reach.ratio[1]) / (1 + reach.ratio[1])
    assert predict(best, lamps, truth).contrast >= least - 1e-3 > 0.05
    assert find_reach(lamps, Correction.none(), 20.0, 80.0).overlaps


def test_no_map_goes_below_the_bound_and_parts_raise_it(lamps):
    truth = Correction(1.0, np.array([0.4, 0.0, 0.0, 0.0]))
    rough, fine = (bound_contrast(lamps.operators, truth, 20.0, 80.0, parts) for parts in (1, 9))
    random = np.random.default_rng(1)
    half = lamps.grid.cells // 2
    maps = [np.where(random.random(half) < random.random(), 20.0, 80.0) for _ in range(20)]
    maps += [random.uniform(20, 80, half) for _ in range(20)]
    found = [truth.apply(lamps.grid.centre, unsmoothed(lamps, np.r_[m, m[::-1]])) for m in maps]
    best = find_optimum(np.array([50.0, 0, 0, 0]), lamps, truth, WIDE, Goal(), PITCH)
    found.append(truth.apply(lamps.grid.centre, unsmoothed(lamps, map_on_cells(best, lamps))))
    least = min(map(contrast_of, found))
    assert 0.01 < rough <= fine <= least
    assert bound_contrast(lamps.operators, Correction.none(), 20.0, 80.0) == pytest.approx(0)


def unsmoothed(response, curvature):
    return response.derivative(curvature, np.zeros((0, len(curvature))))[0]
