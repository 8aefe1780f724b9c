"""Paths that end on the reflector: same light, known errors, in less time."""

import numpy as np
import pytest
from harness import film_file, groove

from mpfcad.backlight import read_stack
from mpfcad.measure import TraceRun, light_film, luminance_over_pitch
from mpfcad.measure.glow import _glow, _places, can_glow, find_glow
from mpfcad.measure.meter import pitch_positions
from mpfcad.measure.rounds import trace_lit
from mpfcad.optics.engine import landed_weights
from mpfcad.optics.source import EYE, Source

STACKS = {
    "sheets": ("thesis-32in-mpf", {}),
    "diffusing plate": ("thesis-32in-conventional", {}),
    "mirror in part": ("thesis-32in-mpf", {"reflector_specular_fraction": 0.8}),
    "Lambertian, dark tubes": (
        "thesis-32in-mpf", {"reflector_specular_fraction": 0.0, "lamp_reflectance": 0.1},
    ),
    "thick tubes": ("thesis-32in-mpf", {"lamp_radius_mm": 3.4, "lamp_height_mm": 3.5}),
}  # fmt: skip


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    folder = tmp_path_factory.mktemp("film")
    return film_file(folder / "film.stl", [groove(60.0)] * 20, base=0.2)


def light(mesh, name):
    preset, change = STACKS[name]
    return light_film(read_stack(preset, overrides=change), mesh)


def meter(lit):
    position = pitch_positions(lit.stack) * lit.stack.period.across
    return Source(EYE, position, lit.spot.width, acceptance=lit.stack.acceptance)


def with_table(lit, seed, table, blocks):
    """Return a glow of so many blocks, and a meter's tally with it."""
    glow = _glow(lit, trace_lit(lit, _places(lit), table, seed=seed))
    return glow, trace_lit(glow.lit, meter(lit), blocks, seed=seed + 1)


@pytest.mark.parametrize("name", STACKS)
def test_points_are_those_of_whole_paths(mesh, name):
    """χ² of 33 points, each within its errors; seeds 11 … 13."""
    lit = light(mesh, name)
    whole = trace_lit(lit, meter(lit), 16, seed=11)
    glow, tally = with_table(lit, 12, 4, 16)
    shape, mean = glow.errors(tally)
    off = tally.radiance - whole.radiance
    error = np.sqrt(tally.radiance_error**2 + whole.radiance_error**2 + shape**2)
    # 33 degrees of freedom and the mean's own: 3.5 σ of either.
    level = np.sum(off / error**2) / np.sum(error**-2)
    assert abs(level) < 3.5 * np.hypot(mean, np.sum(error**-2) ** -0.5)
    assert np.sum(((off - level) / error) ** 2) < 32 + 3.5 * 8
    assert tally.radiance_error.mean() < whole.radiance_error.mean()


def test_a_reflector_that_is_looked_at_through_nothing_lands_where_it_is_seen():
    """A meter without film or sheets sees a place: all weight that stays lands there."""
    from dataclasses import replace

    stack = read_stack("thesis-32in-mpf", overrides={"reflector_specular_fraction": 0.25})
    stack = replace(stack, layers=("clear_plate",))
    lit = light_film(stack, None)
    glow = _glow(lit, trace_lit(lit, _places(lit), 2, seed=3))
    tally = trace_lit(glow.lit, meter(lit), 2, seed=4)
    landed = landed_weights(glow.lit.scene, tally)
    place = np.round(np.linspace(0, 1, 33) * 64).astype(int) % 64
    between = np.abs((np.arange(64) - place[:, None] + 32) % 64 - 32) <= 2
    beside = np.abs(np.linspace(0, 1, 33) - 0.5) < 0.35
    # What returns from the plate lands elsewhere: 8 % of it, 94 % reflected, 75 % not mirrored.
    at = (landed * between).sum(axis=1)[beside]
    assert np.all(at > 0.9 * landed.sum(axis=1)[beside])
    assert at == pytest.approx(0.92 * stack["reflector_reflectance"] * 0.75, rel=0.05)


