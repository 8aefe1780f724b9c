"""Derivatives by score functions: closed forms, the furnace, finite differences, the oracle."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from harness import film_mesh, groove
from oracle.tracer import Philox, ReferenceTracer
from scipy.integrate import dblquad, quad
from scipy.special import expn

from mpfcad.errors import TraceError
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.caught import NO_NET
from mpfcad.optics.cavity import endless
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.score.columns import Columns, direction
from mpfcad.optics.score.engine import trace_scores, trace_slopes
from mpfcad.optics.score.state import Score
from mpfcad.optics.score.tally import SlopeTally
from mpfcad.optics.source import EYE, LAMPS, Source
from mpfcad.optics.wave import SLOTS, Wave

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
#: A reflector alone: its only lamp is far away and gives no light.
FLOOR = Cavity(20.0, 1e6, 5e5, 3.5, 0.01, 0.0, 0.75, 0.94, 0.3)
EYES = Source(EYE, np.linspace(0, 32.69, 3), 1.0, acceptance=0.017)
UPRIGHT = Source(EYE, [0.0], 1.0)


def slopes(elements, values, source=EYES, blocks=20, **more):
    """Return the mean derivative over the points and its error, by (element, column name) each."""
    scene = build_scene(elements, **more)
    columns = Columns.of(scene)
    rows = np.zeros((len(values), len(columns.known)))
    for row, by in zip(rows, values, strict=True):
        for e, name in by:
            row += _along(elements, e, name, columns)
    tally = trace_slopes(scene, source, blocks, rows, seed=3)
    error = np.sqrt(tally.covariance[:, :, 1, 1].sum(axis=1)) / len(source.position)
    return tally, tally.slope.mean(axis=1), error


def _along(elements, e, name, columns):
    low, high = (changed(elements, e, name, by) for by in (-1e-4, 1e-4))
    found = direction(columns, low, high, 2e-4)
    assert found is not None
    return found


def changed(elements, e, name, by):
    one = replace(elements[e], **{name: getattr(elements[e], name) + by})
    return [*elements[:e], one, *elements[e + 1 :]]


def near(found, error, expected, relative=0.01):
    assert abs(found - expected) < 4 * error + 1e-9 * abs(expected)
    # The trace tells it well enough for this to be a test.
    assert error < max(relative * abs(expected), 1e-9)


def full(tmp_path):
    film = Film(film_mesh(tmp_path, [groove(57.0), groove(40.0)]), 1.55, absorption=0.02)
    bottom = Sheet(0.36, 1.49, 0.98, wide_sigma=0.6, wide_share=0.2)
    top = Sheet(0.35, 1.49, 0.97, sigma_across=0.2, axis=0.3)
    return [CAVITY, Slab(1.49, 2.0, 0.4, 0.01, 0.6), bottom, film, top]


def test_the_light_is_that_of_the_plain_trace(tmp_path):
    scene = build_scene(full(tmp_path))
    tally = trace_slopes(scene, EYES, 3, np.zeros((1, len(Columns.of(scene).known))), seed=5)
    assert np.array_equal(tally.light, trace(scene, EYES, 3, seed=5).radiance)


def test_same_bits_at_any_number_of_threads_and_in_parts(tmp_path):
    scene = build_scene(full(tmp_path))
    rows = np.eye(len(Columns.of(scene).known))[Columns.of(scene).known]
    one = trace_slopes(scene, EYES, 4, rows, seed=5)
    assert all(
        np.array_equal(a, b)
        for a, b in zip(one, trace_slopes(scene, EYES, 4, rows, seed=5, threads=3), strict=True)
    )
    parts = SlopeTally.empty(3, len(rows))
    for first in range(4):
        parts = parts + trace_slopes(scene, EYES, 1, rows, seed=5, first=first)
    assert all(np.array_equal(a, b) for a, b in zip(one, parts, strict=True))


def test_two_sheets_are_a_geometric_series():
    # Along the normal, without scattering: L = T₁T₂ t² / (1 - T₁T₂ r²), r = 1 - t.
    t1, t2, n = 0.9, 0.8, 1.6
    r = 1 - 2 * n / (n * n + 1)
    rest = 1 - t1 * t2 * r * r
    sheets = [Sheet(0.0, n, t1), Sheet(0.0, n, t2)]
    by = [[(0, "transmission")], [(1, "transmission")], [(0, "index"), (1, "index")]]
    _, found, error = slopes(sheets, by, UPRIGHT, below=1.0)
    by_t = -2 * t1 * t2 * (1 - r) * (1 - t1 * t2 * r) / rest**2
    by_n = by_t * 2 * (n * n - 1) / (n * n + 1) ** 2
    near(found[0], error[0], t2 * (1 - r) ** 2 / rest**2)
    near(found[1], error[1], t1 * (1 - r) ** 2 / rest**2)
    near(found[2], error[2], by_n, 0.05)


def test_a_reflector_under_a_sheet_is_a_geometric_series():
    # A mirror of reflectance ρ seen through T, t under a sky of 1: Tr + T²t²ρ/(1 - ρTr).
    t, n, rho = 0.9, 1.8, 0.7
    r = 1 - 2 * n / (n * n + 1)
    mirror = replace(FLOOR, reflectance=rho, specular_fraction=1.0)
    _, found, error = slopes([mirror, Sheet(0.0, n, t)], [[(0, "reflectance")]], UPRIGHT, above=1.0)
    near(found[0], error[0], (t * (1 - r)) ** 2 / (1 - rho * t * r) ** 2)


def test_an_absorber_over_a_reflector_tells_the_mirrored_share():
    # L = ρ e^-τ (s e^-τ + (1-s) 2E₃(τ)).
    tau, s, rho = 0.3, 0.3, 0.94
    mirrored, diffuse = math.exp(-tau), 2 * expn(3, tau)
    _, found, error = slopes(
        [FLOOR, Slab(1.0, 1.0, absorption=tau)],
        [[(0, "specular_fraction")], [(1, "absorption")], [(0, "reflectance")]],
        UPRIGHT, above=1.0,
    )  # fmt: skip
    near(found[0], error[0], rho * mirrored * (mirrored - diffuse), 0.02)
    by_tau = -2 * s * mirrored**2 - (1 - s) * mirrored * (diffuse + 2 * expn(2, tau))
    near(found[1], error[1], rho * by_tau)
    near(found[2], error[2], mirrored * (s * mirrored + (1 - s) * diffuse))


def test_a_deep_plate_follows_chandrasekhar():
    # Plane albedo of a half-space along the normal: 1 - √(1-ω) H(1), isotropic scattering
    # (Chandrasekhar, "Radiative transfer", 1950).
    scattering, absorption = 1.0, 0.3

    def albedo(s, a):
        omega = s / (s + a)
        node, weight = np.polynomial.legendre.leggauss(64)
        mu, weight = (node + 1) / 2, weight / 2
        h, one = np.ones(64), None
        for _ in range(300):
            part = omega / 2 * weight * h
            kernel = mu / (mu[:, None] + mu)
            h = 1 / (math.sqrt(1 - omega) + kernel @ part)
            one = 1 / (math.sqrt(1 - omega) + np.sum(mu / (1 + mu) * part))
        return 1 - math.sqrt(1 - omega) * one

    step = 1e-4
    by_s = (albedo(scattering + step, absorption) - albedo(scattering - step, absorption)) / step
    by_a = (albedo(scattering, absorption + step) - albedo(scattering, absorption - step)) / step
    plate = Slab(1.0, 30.0, scattering, absorption)
    tally, found, error = slopes(
        [plate], [[(0, "scattering")], [(0, "absorption")]], UPRIGHT, 40, above=1.0
    )
    assert tally.light[0] == pytest.approx(albedo(scattering, absorption), rel=0.01)
    near(found[0], error[0], by_s / 2, 0.06)
    near(found[1], error[1], by_a / 2, 0.02)


def test_a_thin_plate_scatters_once_by_its_asymmetry():
    # Under a sky of 1 a plate without surfaces sends back τ ∫ p(μ) of what its first scattering
    # turns round, to first order in τ; a thin one by d/dg of Henyey and Greenstein's function.
    tau, g = 0.01, 0.4

    def back(g):
        return quad(lambda c: (1 - g * g) / (1 + g * g - 2 * g * c) ** 1.5 / 2, -1, 0)[0]

    by_g = (back(g + 1e-4) - back(g - 1e-4)) / 2e-4
    plate = Slab(1.0, tau, 1.0, 0.0, g)
    _, found, error = slopes([plate], [[(0, "asymmetry")]], UPRIGHT, 120, above=1.0)
    # Second scatterings add some τ ln(1/τ) of it.
    assert abs(found[0] / (tau * by_g) - 1) < 4 * error[0] / abs(tau * by_g) + 0.1
    assert error[0] < 0.1 * abs(tau * by_g)


def test_a_sheet_lets_through_what_stays_in_the_disk():
    # A faceless sheet passes 1 - exp(-1/2σ²) along the normal, by each lobe.
    sigma, wide, share, passes = 0.7, 1.2, 0.3, 0.9

    def disk(s):
        return 1 - math.exp(-0.5 / s**2)

    def by(s):
        return -math.exp(-0.5 / s**2) / s**3

    sheet = Sheet(sigma, 1.0, passes, wide_sigma=wide, wide_share=share)
    names = ("sigma", "wide_sigma", "wide_share", "transmission")
    _, found, error = slopes([sheet], [[(0, name)] for name in names], UPRIGHT, 40, below=1.0)
    near(found[0], error[0], passes * (1 - share) * by(sigma), 0.03)
    near(found[1], error[1], passes * share * by(wide), 0.06)
    near(found[2], error[2], passes * (disk(wide) - disk(sigma)), 0.03)
    near(found[3], error[3], (1 - share) * disk(sigma) + share * disk(wide))


def test_a_lobe_of_two_widths_is_told_by_each():
    along, across = 0.8, 0.5

    def passed(a, b):
        return dblquad(
            lambda v, u: math.exp(-0.5 * ((u / a) ** 2 + (v / b) ** 2)) / (2 * math.pi * a * b),
            -1, 1, lambda u: -math.sqrt(1 - u * u), lambda u: math.sqrt(1 - u * u),
        )[0]  # fmt: skip

    sheet = Sheet(along, 1.0, 1.0, sigma_across=across, axis=0.7)
    _, found, error = slopes(
        [sheet], [[(0, "sigma")], [(0, "sigma_across")]], UPRIGHT, 40, below=1.0
    )
    near(found[0], error[0], (passed(along + 1e-3, across) - passed(along - 1e-3, across)) / 2e-3,
         0.03)  # fmt: skip
    near(found[1], error[1], (passed(along, across + 1e-3) - passed(along, across - 1e-3)) / 2e-3,
         0.03)  # fmt: skip


def test_in_a_furnace_only_what_absorbs_counts():
    # Amid brightness 1 nothing drawn changes the light; lamps of luminance 1-r make it so at any r.
    # With their luminance held, light follows r as what they give per unit luminance.
    lamps = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 0.4, 0.6, 1.0, 0.3)
    layers = [Slab(1.49, 2.0, 0.4, 0.0, 0.6), Sheet(0.36, 1.49, 1.0)]
    by = [[(0, "lamp_reflectance")], [(0, "specular_fraction")], [(1, "scattering")],
          [(1, "asymmetry")], [(2, "sigma")], [(2, "index")]]  # fmt: skip
    _, found, error = slopes([lamps, *layers], by, above=1.0)
    own = trace(build_scene([lamps, *layers]), EYES, 20, seed=4)
    near(found[0], math.hypot(error[0], own.radiance_error.max() / 0.4),
         own.radiance.mean() / 0.4, 0.05)  # fmt: skip
    assert np.all(np.abs(found[1:]) < 4 * error[1:])
    assert np.all(error[1:] < 0.05)


class ScoredPhilox(Philox):
    """An oracle's numbers that add up light times the slope of all that was drawn before it."""

    def __init__(self, *numbers):
        super().__init__(*numbers)
        self.slope, self.by = Counter(), Counter()

    def happens(self, element, name, log_density):
        """Add the slope of an event's ln p or ln w, by a central difference."""
        value = getattr(element, name)
        step = 1e-5 * value
        rise = log_density(value + step) - log_density(value - step)
        self.slope[element.name, name] += rise / (2 * step)

    def found(self, radiance, by_share=0.0):
        """Add light by every value."""
        for key, slope in self.slope.items():
            self.by[key] += radiance * slope
        self.by["cavity", "specular_fraction"] += by_share


