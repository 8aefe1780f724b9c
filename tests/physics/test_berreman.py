"""Plates, piles of plates, retarders and polarisers beside waves of Maxwell's equations (Berreman).

Every element is seen at 0 … 80° in four planes, by its I, Q, U and V.
"""

import math

import numpy as np
import pytest
from berreman import WAVELENGTH, Layer, as_seen, pile, stokes
from harness import within

from mpfcad.optics.element import Slab
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.stokes.engine import trace_stokes
from mpfcad.optics.stokes.plane import PlaneLayer

#: Δn so small that the engine's first order in it is exact to what the tests compare. Plates of
#: half a metre then delay by one wavelength.
BIREFRINGENCE = 1e-6
#: Its part in a comparison: faces reflect Δn more, phases differ by Δn of themselves.
FIRST_ORDER = 2e-4
DIRECTIONS = [
    np.array([math.sin(p) * math.cos(a), math.sin(p) * math.sin(a), math.cos(p)])
    for p in np.radians([0.0, 20.0, 40.0, 60.0, 80.0])
    for a in np.radians([0.0, 35.0, 90.0, 160.0])
]


def uniaxial(index, thickness, axis, **more):
    """Return the engine's plate and Berreman's."""
    rate = 2 * math.pi * BIREFRINGENCE / WAVELENGTH
    plate = Slab(index, thickness, delay=rate, axis=axis, **more)
    return plate, Layer(index, thickness, index + BIREFRINGENCE, axis)


def linear(k, axis):
    """Return the field of light that an ideal polariser passes of unpolarised light of 1."""
    passed = np.cross(k, [math.cos(axis), math.sin(axis), 0.0])
    return passed / np.linalg.norm(passed) / math.sqrt(2)


def elliptic(k, axis, slow, phase):
    """Return the field behind a polariser and a thin retarder."""
    late = linear(k, slow) * math.sqrt(2)
    field = linear(k, axis)
    return field + (np.exp(1j * phase) - 1) * (late @ field) * late


#: What the light below passes first, and its field.
LIGHT = {
    "unpolarised": ([], lambda k: None),
    "linear": ([PlaneLayer(0.3, (1.0, 0.0))], lambda k: linear(k, 0.3)),
    "elliptic": (
        [PlaneLayer(0.3, (1.0, 0.0)), PlaneLayer(1.0, retardation=1.2)],
        lambda k: elliptic(k, 0.3, 1.0, 1.2),
    ),
}


def compare(elements, plates, light="unpolarised", blocks=12, back=False, directions=DIRECTIONS):
    """Compare what a meter sees from every direction, each within 4.5 standard errors.

    `back`: of light from above, what is reflected.
    """
    first, field = LIGHT[light]
    scene = build_scene([*first, *elements], polarised=True, **{"above" if back else "below": 1.0})
    found, error, expected = [], [], []
    for k in directions:
        seen = trace_stokes(scene, Source(EYE, [0.1], 0.05, *-k[:2]), blocks, seed=9)[:, 0]
        found.append(seen.mean(axis=0))
        error.append(seen.std(axis=0, ddof=1) / math.sqrt(blocks))
        comes = np.array([1.0, 0, 0, 0]) if field(k) is None else stokes(field(k), k)
        expected.append(as_seen(pile(plates, k)[back] @ comes, k))
    error = np.hypot(error, FIRST_ORDER)
    within(np.array(found), np.array(expected), error, 4.5)
    away = ((np.array(found) - expected) / error) ** 2
    # χ² over n values has the mean n and the variance 2 n; what is known exactly counts less.
    assert away.sum() < away.size + 4 * math.sqrt(2 * away.size)


@pytest.mark.parametrize("light", LIGHT)
def test_a_thick_uniaxial_plate_passes_light(light):
    plate, layer = uniaxial(1.6, 900.0, 0.5)
    compare([plate], [[layer]], light)


def test_a_thick_uniaxial_plate_reflects_light():
    plate, layer = uniaxial(1.6, 900.0, 0.5)
    compare([plate], [[layer]], back=True)


@pytest.mark.parametrize("light", LIGHT)
def test_a_pile_of_unlike_plates_passes_light(light):
    lower, first = uniaxial(1.65, 700.0, -0.9)
    upper, last = uniaxial(1.55, 400.0, 0.2)
    compare([lower, Slab(1.5, 1.0), upper], [[first], [Layer(1.5, 1.0)], [last]], light)


def test_a_pile_of_unlike_plates_reflects_light():
    lower, first = uniaxial(1.65, 700.0, -0.9)
    compare([lower, Slab(1.5, 1.0)], [[first], [Layer(1.5, 1.0)]], back=True)


@pytest.mark.parametrize("light", LIGHT)
def test_plates_bonded_on_each_other(light):
    lower, first = uniaxial(1.65, 600.0, 0.4, bonded=True)
    upper, second = uniaxial(1.5, 350.0, -0.7, index_below=1.65)
    compare([lower, upper], [[first, second]], light)


@pytest.mark.parametrize("light", ["linear", "elliptic"])
def test_retarders_in_a_medium_of_their_index(light):
    # Two that are crossed obliquely, so that their order counts.
    pairs = [uniaxial(1.0, 300.0, 0.9), uniaxial(1.0, 500.0, -0.4)]
    elements, layers = map(list, zip(*pairs, strict=True))
    compare(elements, [layers], light, blocks=2)


@pytest.mark.parametrize("light", ["linear", "elliptic"])
def test_a_thin_retarder_along_the_normal(light):
    _, layer = uniaxial(1.0, 300.0, 0.9)
    phase = 2 * math.pi * BIREFRINGENCE / WAVELENGTH * layer.thickness
    up = DIRECTIONS[:1]
    compare([PlaneLayer(0.9, retardation=phase)], [[layer]], light, blocks=2, directions=up)


@pytest.mark.parametrize("light", LIGHT)
@pytest.mark.parametrize("axis", [0.0, 0.8])
def test_a_polariser_passes_the_ordinary_wave_of_what_absorbs_along_an_axis(light, axis):
    # Index 1 and 1 + i κ, so thick that e⁻²⁴ of the extraordinary wave is left.
    kappa, along = 1e-6, np.array([math.cos(axis), math.sin(axis), 0.0])
    for k in DIRECTIONS:
        rate = 2 * math.pi * kappa / WAVELENGTH * (1 - (k @ along) ** 2) / k[2]
        layer = Layer(1.0, 12.0 / rate, 1.0 + 1j * kappa, axis - math.pi / 2, thick=False)
        sheet = PlaneLayer(axis, (1.0, 0.0))
        compare([sheet], [[layer]], light, blocks=2, directions=[k])
