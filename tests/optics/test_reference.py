"""The kernels against the plain-Python oracle, path by path on the same random numbers."""

from dataclasses import replace

import numpy as np
import pytest
from harness import (
    BARE,
    SECTIONS,
    crossed_mesh,
    film_mesh,
    groove,
    section_mesh,
    single_paths,
)
from oracle.tracer import Philox, ReferenceTracer

from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
CLEAR = Slab(1.49, 2.0)
DIFFUSING = Slab(1.49, 2.0, 0.6, 0.0036, 0.8)
GROOVED = Slab(1.49, 2.0, 0.6, 0.0036, 0.8, bonded=True)
BOTTOM, TOP = Sheet(0.36, 1.49, 0.98), Sheet(0.35, 1.49, 0.98)
MIXED = [groove(60.0, chords=6), groove(45.0, chords=6)]


def stack(name, folder, accelerator=None):
    if name == "conventional":
        mesh = film_mesh(folder, [BARE] * 2)
        return [CAVITY, DIFFUSING, BOTTOM, Film(mesh, 1.55, accelerator=accelerator), TOP]
    mesh = film_mesh(folder, MIXED)
    if name == "mpf":
        film = Film(mesh, 1.55, offset=0.013, accelerator=accelerator)
        return [CAVITY, CLEAR, BOTTOM, film, TOP]
    return [CAVITY, GROOVED, Film(mesh, 1.55, 1.49, accelerator=accelerator), TOP]


@pytest.mark.parametrize("name", SECTIONS)
def test_undercuts_and_several_bodies_equal_the_oracle(tmp_path, name):
    film = Film(section_mesh(tmp_path, name), 1.55, offset=0.013)
    compare([Film(film_mesh(tmp_path, MIXED), 1.5), BOTTOM, film], 30, below=1.0)


def both(elements, count, first=0, below=0.0, tilt=(0.0, 0.0), acceptance=0.5):
    """Return the radiance of paths by the engine and by the oracle, and of one of the oracle's."""
    scene = build_scene(elements, below=below)
    source = Source(EYE, np.array([0.1]), 0.05, *tilt, acceptance, along=0.3, spot_along=0.01)
    engine = np.empty(count)
    single_paths(scene, source, 1, first, engine, np.zeros(len(FLOWS) + len(elements)))
    oracle = ReferenceTracer(elements, below=below)

    def alone(path, x=0.1, y=0.3):
        random = Philox(1, EYE, int(path), 1)
        return oracle.radiance(x, 0.05, acceptance, random, y=y, tilt=tilt, spot_along=0.01)

    expected = np.array([alone(path) for path in range(first, first + count)])
    assert expected.any()
    return engine, expected, alone


def compare(elements, count, grown=0.0, **more):
    engine, expected, _ = both(elements, count, **more)
    away = np.abs(engine - expected) / expected.max()
    assert np.mean(away > 1e-9) <= grown, np.flatnonzero(away > 1e-9)
    assert not (away > 1e-6).any(), np.flatnonzero(away > 1e-6)


@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
@pytest.mark.parametrize("name", ["conventional", "mpf", "mpf-plate"])
def test_paths_equal_the_oracle(tmp_path, name, accelerator):
    # What a lamp gives directly varies with the place, so a path shows the last-bit differences
    # that grow 10…100 times at each lamp it meets: at most one here, and no more than a millionth.
    compare(stack(name, tmp_path, accelerator), 60, grown=1 / 60)


@pytest.mark.parametrize(
    "layers", [[], [CLEAR], [DIFFUSING], [BOTTOM], [DIFFUSING, BOTTOM, TOP]], ids=len
)
def test_layers_without_film_equal_the_oracle(layers):
    compare([CAVITY, *layers], 300)


def test_sheets_with_other_lobes_equal_the_oracle():
    askew = Sheet(0.3, 1.49, 0.98, sigma_across=0.06, axis=0.7)
    haze = Sheet(0.02, 1.49, 0.98, wide_sigma=0.4, wide_share=0.3)
    both_of_them = replace(askew, axis=-2.0, wide_sigma=0.2, wide_share=0.5)
    compare([CAVITY, DIFFUSING, askew, haze, both_of_them], 300)


@pytest.mark.parametrize("accelerator", ["grid", "bvh"])
def test_a_film_that_is_no_extrusion_equals_the_oracle(tmp_path, accelerator):
    compare([Film(crossed_mesh(tmp_path), 1.5, accelerator=accelerator)], 250, below=1.0)


@pytest.mark.parametrize("tilt", [(0.3, 0.0), (-0.5, 0.7), (0.0, -0.95)])
def test_a_tilted_meter_equals_the_oracle(tmp_path, tilt):
    compare([Film(crossed_mesh(tmp_path), 1.5)], 150, below=1.0, tilt=tilt, acceptance=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["conventional", "mpf", "mpf-plate"])
def test_many_paths_equal_the_oracle(tmp_path, name):
    # A lamp is a convex mirror of 1.7 mm radius: a last-bit difference in place grows 10…100 times
    # at each. So a path may differ as much as from itself where the oracle's meter is moved by
    # 1e-12 mm, 300 times the rounding of a place 20 mm up. What rounding does along the path, the
    # start does not always tell: 3 of 800 may differ by more.
    first = 60
    engine, expected, alone = both(stack(name, tmp_path), 800, first=first)
    away = np.abs(engine - expected) / expected.max()
    moved = np.full(len(away), 1e-9)
    for i in np.flatnonzero(away > 1e-9):
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            seen = alone(first + i, 0.1 + dx * 1e-12, 0.3 + dy * 1e-12)
            moved[i] = max(moved[i], abs(seen - expected[i]) / expected.max())
    print(f"{name}: {np.sum(away > 1e-9)} above 1e-9, largest {away.max():.1e}")
    assert np.sum(away > moved) <= 3, first + np.flatnonzero(away > moved)