def test_a_scene_without_white_reflector_has_no_table(mesh):
    assert can_glow(light(mesh, "sheets"))
    panel = read_stack("thesis-32in-mpf", overrides={"extent": "panel"})
    assert not can_glow(light_film(panel, mesh))
    mirror = read_stack("thesis-32in-mpf", overrides={"reflector_specular_fraction": 1.0})
    assert not can_glow(light_film(mirror, mesh))


def test_films_must_repeat_with_the_lamps(tmp_path):
    """A table holds one lamp pitch: it would be wrong of films that differ from one to the next."""
    stack = read_stack("thesis-32in-mpf")
    pitch = round(stack.period.across / 0.05)
    grooves = np.where(np.arange(2 * pitch) < pitch, 75.0, 60.0)
    both = film_file(tmp_path / "two.stl", [groove(c) for c in grooves], base=0.2)
    assert not can_glow(light_film(stack, both))
    shape = 60 + 5 * np.cos(2 * np.pi * np.arange(pitch) / pitch)
    one = film_file(tmp_path / "one.stl", [groove(c) for c in shape], base=0.2)
    assert can_glow(light_film(stack, one))
    short = film_file(tmp_path / "short.stl", [groove(c) for c in shape[:400]], base=0.2)
    assert not can_glow(light_film(stack, short))


def test_a_table_that_saves_no_time_is_not_made(mesh):
    lit = light(mesh, "sheets")
    plain = trace_lit(lit, meter(lit), 4, seed=5)
    assert find_glow(lit, meter(lit), TraceRun(seed=5), plain, 4.0) is None
    assert find_glow(lit, meter(lit), TraceRun(seed=5), plain, 400.0) is not None


@pytest.fixture(scope="module")
def found(mesh):
    run = TraceRun(seed=6, path_limit=1_500_000)
    return luminance_over_pitch(light(mesh, "sheets"), run, half_width_goal=0.0)


def test_threads_do_not_change_it(mesh, found):
    run = TraceRun(seed=6, path_limit=1_500_000, threads=2)
    again = luminance_over_pitch(light(mesh, "sheets"), run, half_width_goal=0.0)
    assert np.array_equal(again.luminance, found.luminance)
    assert again.mean_luminance == found.mean_luminance
    assert again.contrast == found.contrast


def test_a_table_is_used_and_counted(found):
    blocks = -(-1_500_000 // (33 * 512))
    assert found.paths > blocks * 33 * 512
    assert found.convergence[-1, 0] == found.paths
    # The mean's error holds what all points share.
    alone = np.sqrt(np.sum(found.standard_error[:-1] ** 2)) / 32
    assert found.mean_luminance.standard_error > 1.1 * alone


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sheets", "diffusing plate"])
def test_errors_hold_what_seeds_show(mesh, name):
    """Mean, first and second cosine over 200 seeds: spread of z within 4 σ of 1."""
    lit = light(mesh, name)
    wave = np.cos(2 * np.pi * np.outer([0, 1, 2], np.linspace(0, 1, 33)))[:, :-1] / 32
    figures, errors = [], []
    for seed in range(200):
        glow, tally = with_table(lit, 2 * seed + 100, 2, 10)
        shape, mean = glow.errors(tally)
        error = np.hypot(tally.radiance_error, shape)[:-1]
        figures.append(wave @ tally.radiance[:-1])
        found = np.sqrt(wave**2 @ error**2)
        found[0] = np.hypot(found[0], mean)
        errors.append(found)
    z = (np.array(figures) - np.mean(figures, axis=0)) / np.array(errors)
    # The error of a standard deviation of 200 values is 5 %.
    assert z.std(axis=0, ddof=1) == pytest.approx(np.ones(3), abs=0.2)
