"""Rays of a backlight: the same flux and luminance as are measured, and the same bits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from harness import within

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import TraceRun, light_film
from mpfcad.measure.rays import collect_rays, gate_of
from mpfcad.optics.base.recorder import FLOW_UP
from mpfcad.optics.caught import WEIGHT
from mpfcad.optics.element import Slab
from mpfcad.optics.engine import BLOCK as TRACE_BLOCK
from mpfcad.optics.engine import trace
from mpfcad.optics.forward.passing import BLOCK, passing_rays
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source

OPEN = {"layers": ("diffusing_plate", "bottom_sheet", "top_sheet")}


@pytest.fixture(scope="module")
def lit():
    """Return a stack without a film, in whose film's place a sheet may stand."""
    stack = read_stack("thesis-32in-conventional")
    return light_film(replace(stack, layers=OPEN["layers"]), None)


def collected(lit, at="screen", count=4000, seed=1, threads=1):
    tables = []
    result = collect_rays(lit, at, count, TraceRun(seed, threads), tables.append)
    return result, np.concatenate(tables)


def test_rays_are_those_of_the_paths_that_are_traced(lit):
    blocks = 3
    parts = passing_rays(lit.scene, len(lit.elements), range(blocks), seed=4, threads=2)
    tally = trace(lit.scene, Source(LAMPS, [0.0], 0.0), blocks * BLOCK // TRACE_BLOCK, seed=4)
    weight = sum(part.ray[:, WEIGHT].sum() for part in parts)
    assert weight == pytest.approx(tally.flow[FLOW_UP], rel=1e-12)
    assert np.array_equal(
        np.sum([part.flow for part in parts], axis=0) > 0, np.asarray(tally.flow) > 0
    )


def test_more_rays_than_paths_are_all_caught(lit):
    # Between a white reflector and a plate that scatters much light comes up several times: more
    # than there is room for at first.
    elements = [replace(e, scattering=20.0) if isinstance(e, Slab) else e for e in lit.elements]
    scene = build_scene(elements)
    (part,) = passing_rays(scene, 1, range(1), seed=4, threads=1)
    assert len(part.ray) > 2 * BLOCK
    assert (np.diff(part.path) >= 0).all() and part.path.max() < BLOCK
    once = np.unique(part.path, return_index=True)[1]
    assert (part.ray[once, WEIGHT] <= 1.0).all()


def test_the_same_rays_at_any_number_of_threads(lit):
    one, two = collected(lit, threads=1), collected(lit, threads=2)
    assert np.array_equal(one[1], two[1]) and one[0] == two[0]
    result, table = one
    assert result.rays == len(table) == 4000
    assert np.abs(np.linalg.norm(table[:, 3:6], axis=1) - 1).max() < 1e-6
    assert (table[:, 5] > 0).all() and (table[:, 2] == 0).all()
    fewer = collected(lit, count=1500)[1]
    assert np.array_equal(fewer, table[:1500])
    assert not np.array_equal(collected(lit, count=1500, seed=2)[1], fewer)


def test_flux_and_luminance_are_those_that_a_meter_sees(lit):
    result, table = collected(lit, count=60_000, seed=7)
    source, flux = lit.stack.source, table[:, 6].astype(float) * result.unit
    assert flux.sum() == pytest.approx(result.flux.value, rel=1e-6)
    size = source.lit_size
    area = size.across * size.along * 1e-6
    # The exitance, and luminances along the normal and aslant, by another trace, from the meter.
    hemisphere = Source(EYE, [16.0], lit.stack.period.across, acceptance=1.0)
    tally = trace(lit.scene, hemisphere, 40, seed=9)
    error = math.hypot(result.flux.standard_error / area, math.pi * tally.radiance_error[0])
    within(result.flux.value / area, math.pi * tally.radiance[0], error, 4)
    tilts, half = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.7]]), math.sin(math.radians(12))
    meters = Source(
        EYE, np.full(3, 16.0), lit.stack.period.across, -tilts[:, 0], -tilts[:, 1], half
    )
    tally = trace(lit.scene, meters, 40, seed=9)
    for i, tilt in enumerate(tilts):
        axis = np.array([*tilt, math.sqrt(1 - tilt @ tilt)])
        cosine = table[:, 3:6].astype(float) @ axis
        inside = cosine > math.sqrt(1 - half**2)
        part = flux[inside] * cosine[inside] / table[inside, 5] / (area * math.pi * half**2)
        error = math.hypot(math.sqrt((part**2).sum()), tally.radiance_error[i])
        within(part.sum(), tally.radiance[i], error, 4, str(tilt))


def test_rays_lie_evenly_over_the_panel_with_the_lamps_pattern(lit):
    _, table = collected(lit, count=60_000, seed=7)
    size = lit.stack.source.lit_size
    for axis, length in enumerate(size):
        place = table[:, axis] / length + 0.5
        beyond = lit.scene.length / 2 / length + 1e-6  # whole repeats of the scene
        assert place.min() > -beyond and place.max() < 1 + beyond
        number, _ = np.histogram(place, 12, (0, 1))
        within(number, 5000, math.sqrt(5000), 4.5, "lamps, and along them")
    # Above the lamps, which stand in the middles of their pitches, it is brighter or darker than
    # between them as the trace of the scene says.
    phase = table[:, 0] / lit.stack.period.across + lit.stack.source.count / 2
    above = np.abs(phase - np.floor(phase) - 0.5) < 0.25
    parts = passing_rays(lit.scene, len(lit.elements), range(20), seed=8, threads=1)
    x = np.concatenate([part.ray[:, 0] for part in parts]) / lit.stack.period.across
    expected = np.mean(np.abs(x - np.round(x)) < 0.25)
    error = 0.5 * math.hypot(1 / math.sqrt(len(x)), 1 / math.sqrt(len(table)))
    within(above.mean(), expected, error, 4)


def test_error_of_the_flux_is_what_repeats_show(lit):
    found = [collected(lit, count=3000, seed=seed)[0].flux for seed in range(40)]
    away = np.array([f.value for f in found])
    stated = np.mean([f.standard_error for f in found])
    # The spread of 40 values is known to 1/√78 of itself.
    within(away.std(ddof=1), stated, stated / math.sqrt(78), 4)


def test_what_has_no_place_is_refused(lit):
    with pytest.raises(InputError, match="no film in the stack"):
        gate_of(lit, "film")
    dark = light_film(lit.stack.with_values({}), None)
    elements = [replace(e, transmission=0.0) if e.name == "top sheet" else e for e in dark.elements]
    black = replace(dark, elements=elements, scene=build_scene(elements))
    with pytest.raises(InputError, match=r"0 rays of \d+ paths .* expected light there"):
        collected(black, count=1)
