"""A finite panel: walls, lamps one by one, and what leaves at the rim."""

from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, film_mesh, single_paths, within
from oracle.tracer import Philox, ReferenceTracer

from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source

PITCH = 32.69
ENDLESS = Cavity(20.0, PITCH, 0.0, 3.5, 1.7, 1000.0, 0.75, 0.94, 0.3)
EDGES = (-40.0, 60.0, -50.0, 50.0)
PANEL = Panel(*EDGES, (-20.0, 9.0, 41.5), (1.0, 0.4, 1.1), 80.0, 0.9, 0.4)
BOX = replace(ENDLESS, panel=PANEL)
SHEET = Sheet(0.36, 1.49, 0.98)
PLATE = Slab(1.49, 2.0, 0.6, 0.0036, 0.8)


def paths(elements, count, x=55.0, y=45.0):
    source = Source(EYE, np.array([x]), 3.0, acceptance=0.5, along=y, spot_along=3.0)
    found = np.empty(count)
    flow = np.zeros(len(FLOWS) + len(elements))
    single_paths(build_scene(elements), source, 1, 0, found, flow)
    return found, flow


@pytest.mark.parametrize("place", [(0.0, 0.0), (58.0, 48.0), (-39.0, 10.0)])
def test_paths_on_a_finite_panel_equal_the_oracle(place):
    elements = [BOX, PLATE, SHEET]
    engine, _ = paths(elements, 300, *place)
    oracle = ReferenceTracer(elements)
    expected = [
        oracle.radiance(place[0], 3.0, 0.5, Philox(1, EYE, p, 1), y=place[1], spot_along=3.0)
        for p in range(300)
    ]
    assert np.any(expected)
    differs = np.abs(engine - expected) > 1e-9 * np.max(expected)
    assert differs.mean() <= 1 / 300


@pytest.mark.parametrize("mirrored", [1.0, 0.3])
def test_walls_as_bright_as_all_else_are_not_seen(mirrored):
    # Black tubes of radiance 1 through the walls, white walls, a sky of 1: every path ends at a 1,
    # over a mirror exactly, else, by the reflector's control variate, in the mean.
    panel = replace(PANEL, lamp_factor=(1.0, 1.0, 1.0), lamp_length=100.0, wall_reflectance=1.0)
    cavity = replace(
        ENDLESS, lamp_luminance=1.0, lamp_reflectance=0.0, reflectance=1.0,
        specular_fraction=mirrored, panel=panel,
    )  # fmt: skip
    scene = build_scene([cavity, replace(SHEET, transmission=1.0)], above=1.0)
    source = Source(EYE, np.array([-39.9, 0.0, 59.9]), 0.1, acceptance=0.9, along=49.9)
    tally = trace(scene, replace_spot(source), 20, seed=2)
    if mirrored == 1.0:
        assert (tally.radiance == 1.0).all() and (tally.score2 == tally.paths).all()
    else:
        assert tally.radiance_error.max() < 0.005
        within(tally.radiance, 1.0, tally.radiance_error, 4)


def replace_spot(source):
    return Source(*source[:7], spot_along=0.1)


def test_mirrors_half_a_pitch_from_a_lamp_are_a_row_without_end():
    mirrors = Panel(-PITCH / 2, PITCH / 2, -30.0, 30.0, (0.0,), (1.0,), 60.0, 1.0, 1.0)
    places = np.array([0.0, 5.0, 11.0, 16.0])
    source = Source(EYE, places, 0.5, acceptance=0.3, along=29.0, spot_along=1.0)
    tallies = [
        trace(build_scene([cavity, SHEET]), source, 60, seed=seed)
        for seed, cavity in ((3, ENDLESS), (4, replace(ENDLESS, panel=mirrors)))
    ]
    error = np.hypot(*(t.radiance_error for t in tallies))
    assert error.max() < 0.02 * tallies[0].radiance.min()
    within(tallies[0].radiance, tallies[1].radiance, error, 4)


def test_light_of_uneven_lamps_adds_up_path_by_path():
    def seen(*factor):
        return paths([replace(BOX, panel=replace(PANEL, lamp_factor=factor)), SHEET], 400)[0]

    total = seen(1.0, 0.3, 2.0)
    parts = seen(1.0, 0.0, 0.0) + 0.3 * seen(0.0, 1.0, 0.0) + seen(0.0, 0.0, 2.0)
    assert total.any()
    assert np.abs(total - parts).max() < 1e-9 * total.max()


def test_light_forward_is_light_backward_over_the_whole_panel(tmp_path):
    # Power of the tubes: pi L 2 pi r l; what comes out: pi times the mean radiance times the area.
    film = Film(film_mesh(tmp_path, [BARE] * 2), 1.55, rotation=0.4)
    scene = build_scene([BOX, PLATE, SHEET, film])
    forward = trace(scene, Source(LAMPS, np.zeros(1), 0.0), 300, seed=5)
    tube = 2 * np.pi * 1.7 * 80.0 * 1000.0 * sum(PANEL.lamp_factor)
    width, length = EDGES[1] - EDGES[0], EDGES[3] - EDGES[2]
    middle = np.array([sum(EDGES[:2]) / 2])
    source = Source(EYE, middle, width, acceptance=1.0, along=0.0, spot_along=length)
    seen = trace(scene, source, 600, seed=6)
    area = width * length
    error = np.hypot(tube * forward.fraction_error[0], area * seen.radiance_error[0])
    assert error < 0.01 * tube * forward.fraction[0]
    within(tube * forward.fraction[0], area * seen.radiance[0], error, 3.5)


def test_light_in_is_light_out_and_absorbed_by_name(tmp_path):
    film = Film(film_mesh(tmp_path, [BARE] * 2), 1.55)
    tally = trace(
        build_scene([BOX, PLATE, SHEET, film]), Source(LAMPS, np.zeros(1), 0.0), 100, seed=7
    )
    share = dict(zip(FLOWS, tally.fraction, strict=False))
    assert tally.fraction.sum() == pytest.approx(1, abs=1e-12)
    assert share["lost"] == 0 == share["down"]
    assert share["walls"] > 0.01 and share["lamps"] > 0.01 and share["rim"] > 0.001
    error = tally.fraction_error[FLOWS.index("roulette")]
    within(share["roulette"], 0.0, error, 5)
    assert error < 1e-3


def test_black_is_what_lies_beside_the_panel():
    found, flow = paths([BOX, SHEET], 50, x=80.0)
    assert (found == 0).all()
    assert flow[FLOWS.index("rim")] == pytest.approx(50 * SHEET.transmission)


def test_a_symmetric_panel_is_as_bright_left_as_right_and_near_as_far(tmp_path):
    lamps = (-30.0, 0.0, 30.0)
    panel = Panel(-45.0, 45.0, -40.0, 40.0, lamps, (0.7, 1.2, 0.7), 70.0, 0.9, 0.2)
    crossed = Film(film_mesh(tmp_path, [BARE] * 2), 1.55, rotation=np.pi / 2, flipped=True)
    scene = build_scene([replace(ENDLESS, panel=panel), PLATE, crossed, SHEET])
    x, y = np.array([-40.0, 40.0, -40.0, 40.0, 0.0]), np.array([-35.0, -35.0, 35.0, 35.0, 0.0])
    source = Source(EYE, x, 2.0, acceptance=0.3, along=y, spot_along=2.0)
    tally = trace(scene, source, 60, seed=8)
    corners, error = tally.radiance[:4], tally.radiance_error[:4]
    within(corners, corners.mean(), error, 4)
    assert corners.max() + 5 * error.max() < tally.radiance[4]
