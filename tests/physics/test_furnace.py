"""White furnace: amid equal brightness nothing that does not absorb is seen."""

from dataclasses import replace

import numpy as np
import pytest
from harness import (
    BARE,
    CONCAVE,
    compiled,
    crossed_mesh,
    film_mesh,
    groove,
    pass_layers,
    section_mesh,
    within,
)

from mpfcad.optics.base.recorder import FLOW_LAMPS, FLOW_RIM, FLOW_UP
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source

UNDERCUT, RODS = "rod in an undercut over a void", "rods under grooves"
PATTERN = [groove(c) for c in (57.0, 30.0, 75.0)]
CLEAR, DIFFUSING = Slab(1.49, 2.0), Slab(1.49, 2.0, 0.6, 0.0, 0.8)
BOTTOM, TOP = Sheet(0.36, 1.49, 1.0), Sheet(0.35, 1.49, 1.0)


def stack(name, folder):
    match name:
        case "conventional":
            return [DIFFUSING, BOTTOM, Film(film_mesh(folder, [BARE]), 1.55), TOP]
        case "mpf":
            return [CLEAR, BOTTOM, Film(film_mesh(folder, PATTERN), 1.55, offset=0.013), TOP]
        case "mpf-plate":
            grooved = Slab(1.49, 2.0, 0.6, 0.0, 0.8, bonded=True)
            return [grooved, Film(film_mesh(folder, PATTERN), 1.55, 1.49), TOP]


def lamps(luminance, reflectance):
    return Cavity(20.0, 32.69, 0.0, 3.5, 1.7, luminance, reflectance, 1.0, 0.3)


@pytest.mark.parametrize("tilt", [0.0, 0.9])
@pytest.mark.parametrize("name", ["conventional", "mpf", "mpf-plate"])
def test_every_path_ends_at_radiance_one(tmp_path, name, tilt):
    # Black lamps of luminance 1 under a sky of 1, nothing else absorbs: each path ends at a 1 with
    # its whole weight. Its radiance is 1 in the mean only: lamps are counted at the reflector, not
    # where they are met.
    scene = build_scene([lamps(1.0, 0.0), *stack(name, tmp_path)], above=1.0)
    source = Source(EYE, np.linspace(0, 32.69, 5), 1.0, tilt_x=tilt, acceptance=0.05)
    tally = trace(scene, source, 10, seed=41)
    assert tally.flow[FLOW_UP] + tally.flow[FLOW_LAMPS] == tally.total_paths
    assert tally.radiance_error.max() < 0.005
    within(tally.radiance, 1.0, tally.radiance_error, 4)


@pytest.mark.parametrize("mirrored", [1.0, 0.3])
def test_every_path_sees_radiance_one_on_a_panel(tmp_path, mirrored):
    # Over a mirror lamps are counted where they are met, exactly; over what is Lambertian a part
    # comes from the control variate, right in the mean.
    panel = Panel(-50.0, 50.0, -40.0, 40.0, (-16.0, 16.0), (1.0, 1.0), 90.0, 1.0, 0.2)
    cavity = replace(lamps(1.0, 0.0), specular_fraction=mirrored, panel=panel)
    scene = build_scene([cavity, *stack("mpf", tmp_path)], above=1.0)
    source = Source(EYE, np.linspace(-5, 5, 3), 1.0, acceptance=0.05)
    tally = trace(scene, source, 2 if mirrored == 1.0 else 40, seed=41)
    inside = tally.flow[FLOW_UP] + tally.flow[FLOW_LAMPS]
    assert inside + tally.flow[FLOW_RIM] == tally.total_paths
    if mirrored == 1.0:
        assert tally.score.sum() == inside
    else:
        assert tally.radiance_error.max() < 0.005
        error = np.sqrt((tally.radiance_error**2).sum()) / 3
        within(tally.radiance.mean(), inside / tally.total_paths, error, 4)


def test_reflecting_lamps_that_emit_what_they_absorb_are_as_bright(tmp_path):
    # Luminance 1-r and reflectance r: radiosity 1. The roulette makes this true in the mean only.
    scene = build_scene([lamps(0.25, 0.75), *stack("mpf", tmp_path)], above=1.0)
    tally = trace(scene, Source(EYE, np.linspace(0, 32.69, 5), 1.0, acceptance=0.05), 40, seed=42)
    assert tally.radiance_error.max() < 0.005
    within(tally.radiance, 1.0, tally.radiance_error, 4)