def test_the_oracle_tells_the_same(tmp_path):
    bottom = Sheet(0.36, 1.49, 0.98, "bottom", wide_sigma=0.6, wide_share=0.2)
    top = Sheet(0.35, 1.49, 0.97, "top", sigma_across=0.2, axis=0.3)
    elements = [CAVITY, Slab(1.49, 2.0, 0.4, 0.01, 0.6), bottom, top]
    scene, source = build_scene(elements), Source(EYE, [0.1], 0.05, acceptance=0.5)
    columns, paths = Columns.of(scene), 60
    oracle, told = ReferenceTracer(elements), Counter()
    for path in range(paths):
        random = ScoredPhilox(1, EYE, path, 1)
        oracle.radiance(0.1, 0.05, 0.5, random)
        told.update(random.by)
    score, radiance = Score.empty(columns.first, 1, SLOTS), np.empty(paths)
    one = np.uint64(1)
    trace_scores(
        scene, source, one, np.uint64(EYE), np.uint64(0), Wave.empty(len(elements), 1), radiance,
        np.zeros(len(FLOWS) + len(elements)), NO_NET, score,
    )  # fmt: skip
    assert len(told) == 3 + 3 + 5 + 4
    for (element, name), expected in told.items():
        e = [one.name for one in elements].index(element)
        found = score.light[0] @ np.nan_to_num(_along(elements, e, name, columns))
        assert found == pytest.approx(expected, rel=2e-5, abs=1.0), (element, name)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(14))
