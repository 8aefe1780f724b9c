"""Mie's theory against closed forms and published figures; phase functions drawn as tabulated."""

import numpy as np
import pytest
from harness import compiled

from mpfcad.backlight import read_stack
from mpfcad.backlight.particle import Particles
from mpfcad.errors import InputError
from mpfcad.optics.base import phase
from mpfcad.optics.base.phase import STEPS, phase_quantiles

scattering_cosine = compiled(phase.scattering_cosine)


def sphere(size, ratio, density=1e5):
    """Return spheres of size parameter `size` in a medium of index 1.5, light of 550 nm."""
    wavelength = 550e-6
    return Particles(size * wavelength / (2 * np.pi * 1.5), ratio * 1.5, 1.5, density, wavelength)


def test_a_sphere_of_bohren_and_huffmans_appendix():
    # n = 1.55, radius 0.525 µm, wavelength 0.6328 µm in vacuum: Q = 3.10543; g = 0.63314.
    particles = Particles(0.525e-3, 1.55, 1.0, 1.0, 0.6328e-3)
    assert particles.size == pytest.approx(5.213, abs=5e-4)
    assert particles.efficiency == pytest.approx(3.10543, abs=2e-5)
    assert particles.asymmetry == pytest.approx(0.63314, abs=2e-5)


@pytest.mark.parametrize("ratio", [1.05, 1.33, 0.9])
def test_small_spheres_scatter_as_rayleigh_says(ratio):
    # Q = 8/3 x⁴ ((m²-1)/(m²+2))², g = 0, phase function ∝ 1 + cos².
    size = 0.02
    expected = 8 / 3 * size**4 * ((ratio**2 - 1) / (ratio**2 + 2)) ** 2
    particles = sphere(size, ratio)
    assert particles.efficiency == pytest.approx(expected, rel=1e-3)
    assert abs(particles.asymmetry) < 1e-3
    cosine = np.linspace(-1, 1, 2001)
    assert np.abs(particles.phase() - phase_quantiles(cosine, 1 + cosine**2)).max() < 1e-3


def test_weak_small_contrast_is_rayleigh_gans():
    # |m-1| << 1 and x |m-1| << 1: Q = x²|m-1|² φ(x); for large x it tends to 2 x² (m-1)².
    particles = sphere(30.0, 1.0005)
    assert particles.efficiency == pytest.approx(2 * 30**2 * 0.0005**2, rel=0.01)


def test_large_spheres_take_twice_the_light_that_falls_on_them():
    # The extinction paradox: Q tends to 2, above it by about x^(-2/3).
    sizes = np.linspace(900, 1100, 41)
    mean = np.mean([sphere(x, 1.2).efficiency for x in sizes])
    assert 2.0 < mean < 2.0 + 3 * 1000 ** (-2 / 3)


def test_a_sphere_of_the_mediums_index_scatters_nothing():
    assert sphere(20.0, 1.0).scattering == 0


def test_the_coefficient_is_density_times_cross_section():
    particles = Particles(2e-3, 1.43, 1.55, 1e5, 550e-6)
    expected = 1e5 * np.pi * 4e-6 * particles.efficiency
    assert particles.scattering == pytest.approx(expected)


@pytest.mark.parametrize("size", [0.5, 5.0, 90.0])
def test_cosines_drawn_from_the_table_have_the_asymmetry(size):
    particles = sphere(size, 1.1)
    row = particles.phase()
    assert (np.diff(row) >= 0).all() and row[0] == -1 and row[-1] == 1
    mean = (row[1:] + row[:-1]).mean() / 2
    assert mean == pytest.approx(particles.asymmetry, abs=2e-3)
    u = (np.arange(3000) + 0.5) / 3000
    drawn = np.array([scattering_cosine(row[None], 0, 0.0, v) for v in u])
    assert drawn.mean() == pytest.approx(mean, abs=1e-3)


def test_a_table_of_henyey_and_greensteins_function_is_the_function():
    g = 0.7
    cosine = np.cos(np.linspace(np.pi, 0, 20_001))
    row = phase_quantiles(cosine, (1 + g * g - 2 * g * cosine) ** -1.5)
    u = np.arange(0, STEPS, 37) / STEPS
    exact = [scattering_cosine(row[None], -1, g, v) for v in u]
    assert np.abs([scattering_cosine(row[None], 0, 0.0, v) for v in u] - np.array(exact)).max() < (
        1e-5
    )


def test_particles_of_the_stack_take_the_place_of_coefficients():
    over = {
        "plate_particle_radius_um": 2.0,
        "plate_particle_index": 1.43,
        "plate_particle_density_per_mm3": 5e4,
    }
    stack = read_stack("thesis-32in-conventional", overrides=over)
    particles = Particles(2e-3, 1.43, 1.49, 5e4, 550e-6)
    assert stack["plate_scattering_per_mm"] == pytest.approx(particles.scattering)
    assert stack["plate_asymmetry"] == pytest.approx(particles.asymmetry)
    entry = next(e for e in stack.inputs() if e["name"] == "plate_scattering_per_mm")
    assert entry["tag"] == "given" or "Mie" in entry["source"]
    assert {*over, "light_wavelength_nm"} <= {e["name"] for e in stack.inputs()}
    with pytest.raises(InputError, match="plate_particle_index"):
        read_stack("thesis-32in-conventional", overrides={"plate_particle_radius_um": 2.0})
