"""A birefringent base: closed forms of a uniaxial plate, and the stack that states it."""

import math

import numpy as np
import pytest
from harness import BARE, film_file, polarised_paths

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import light_film
from mpfcad.optics.element import Slab
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.stokes.plane import PlaneLayer

LINEAR = PlaneLayer(0.0, (1.0, 0.0))


def seen(elements, tilt=(0.0, 0.0)):
    """Return I, Q, U, V of light of 1 from below that a single path sees."""
    scene = build_scene(elements, below=1.0, polarised=True)
    return polarised_paths(scene, Source(EYE, [0.0], 0.0, *tilt), 1, 1)[0]


@pytest.mark.parametrize("axis", [0.3, math.pi / 4, -1.1])
@pytest.mark.parametrize("phase", [0.2, math.pi / 2, 4.0])
def test_along_the_normal_it_is_a_retarder(axis, phase):
    plate = Slab(1.0, 0.1, delay=phase / 0.1, axis=axis)
    found = seen([LINEAR, plate])
    np.testing.assert_allclose(
        found, seen([LINEAR, PlaneLayer(axis, retardation=phase)]), atol=1e-13
    )
    # Mueller's matrix of a retarder on light along y (Collett, 1993).
    c, s = math.cos(2 * axis), math.sin(2 * axis)
    expected_q = c * c + s * s * math.cos(phase)
    expected_u = c * s * (1 - math.cos(phase))
    assert found[0] == pytest.approx(0.5, abs=1e-13)
    assert found[1] == pytest.approx(0.5 * expected_q, abs=1e-13)
    assert abs(found[2]) == pytest.approx(abs(0.5 * expected_u), abs=1e-13)
    assert abs(found[3]) == pytest.approx(abs(0.5 * s * math.sin(phase)), abs=1e-13)


@pytest.mark.parametrize("order", [0.25, 1.0, 2.5])
def test_between_crossed_polarisers_it_passes_sine_squared(order):
    plate = Slab(1.0, 0.05, delay=2 * math.pi * order / 0.05, axis=math.pi / 4)
    crossed = PlaneLayer(math.pi / 2, (1.0, 0.0))
    expected = 0.5 * math.sin(math.pi * order) ** 2
    assert seen([LINEAR, plate, crossed])[0] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("azimuth", [0.0, 0.7, 1.3, math.pi / 2])
@pytest.mark.parametrize("polar", [0.3, 0.9, 1.2])
def test_aslant_it_delays_as_the_waves_of_maxwell(polar, azimuth):
    """Both waves' components along the normal, from the surfaces of wave vectors (Yeh, 1979).

    The plate lies amid a medium of its ordinary index, 1 here, so that the ray is not bent. An
    index of 1 + Δn has the phase Γ = 2π d/λ (k_e - k_o); ours is the first order in Δn.
    """
    ordinary, birefringence, thickness, wavelength = 1.0, 1e-4, 0.1, 550e-6
    extraordinary = ordinary + birefringence
    axis = 0.4
    o = np.array([-math.sin(axis), math.cos(axis)])
    k = math.sin(polar) * np.array([math.cos(azimuth), math.sin(azimuth)])
    along, square = k @ o, k @ k
    k_o = math.sqrt(ordinary**2 - square)
    k_e = math.sqrt(extraordinary**2 * (1 - along**2 / ordinary**2) - (square - along**2))
    exact = 2 * math.pi * thickness / wavelength * (k_e - k_o)
    rate = 2 * math.pi * birefringence / wavelength
    # The path's own phase, read from the circular part that it gives to light at 45° to its axes.
    plate = Slab(1.0, thickness, delay=rate, axis=axis)
    tilt = tuple(-k)
    best = max(
        (abs(seen([PlaneLayer(a, (1.0, 0.0)), plate], tilt)[3]) for a in np.linspace(0, 3.1, 63)),
    )
    # Largest over the polariser's angle: ½ |sin Γ| of the I that is left.
    assert best == pytest.approx(0.5 * abs(math.sin(exact)), rel=4e-3, abs=1e-6)


BASE = "film_base_index = 1.64\nfilm_base_thickness_um = 125\n"


def stack(folder, value, polarised=True):
    path = folder / "stack.toml"
    light = "[light]\npolarised = true\n" if polarised else ""
    path.write_text(f'extends = "thesis-32in-mpf"\n{light}[value]\n{value}')
    return path


def test_a_stack_states_a_birefringent_base(tmp_path):
    value = f"{BASE}film_base_retardation_nm = 2750\nfilm_base_axis_deg = 30\n"
    mesh = film_file(tmp_path / "film.stl", [BARE] * 4, length=2.0)
    lit = light_film(read_stack(stack(tmp_path, value)), mesh)
    base = next(one for one in lit.elements if one.name == "film base")
    assert base.delay * base.thickness == pytest.approx(2 * math.pi * 5)
    assert base.axis == pytest.approx(math.pi / 6)


@pytest.mark.parametrize(
    ("value", "polarised", "message"),
    [
        (f"{BASE}film_base_retardation_nm = 100\n", False,
         r"film_base_retardation_nm: needs light\.polarised"),
        (f"{BASE}film_base_axis_deg = 30\n", True,
         r"film_base_retardation_nm: missing: expected with film_base_axis_deg"),
        ("film_base_retardation_nm = 100\n", True, r"film_base_index: missing: expected with"),
        (f"{BASE}film_base_retardation_nm = -1\n", True, r"retardation_nm: -1: expected a number"),
    ],
)  # fmt: skip
def test_wrong_bases_are_refused(tmp_path, value, polarised, message):
    with pytest.raises(InputError, match=message):
        read_stack(stack(tmp_path, value, polarised))