def test_each_slope_is_that_of_finite_differences(tmp_path, number):
    elements = full(tmp_path)
    names = [(0, "lamp_reflectance"), (0, "reflectance"), (0, "specular_fraction"),
             (1, "scattering"), (1, "absorption"), (1, "asymmetry"), (2, "sigma"),
             (2, "wide_sigma"), (2, "wide_share"), (2, "index"), (3, "absorption"), (4, "sigma"),
             (4, "sigma_across"), (4, "transmission")]  # fmt: skip
    against_differences(elements, [names[number]], 150)


def test_slopes_along_a_direction_are_those_of_finite_differences(tmp_path):
    names = [(0, "reflectance"), (0, "specular_fraction"), (1, "scattering"), (1, "asymmetry"),
             (2, "sigma"), (3, "absorption"), (4, "sigma")]  # fmt: skip
    against_differences(full(tmp_path), names, 40)


def against_differences(elements, names, blocks):
    """Compare with two traces of the same random numbers, each name's value ± 3 % of it."""
    scene = build_scene(elements)
    columns = Columns.of(scene)
    size = {name: 0.03 * getattr(elements[name[0]], name[1]) for name in names}
    row = sum(_along(elements, e, name, columns) * size[e, name] for e, name in names)
    tally = trace_slopes(scene, EYES, blocks, [row], seed=3)
    ends = []
    for sign in (-1, 1):
        stack = elements
        for e, name in names:
            stack = changed(stack, e, name, sign * size[e, name])
        lit = build_scene(stack)
        ends.append([trace(lit, EYES, 1, seed=9, first=b).radiance for b in range(blocks)])
    apart = (np.array(ends[1]) - np.array(ends[0])) / 2
    difference = apart.mean(axis=0)
    error = np.sqrt(apart.var(axis=0, ddof=1) / blocks + tally.covariance[0, :, 1, 1])
    assert np.abs((tally.slope[0] - difference) / error).max() < 4
    mean = abs(tally.slope[0].mean() - difference.mean())
    assert mean < 3 * np.sqrt(np.sum(error**2)) / len(error)


