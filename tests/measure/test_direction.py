"""Measures over direction: the Lambertian panel, closed forms, and both ways of tracing flux."""

from dataclasses import replace

import numpy as np
import pytest
from harness import film_file, groove, within
from oracle.tracer import reflectance
from scipy.special import ndtr, stdtrit

from mpfcad.backlight import read_stack
from mpfcad.measure import (
    TraceRun,
    angular_luminance,
    camera_image,
    conoscope,
    light_film,
    output_flux,
    screen_uniformity,
)
from mpfcad.measure.angle.angular import ANGLES, peak, width
from mpfcad.measure.angle.conoscope import POLAR, exitance_weight
from mpfcad.measure.draw import estimate_by_draws
from mpfcad.measure.rounds import trace_rounds
from mpfcad.optics.element import Film, Slab
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    path = film_file(tmp_path_factory.mktemp("film") / "film.stl", [groove(60.0)] * 20, base=0.2)
    return light_film(read_stack("thesis-32in-mpf"), path)


@pytest.fixture(scope="module")
def lambertian(lit):
    # A film between radiances of 1 on both sides: radiance 1 in every direction, exactly.
    film = next(element for element in lit.elements if isinstance(element, Film))
    return replace(lit, elements=[film], scene=build_scene([film], below=1.0, above=1.0))


def test_a_lambertian_panel_is_equally_bright_in_all_directions(lambertian):
    run = TraceRun()
    angular = angular_luminance(lambertian, run, 0.01)
    for curve in (angular.across, angular.along):
        assert (curve.luminance == 1).all() and (curve.standard_error == 0).all()
        # It never falls to a half or a third: it has no width.
        assert curve.fwhm is None and curve.third is None
    found = conoscope(lambertian, run, 0.01)
    assert (found.luminance == 1).all()
    assert found.exitance.value == pytest.approx(np.pi, rel=2e-5)
    assert found.exitance.standard_error == 0


def test_a_lambertian_panel_is_uniform(lambertian):
    run = TraceRun()
    found = screen_uniformity(lambertian, run, 0.01)
    assert [value.value for value in found.uniformity.values()] == [1, 1, 1]
    image = camera_image(lambertian, run, 0.01)
    assert image.picture.shape == (200, 200) and (image.picture == 1).all()
    assert image.pixel == 1.0


def test_a_clear_plate_over_lambertian_light_in_closed_form(lambertian):
    # L(θ) = (1-R)/(1+R), and ∫ L cos θ dΩ = 0.8471 π (n = 1.49).
    plate = [Slab(1.49, 2.0)]
    lit = replace(lambertian, elements=plate, scene=build_scene(plate, below=1.0))
    found = conoscope(lit, TraceRun(seed=24), 0.02)
    r = np.array([reflectance(np.cos(angle), 1.0, 1.49) for angle in POLAR])
    exact = ((1 - r) / (1 + r))[:, None]
    # Within its own error everywhere, a point whose paths all got through excepted.
    away = np.abs(found.luminance - exact) / np.maximum(found.standard_error, 0.002)
    assert away.max() < 4.5
    within(found.exitance.value, 0.8471 * np.pi, found.exitance.standard_error, 3)
    source = Source(EYE, np.zeros(1), 0.05, acceptance=1.0)
    tally = trace_rounds(lit, source, TraceRun(), lambda t: float(t.radiance_error[0]), 0.002, "{}")
    within(tally.radiance[0], 0.8471, tally.radiance_error[0], 3)


def test_flux_forward_backward_and_by_the_conoscope_agree(lit):
    run = TraceRun(seed=21)
    flux = output_flux(lit, run, 0.004)
    assert abs(flux.disagreement) < 3
    assert 0.5 < flux.efficiency.value < 0.8
    assert flux.efficiency.standard_error <= 0.004 * flux.efficiency.value
    found = conoscope(lit, run, 0.04)
    error = np.hypot(found.exitance.standard_error, flux.exitance.standard_error)
    within(found.exitance.value, flux.exitance.value, error, 3)
    # lm of the panel over lm/m²: its area.
    stack = lit.stack
    area = stack.source.count * stack.period.across * stack.panel_length * 1e-6
    assert flux.flux.value / flux.exitance.value == pytest.approx(area)


