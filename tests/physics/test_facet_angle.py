"""How far facets of finite angle, and places far from the origin, are off."""

import numpy as np
import pytest
from harness import groove

from mpfcad.cad import write_stl
from mpfcad.cad.shape.mesh import build_cross_section
from mpfcad.film import Groove, PrismFilm
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import Film, build_scene
from mpfcad.optics.solid.mesh import FilmMesh, read_film_mesh
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source
from mpfcad.units import deg


def extruded_film(x, z):
    n, a, length = len(x), np.arange(len(x) - 1), 2.0
    vertex = np.concatenate([np.c_[x, 0 * x, z], np.c_[x, 0 * x + length, z]])
    top = np.concatenate([np.c_[a, a + 1, a + 1 + n], np.c_[a, a + 1 + n, a + n]])
    return FilmMesh(vertex, top, (float(x[-1]), length, float(z.max())))


def seen(mesh, place, blocks):
    """Return the normal luminance over radiance 1 from below in 1 degree, and its error; seed 3."""
    scene = build_scene([Film(mesh, 1.55)], below=1.0)
    meter = Source(EYE, np.array([place]), 1.0, acceptance=0.017)
    tally = trace(scene, meter, blocks, seed=3)
    return float(tally.radiance[0]), float(tally.radiance_error[0])


def test_near_and_far_differ_by_less_than_1e_4():
    # Corners on a grid of 2⁻¹⁵ mm, grooves 2⁻⁴ mm apart: float32 holds them alike at 0 and 390 mm,
    # so that common random numbers (500,000 paths) leave what the tracer itself does there.
    step, pitch = 2.0**-15, 2.0**-4
    x, z = groove(60.0, chords=60)
    x = np.round(x * pitch / 0.05 / step) * step + pitch / 2
    z = np.round((z + 0.2) / step) * step
    count = 6256
    whole = (x[:-1] + pitch * np.arange(count)[:, None]).ravel()
    mesh = extruded_film(np.r_[whole, pitch * count], np.r_[np.tile(z[:-1], count), z[0]])
    near, far = (seen(mesh, place, 1000)[0] for place in (1.0, 390.0))
    assert abs(near - far) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("curvature", [60.0, 75.0])
def test_normal_luminance_converges_with_the_facet_angle(curvature):
    # Twenty million paths each, seed 3: the table of docs/tracing.md (`-s` prints it). The default,
    # 0.5 degrees, is within 0.1 % of facets four times finer, in 20 grooves and in those of a lamp
    # pitch, whose chords differ; halving again changes nothing.
    value = {}
    for angle, grooves in ((2, 20), (1, 20), (0.5, 20), (0.5, 654), (0.25, 20), (0.125, 20)):
        film = PrismFilm(Groove(0.05, 0.025), 0.2, 2.0, "filled", np.full(grooves, curvature))
        section = build_cross_section(film, angle * deg)
        x, z = section.x.astype(float), section.z.astype(float)
        got = value[angle, grooves] = seen(extruded_film(x, z), 0.5, 40_000)
        print(f"C {curvature:g}, {grooves} grooves, {angle:g} deg: {got[0]:.5f} ± {got[1]:.5f}")
    finer, finest = value[0.25, 20], value[0.125, 20]
    for default in (value[0.5, 20], value[0.5, 654]):
        assert abs(default[0] - finest[0]) < 1e-3
    assert abs(finer[0] - finest[0]) < 4 * np.hypot(finer[1], finest[1])


@pytest.mark.slow
@pytest.mark.parametrize("curvature", [60.0, 75.0])
def test_a_panel_from_its_stl_differs_by_less_than_1e_4_near_and_far(tmp_path, curvature):
    # Twenty million paths each in 20 batches of common random numbers, seed 3; the differences of
    # the batches give sigma, at most 3e-5. `-s` prints the table of docs/tracing.md.
    film = PrismFilm(Groove(0.05, 0.025), 0.2, 2.0, "filled", np.full(7846, curvature))
    write_stl(film, tmp_path / "film.stl", 0.5 * deg)
    scene = build_scene([Film(read_film_mesh(tmp_path / "film.stl"), 1.55)], below=1.0)
    for kind in (EYE, LAMBERTIAN_BELOW):
        batches = []
        for batch in range(20):
            value = []
            for place in (1.0, 390.0):
                source = Source(kind, np.array([place]), 1.0, acceptance=0.017)
                tally = trace(scene, source, 2000, seed=3, first=2000 * batch)
                value.append(tally.radiance[0] if kind == EYE else tally.fraction[0])
            batches.append(value)
        difference = -np.diff(batches, axis=1).ravel()
        sigma = difference.std() / np.sqrt(19)
        print(f"C {curvature:g}: {np.mean(batches):.5f}, {difference.mean():.2e} ± {sigma:.1e}")
        assert sigma < 3e-5
        assert abs(difference.mean()) < 1e-4