def test_a_finite_panel_is_told_by_its_own_lamps():
    panel = Panel(0.0, 60.0, -20.0, 20.0, (10.0, 30.0, 50.0), (1.0, 0.8, 1.0), 36.0, 0.9, 0.2)
    cavity = Cavity(
        20.0, 20.0, 10.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3, panel=panel
    )  # fmt: skip
    names = [(0, "lamp_reflectance"), (0, "reflectance"), (0, "specular_fraction")]
    against_differences([cavity, Sheet(0.36, 1.49, 0.98)], names, 30)


def test_what_has_no_density_is_not_told():
    scene = build_scene([CAVITY, Slab(1.49, 2.0), Sheet(0.0, 1.49, 0.98)])
    columns = Columns.of(scene)
    assert not columns.known[columns.first[1]]  # scattering of a clear plate
    assert columns.known[columns.first[1] + 1]  # its absorption
    with pytest.raises(TraceError, match="known columns"):
        trace_slopes(scene, EYES, 1, np.eye(len(columns.known))[3:4])
    with pytest.raises(TraceError, match="meter"):
        trace_slopes(scene, Source(LAMPS, [0.0], 0.0), 1, np.zeros((1, len(columns.known))))


def test_a_direction_is_refused_where_geometry_changes():
    elements = [CAVITY, Sheet(0.36, 1.49, 0.98)]
    columns = Columns.of(build_scene(elements))
    taller = [replace(CAVITY, height=20.1), elements[1]]
    assert direction(columns, elements, taller, 0.1) is None
    brighter = [replace(CAVITY, reflectance=0.95), elements[1]]
    found = direction(columns, elements, brighter, 0.01)
    assert columns.place[np.flatnonzero(found)].tolist() == [[0, endless.REFLECTANCE]]
    assert found.sum() == pytest.approx(1.0)