def test_the_map_and_the_curves_are_one(lit):
    run = TraceRun(seed=22)
    angular, found = angular_luminance(lit, run, 0.02), conoscope(lit, run, 0.05)
    middle = len(ANGLES) // 2
    for curve, spokes in ((angular.across, (0, 12)), (angular.along, (6, 18))):
        for spoke, side in zip(spokes, (1, -1), strict=True):
            at = [middle + side * i for i in range(1, 17)]
            error = np.hypot(curve.standard_error[at], found.standard_error[1:17, spoke])
            away = (curve.luminance[at] - found.luminance[1:17, spoke]) / error
            # 64 comparisons, as improbable as 4 sigma each: Student's t of 7 degrees.
            assert np.abs(away).max() < stdtrit(7, ndtr(4))


def test_the_picture_is_symmetric_about_the_middle_between_lamps(lit):
    image = camera_image(lit, TraceRun(seed=23), 0.04)
    value, error = image.luminance[:, 0], image.standard_error[:, 0]
    half = value[:100], value[:99:-1]
    errors = error[:100], error[:99:-1]
    away = (half[0] - half[1]) / np.hypot(*errors)
    # χ² of 100: 100 ± √200, 4 sigma.
    assert abs((away**2).sum() - 100) < 4 * np.sqrt(200)


def cosine_power(power):
    return np.cos(ANGLES) ** power


@pytest.mark.parametrize("power", [1, 2, 5, 20])
def test_widths_of_powers_of_the_cosine(power):
    # cosⁿ falls to 1/k at acos(k^(-1/n)).
    curve = cosine_power(power)
    for share in (2, 3):
        exact = 2 * np.arccos(share ** (-1 / power))
        # Straight between points 5° apart: h²/8 · |f''/f'|, below 0.15° for n = 20.
        assert width(ANGLES, curve, 1 / share) == pytest.approx(exact, abs=np.radians(0.3))
    # A parabola through five points h apart leaves 72/35 h⁴ of the fourth-order term at the top.
    fourth = power * (3 * power - 2) / 24
    left = 72 / 35 * np.radians(5) ** 4 * fourth
    assert peak(ANGLES, curve) == pytest.approx(1, abs=1.2 * left + 1e-9)


def test_widths_that_are_not_there_are_none():
    assert width(ANGLES, np.ones(33), 0.5) is None
    # Falls on one side only.
    assert width(ANGLES, np.linspace(1, 0.1, 33), 0.5) is None


def test_the_widths_interval_covers_and_has_no_bias():
    rng = np.random.default_rng(4)
    error = np.full(33, 0.01)
    found, inside = [], 0
    for _ in range(60):
        noisy = cosine_power(2) + rng.normal(size=33) * error
        estimate = estimate_by_draws(lambda v: width(ANGLES, v, peak(ANGLES, v) / 2), noisy, error)
        found.append(estimate.value)
        inside += estimate.low <= np.pi / 2 <= estimate.high
    spread = np.std(found) / np.sqrt(60)
    assert abs(np.mean(found) - np.pi / 2) < 3 * spread + np.radians(0.05)
    # 95 % of 60 is 57 ± 1.7.
    assert inside >= 51
    assert estimate.standard_error == pytest.approx(np.std(found), rel=0.35)


def test_rings_of_the_map():
    assert np.degrees(POLAR) == pytest.approx(np.arange(0, 90, 5))
    # ∫ cos θ · cos θ dΩ = 2π/3.
    weight = exitance_weight() * 24
    assert (weight * np.cos(POLAR)).sum() == pytest.approx(2 * np.pi / 3, rel=1e-4)