def layers(name, folder):
    film = Film(film_mesh(folder, [CONCAVE]), 1.55)
    return {
        "sheet": [TOP],
        "wide sheet": [Sheet(2.0, 1.6, 1.0)],
        "clear": [CLEAR],
        "diffusing": [DIFFUSING],
        "backward": [Slab(1.49, 2.0, 1.0, 0.0, -0.7)],
        "film": [film],
        "pyramids": [Film(crossed_mesh(folder), 1.5)],
        **{n: [Film(section_mesh(folder, n), 1.55)] for n in (UNDERCUT, RODS)},
        "two films": [film, replace(film, rotation=np.pi / 2)],
        "askew, upside down": [BOTTOM, replace(film, rotation=0.5, flipped=True), film],
        "resin": [replace(film, resin=Resin(film_mesh(folder, [BARE]), 60.0, 0.4))],
        **{n: stack(n, folder) for n in ("conventional", "mpf", "mpf-plate")},
    }[name]


@pytest.mark.parametrize(
    "name",
    ["sheet", "wide sheet", "clear", "diffusing", "backward", "film", "pyramids",
     UNDERCUT, RODS, "two films", "askew, upside down", "resin", "conventional",
     "mpf", "mpf-plate"],
)  # fmt: skip
def test_lambertian_light_from_both_sides_leaves_lambertian(tmp_path, name):
    # Forward: equal Lambertian light from below and above must leave upward as Lambertian light,
    # whatever lossless thing lies between: kx, ky uniform in the unit disk, as many as came in.
    scene = build_scene(layers(name, tmp_path))
    count = 120_000
    k = []
    for below in (True, False):
        out = np.empty((count, 4))
        pass_layers(scene, below, 43 + below, out)
        assert (out[:, 0] != 0).all() and (out[:, 3] == 1).all()
        k.append(out[out[:, 0] == 1, 1:3])
    k = np.concatenate(k)
    # The number is a sum of 2·count chances: its variance is at most 2·count/4.
    within(len(k), count, np.sqrt(count / 2), 4)
    radius, azimuth = (k**2).sum(axis=1), np.arctan2(k[:, 1], k[:, 0])
    number, _, _ = np.histogram2d(radius, azimuth, (10, 12), ((0, 1), (-np.pi, np.pi)))
    within(number, count / 120, np.sqrt(count / 120), 5, "bins of equal projected solid angle")
    chi2 = ((number - count / 120) ** 2 / (count / 120)).sum()
    within(chi2, 120, np.sqrt(240), 4)


def test_the_furnace_can_fail(tmp_path):
    # The same bins under a stack that absorbs, and under light from one side only.
    out = np.empty((120_000, 4))
    pass_layers(build_scene(layers("film", tmp_path)), True, 44, out)
    k = out[out[:, 0] == 1, 1:3]
    number, _ = np.histogram((k**2).sum(axis=1), 10, (0, 1))
    assert np.abs(number - number.mean()).max() > 20 * np.sqrt(number.mean())


def test_an_ideal_diffuser_makes_any_light_lambertian():
    # Isotropic scattering, optically very thick: normal light leaves (upward and downward) with a
    # distribution that does not know the azimuth, and the Lambertian furnace above holds.
    scene = build_scene([Slab(1.0, 2.0, 20.0, 0.0, 0.0)])
    out = np.empty((60_000, 4))
    pass_layers(scene, True, 45, out)
    k = out[out[:, 0] == -1, 1:3]
    within(k.mean(axis=0), 0.0, 0.5 / np.sqrt(len(k)), 4)
    within(np.mean(k[:, 0] * k[:, 1]), 0.0, 0.25 / np.sqrt(len(k)), 4)


def test_the_lambertian_part_of_the_reflector_is_lambertian():
    from mpfcad.optics.base import sampling
    from mpfcad.optics.cavity import endless as cavity

    reflector_direction = compiled(cavity.reflector_direction)
    rng = np.zeros(sampling.RNG_SIZE, np.uint64)
    compiled(sampling.start_path)(rng, np.uint64(46), np.uint64(0), np.uint64(0))
    into = 0.6, 0.0, -0.8, None, rng
    d = np.array([reflector_direction(0.0, *into)[1:] for _ in range(40_000)])
    number, _, _ = np.histogram2d(
        (d[:, :2] ** 2).sum(axis=1), np.arctan2(d[:, 1], d[:, 0]), (5, 8), ((0, 1), (-np.pi, np.pi))
    )
    within(number, 1000, np.sqrt(1000), 4.5)
    mirrored = reflector_direction(1.0, *into)
    assert mirrored == (True, 0.6, 0.0, 0.8)
