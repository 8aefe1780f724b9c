"""Flat films and plates against the Fresnel slab in closed form; the ideal diffuser."""

import numpy as np
import pytest
from harness import film_mesh, groove, within
from oracle.ray import reflectance
from scipy.integrate import quad

from mpfcad.optics.element import Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source


def slab_transmittance(cosine, index):
    """Both faces with all reflections to and fro: (1-R)/(1+R)."""
    r = reflectance(cosine, 1.0, index)
    return (1 - r) / (1 + r)


def lambertian_transmittance(index):
    # ∫ T d(sin²θ): the mean over Lambertian light.
    return quad(lambda s: slab_transmittance(np.sqrt(1 - s), index), 0, 1, limit=200)[0]


def test_the_lambertian_slab_of_pmma_is_the_known_figure():
    assert lambertian_transmittance(1.49) == pytest.approx(0.8471, abs=5e-5)


@pytest.mark.parametrize("accelerator", ["chain", "bvh", "slab"])
@pytest.mark.parametrize("index", [1.49, 1.6])
def test_a_flat_film_is_a_fresnel_slab(tmp_path, index, accelerator):
    element = Slab(index, 2.0)
    if accelerator != "slab":
        element = Film(film_mesh(tmp_path, [groove(0.0)]), index, accelerator=accelerator)
    scene = build_scene([element], below=1.0)
    through = trace(scene, Source(LAMBERTIAN_BELOW, np.zeros(1), 0.05), 400, seed=11)
    within(through.fraction[0], lambertian_transmittance(index), through.fraction_error[0], 4)
    for sine in (0.0, 0.5, 0.9):
        seen = trace(
            scene, Source(EYE, np.zeros(1), 0.05, tilt_x=0.6 * sine, tilt_y=0.8 * sine), 200
        )
        expected = slab_transmittance(np.sqrt(1 - sine**2), index)
        within(seen.radiance[0], expected, seen.radiance_error[0], 4, f"sine {sine}")


def test_absorption_follows_lambert_and_beer():
    # At normal incidence a path crosses once, thrice, five times …: T = (1-R)² a / (1 - R² a²).
    index, thickness, absorption = 1.49, 2.0, 0.2
    scene = build_scene([Slab(index, thickness, 0.0, absorption)], below=1.0)
    r, a = ((index - 1) / (index + 1)) ** 2, np.exp(-absorption * thickness)
    seen = trace(scene, Source(EYE, np.zeros(1), 1.0), 400, seed=12)
    within(seen.radiance[0], (1 - r) ** 2 * a / (1 - r * r * a * a), seen.radiance_error[0], 4)


def test_a_dense_plate_is_opaque_and_loses_nothing():
    scene = build_scene([Slab(1.49, 2.0, 50.0, 0.0, 0.0)], below=1.0)
    tally = trace(scene, Source(LAMBERTIAN_BELOW, np.zeros(1), 1.0), 40, seed=13)
    assert tally.fraction[:3].sum() == pytest.approx(1, abs=1e-12)
    assert 0.005 < tally.fraction[0] < 0.05


def test_a_sheet_that_moves_nothing_is_a_slab():
    scene = build_scene([Sheet(0.0, 1.49, 1.0)], below=1.0)
    tally = trace(scene, Source(LAMBERTIAN_BELOW, np.zeros(1), 1.0), 400, seed=14)
    within(tally.fraction[0], lambertian_transmittance(1.49), tally.fraction_error[0], 4)


def test_the_sheets_transmit_what_their_values_promise():
    # 0.88 of normal and 0.61 of Lambertian light (assumed values of the 32-inch backlight), both
    # figures rounded to two digits.
    scene = build_scene([Sheet(0.36, 1.49, 0.98)], below=1.0)
    normal = trace(scene, Source(EYE, np.zeros(1), 1.0), 200, seed=15)
    assert normal.radiance[0] == pytest.approx(0.88, abs=0.005 + 3 * normal.radiance_error[0])
    broad = trace(scene, Source(LAMBERTIAN_BELOW, np.zeros(1), 1.0), 200, seed=15)
    assert broad.fraction[0] == pytest.approx(0.61, abs=0.005 + 3 * broad.fraction_error[0])
