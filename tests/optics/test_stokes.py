"""Polarised light by its laws: Fresnel, piles of plates, Malus, retarders, furnace, turning."""

import math

import numpy as np
import pytest
from harness import BARE, compiled, film_mesh, groove, polarised_paths, within

from mpfcad.errors import InputError, TraceError
from mpfcad.optics.base.sampling import RNG_SIZE
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source
from mpfcad.optics.stokes import interface, state
from mpfcad.optics.stokes.engine import trace_stokes
from mpfcad.optics.stokes.mueller import MuellerLayer, refuse_active
from mpfcad.optics.stokes.plane import PlaneLayer, plane_passage

N = 1.5
EIGHTH = math.pi / 4


def seen(elements, blocks=40, tilt=(0.0, 0.0), seed=5, **sky):
    """Return I, Q, U, V with standard errors, (4,) each, of a meter of no width over a scene."""
    scene = build_scene(elements, polarised=True, **(sky or {"below": 1.0}))
    found = trace_stokes(scene, Source(EYE, [0.1], 0.05, *tilt), blocks, seed=seed)[:, 0]
    return found.mean(axis=0), found.std(axis=0, ddof=1) / math.sqrt(blocks) + 1e-12


def interface_shares(angle, n=N):
    """Return R_s and R_p from air, by the sine and tangent formulas of Fresnel."""
    other = math.asin(math.sin(angle) / n)
    minus, plus = angle - other, angle + other
    return (math.sin(minus) / math.sin(plus)) ** 2, (math.tan(minus) / math.tan(plus)) ** 2


@pytest.mark.parametrize("angle", np.radians([10.0, 40.0, 56.309932, 75.0]))
def test_reflectances_are_those_of_sine_and_tangent(angle):
    found = compiled(interface.amplitudes)(math.cos(angle), 1 / N)
    np.testing.assert_allclose(found[:2], interface_shares(angle), atol=1e-14)


def test_no_p_light_is_reflected_at_the_angle_of_brewster():
    r_s, r_p, *_ = compiled(interface.amplitudes)(math.cos(math.atan(N)), 1 / N)
    assert r_p < 1e-30
    assert r_s > 0.1


@pytest.mark.parametrize("angle", np.radians([42.0, 45.0, 51.3, 70.0, 89.0]))
def test_total_reflection_retards_as_born_and_wolf_say(angle):
    # Principles of optics, 1.5.4, (60): tan(δ/2) = cos θ √(sin²θ - 1/n²)/sin²θ.
    r_s, r_p, cosine, sine, _ = compiled(interface.amplitudes)(math.cos(angle), N)
    root = math.sqrt(math.sin(angle) ** 2 - 1 / N**2)
    expected = 2 * math.atan(math.cos(angle) * root / math.sin(angle) ** 2)
    assert (r_s, r_p) == (1.0, 1.0)
    assert abs(math.atan2(sine, cosine)) == pytest.approx(expected, abs=1e-12)
    assert math.hypot(cosine, sine) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("plates", [1, 2, 5])
@pytest.mark.parametrize("degrees", [30.0, 56.309932, 70.0])
def test_a_pile_of_plates_polarises_as_stokes_found(plates, degrees):
    # Each polarisation by itself: T = (1 - R)/(1 + (2m - 1) R) of m plates (G. G. Stokes, "On the
    # intensity of the light reflected from or transmitted through a pile of plates", 1862).
    angle = math.radians(degrees)
    s, p = ((1 - r) / (1 + (2 * plates - 1) * r) for r in interface_shares(angle))
    # Seen across x, s is along y.
    value, error = seen([Slab(N, 1.0)] * plates, tilt=(math.sin(angle), 0.0))
    within(value, np.array([s + p, s - p, 0.0, 0.0]) / 2, error, 4)
    value, error = seen([Slab(N, 1.0)] * plates, tilt=(0.0, math.sin(angle)))
    within(value, np.array([s + p, p - s, 0.0, 0.0]) / 2, error, 4)


@pytest.mark.parametrize("angle", [0.0, 0.3, EIGHTH, 1.0, math.pi / 2])
def test_two_polarisers_follow_malus(angle):
    pair = [PlaneLayer(0.2, (1.0, 0.0)), PlaneLayer(0.2 + angle, (1.0, 0.0))]
    value, _ = seen(pair, blocks=1)
    share = 0.5 * math.cos(angle) ** 2
    turned = 2 * (0.2 + angle)
    expected = share * np.array([1.0, math.cos(turned), math.sin(turned), 0.0])
    np.testing.assert_allclose(value, expected, atol=1e-14)


def test_crossed_polarisers_leak_by_their_extinction():
    value, _ = seen([PlaneLayer(0.0, (0.9, 0.01)), PlaneLayer(math.pi / 2, (0.9, 0.01))], 1)
    np.testing.assert_allclose(value, [0.009, 0.0, 0.0, 0.0], atol=1e-15)


def test_a_quarter_wave_plate_makes_circles_and_two_turn_by_twice_the_angle():
    polariser = PlaneLayer(0.0, (1.0, 0.0))
    quarter = PlaneLayer(EIGHTH, retardation=math.pi / 2)
    one, _ = seen([polariser, quarter], 1)
    np.testing.assert_allclose(np.abs(one), [0.5, 0.0, 0.0, 0.5], atol=1e-15)
    two, _ = seen([polariser, quarter, quarter], 1)
    half, _ = seen([polariser, PlaneLayer(EIGHTH, retardation=math.pi)], 1)
    np.testing.assert_allclose(two, half, atol=1e-15)
    np.testing.assert_allclose(half, [0.5, -0.5, 0.0, 0.0], atol=1e-15)


def test_a_mirror_behind_a_quarter_wave_plate_is_dark_through_its_polariser():
    # An isolator: light that comes back has passed a half-wave plate and is turned by 90°.
    mirror = Cavity(5.0, 30.0, 0.0, 3.0, 1.0, 0.0, 1.0, 1.0, 1.0)
    top = [PlaneLayer(EIGHTH, retardation=math.pi / 2), PlaneLayer(0.0, (1.0, 0.0))]
    scene = build_scene([mirror, *top], above=1.0, polarised=True)
    found = trace_stokes(scene, Source(EYE, [15.0], 0.0), 1)[0, 0]
    assert abs(found[0]) < 1e-14
    without = build_scene([mirror, top[1]], above=1.0, polarised=True)
    assert trace_stokes(without, Source(EYE, [15.0], 0.0), 1)[0, 0, 0] == pytest.approx(0.5)


def lossless(folder):
    film = Film(film_mesh(folder, [groove(57.0), groove(30.0)]), 1.55, offset=0.013, rotation=0.4)
    return [
        Slab(1.49, 2.0, 0.4, 0.0, 0.8), PlaneLayer(0.3, retardation=1.1), film,
        Slab(1.64, 0.1, delay=40.0, axis=0.6),
        PlaneLayer(0.9, (0.95, 0.1), (0.05, 0.9)), Sheet(0.2, 1.49, 1.0, depolarisation=0.3),
    ]  # fmt: skip


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.7, 0.4)])
def test_amid_unpolarised_light_every_meter_sees_it_as_it_is(tmp_path, tilt):
    # A lossless scene keeps equal light from all around equal: whatever the meter's state D =
    # (1, q, u, v), it sees 1. So each path ends at intensity 1, and Q = U = V = 0 in the mean.
    scene = build_scene(lossless(tmp_path), below=1.0, above=1.0, polarised=True)
    source = Source(EYE, [0.1], 0.05, *tilt, acceptance=0.1)
    paths = polarised_paths(scene, source, 7, 4096)
    np.testing.assert_allclose(paths[:, 0], 1.0, atol=1e-12)
    assert np.abs(paths[:, 1:]).max() <= 1.0 + 1e-9
    value, error = seen(lossless(tmp_path), tilt=tilt, below=1.0, above=1.0)
    within(value[1:], 0.0, error[1:], 4)


def test_no_state_is_more_than_wholly_polarised(tmp_path):
    # |Q|, |U|, |V| ≤ I a path, in scenes that absorb too.
    stack = [*lossless(tmp_path), PlaneLayer(1.2, (0.8, 0.0)), Slab(1.49, 1.0, 0.0, 0.3)]
    scene = build_scene(stack, below=1.0, polarised=True)
    paths = polarised_paths(scene, Source(EYE, [0.1], 0.05, 0.3, acceptance=0.2), 8, 4096)
    length = np.sqrt((paths[:, 1:3] ** 2).sum(axis=1))
    assert (length <= paths[:, 0] * (1 + 1e-9)).all()
    assert (paths[:, 0] > 0).any()


def test_a_scene_turned_with_its_meter_looks_the_same():
    def paths(turn):
        stack = [PlaneLayer(0.1 + turn, (0.9, 0.1), (0.05, 0.8)), Slab(N, 1.0),
                 PlaneLayer(0.5 + turn, retardation=0.8)]  # fmt: skip
        c, s = math.cos(turn), math.sin(turn)
        tilt = 0.6 * c - 0.2 * s, 0.6 * s + 0.2 * c
        scene = build_scene(stack, below=1.0, above=0.3, polarised=True)
        return polarised_paths(scene, Source(EYE, [0.1], 0.0, *tilt), 3, 512)

    first, second = paths(0.0), paths(0.7)
    np.testing.assert_allclose(first[:, [0, 3]], second[:, [0, 3]], atol=1e-12)
    lengths = (np.hypot(found[:, 1], found[:, 2]) for found in (first, second))
    np.testing.assert_allclose(next(lengths), next(lengths), atol=1e-12)
    assert np.ptp(first[:, 3]) > 0.1


def test_light_from_the_lamps_and_to_the_meter_agree(tmp_path):
    # Reciprocity: flux out over flux in, traced from the lamps, is what a hemisphere's meter sees.
    radius, pitch, luminance = 1.7, 20.0, 1.0
    cavity = Cavity(15.0, pitch, 0.0, 3.5, radius, luminance, 0.6, 0.9, 0.5)
    film = Film(film_mesh(tmp_path, [BARE]), 1.55)
    stack = [cavity, film, PlaneLayer(0.4, (0.9, 0.05), (0.1, 0.9)),
             PlaneLayer(0.9, retardation=1.0), Film(film.mesh, 1.55, rotation=0.9),
             Slab(1.64, 0.1, delay=40.0, axis=0.6),
             PlaneLayer(0.2, (0.8, 0.01))]  # fmt: skip
    scene = build_scene(stack, polarised=True)
    forward = trace(scene, Source(LAMPS, [0.0], 0.0), 60, seed=3)
    emitted = math.pi * luminance * 2 * math.pi * radius / pitch
    back = trace(scene, Source(EYE, [pitch / 2], pitch, acceptance=1.0), 150, seed=4)
    value = forward.fraction[0] * emitted, math.pi * back.radiance[0]
    error = forward.fraction_error[0] * emitted, math.pi * back.radiance_error[0]
    assert max(error) < 0.01 * value[0]
    within(value[0] - value[1], 0.0, math.hypot(*error), 4)
    shares = forward.fraction
    assert shares.sum() == pytest.approx(1.0, abs=4 * forward.fraction_error.max())


def test_reflections_are_drawn_as_often_as_they_should_be():
    # χ² over 60 states and angles; 30 to 92 hold 99.9 % of it (scipy.stats.chi2).
    rng = np.random.default_rng(11)
    meet, amplitudes = compiled(interface.meet_interface), compiled(interface.amplitudes)
    square, draws = 0.0, 1000
    for _ in range(60):
        vector = rng.normal(size=3)
        vector *= rng.random() / np.linalg.norm(vector)
        cosine, ratio = rng.uniform(0.1, 0.95), rng.choice([1 / 1.5, 1.5])
        sine = math.sqrt(1 - cosine**2)
        if ratio * sine >= 1:
            ratio = 1 / ratio
        # Axis e = y, in the plane of s: s is d × n = (0, -sine, 0) for d = (sine, 0, -cosine).
        angle = math.asin(ratio * sine)
        r_s, r_p, *_ = amplitudes(cosine, ratio)
        share = 0.5 * (r_s * (1 + vector[0]) + r_p * (1 - vector[0]))
        assert 0 < angle < math.pi / 2
        random = np.zeros(RNG_SIZE, np.uint64)
        random[0] = rng.integers(2**32)
        count = 0
        for _ in range(draws):
            light = np.zeros(state.LIGHT_SHAPE)
            light[0], light[4] = (1.0, *vector), (0.0, 1.0, 0.0, 1.0)
            count += meet(cosine, ratio, 0.0, 0.0, 1.0, sine, 0.0, -cosine, light, random)[0]
        square += (count - draws * share) ** 2 / (draws * share * (1 - share))
    assert 30 < square < 95


def test_a_layer_that_makes_light_is_refused():
    with pytest.raises(InputError, match=r"dbef: 0\.9 transmitted and 0\.2 reflected along"):
        PlaneLayer(0.0, (0.9, 0.1), (0.2, 0.8), name="dbef")
    with pytest.raises(InputError, match="transmittance across"):
        PlaneLayer(0.0, (0.9, 1.1))


def test_a_polariser_needs_polarised_light():
    with pytest.raises(TraceError, match="needs polarised light"):
        build_scene([PlaneLayer(0.0, (1.0, 0.0))])


def test_a_grazing_ray_passes_a_layer_finitely():
    light, random = np.zeros(state.LIGHT_SHAPE), np.zeros(RNG_SIZE, np.uint64)
    compiled(state.start_light)(light, 4, 1.0, 0.0, 0.0)
    row = np.array([1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    _, _, left = compiled(plane_passage)(row, 1.0, 0.0, 0.0, light, random)
    assert np.isfinite(left)
    assert np.isfinite(light).all()


def random_rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def random_mueller(rng, pieces=3):
    """Return a passive Mueller matrix: a mean of retarders and diattenuators in a row."""
    total = np.zeros((4, 4))
    for _ in range(pieces):
        turn = [np.eye(4), np.eye(4)]
        for one in turn:
            one[1:, 1:] = random_rotation(rng)
        p, q = rng.random(2)
        both = math.sqrt(p * q)
        middle = np.diag([(p + q) / 2, (p + q) / 2, both, both])
        middle[0, 1] = middle[1, 0] = (p - q) / 2
        total += turn[0] @ middle @ turn[1] / pieces
    return total


def test_a_mueller_matrix_acts_on_light_from_below_as_it_stands():
    matrix = random_mueller(np.random.default_rng(1))
    value, _ = seen([PlaneLayer(0.3, (1.0, 0.0)), MuellerLayer(0.0, matrix)], 1)
    light = np.array([1.0, math.cos(0.6), math.sin(0.6), 0.0]) / 2
    np.testing.assert_allclose(value, matrix @ light, atol=1e-14)
    turned, _ = seen([PlaneLayer(0.3, (1.0, 0.0)), MuellerLayer(0.8, matrix)], 1)
    c, s = math.cos(1.6), math.sin(1.6)
    turn = np.array([[1, 0, 0, 0], [0, c, s, 0], [0, -s, c, 0], [0, 0, 0, 1]])
    np.testing.assert_allclose(turned, turn.T @ matrix @ turn @ light, atol=1e-14)


def test_layers_by_their_matrix_equal_layers_by_their_values():
    # A retarder and a polariser, twice through a mirror: both ways through each matrix.
    mirror = Cavity(5.0, 30.0, 0.0, 3.0, 1.0, 0.0, 1.0, 1.0, 1.0)
    phase, p, q = 0.9, 0.8, 0.1
    c, s, both = math.cos(phase), math.sin(phase), math.sqrt(p * q)
    retarder = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, c, -s], [0, 0, s, c]])
    polariser = np.diag([(p + q) / 2, (p + q) / 2, both, both])
    polariser[0, 1] = polariser[1, 0] = (p - q) / 2
    by_values = [PlaneLayer(0.5, retardation=phase), PlaneLayer(1.1, (p, q))]
    by_matrix = [MuellerLayer(0.5, retarder), MuellerLayer(1.1, polariser)]
    source = Source(EYE, [15.0], 0.0, 0.3, 0.2)
    found = [
        polarised_paths(build_scene([mirror, *layers], above=1.0, polarised=True), source, 2, 64)
        for layers in (by_values, by_matrix)
    ]
    np.testing.assert_allclose(found[0], found[1], atol=1e-13)
    assert np.ptp(found[0]) > 0.01


def test_matrices_that_make_light_or_are_none_of_light_are_refused():
    for seed in range(20):
        refuse_active("layer", random_mueller(np.random.default_rng(seed)))
    with pytest.raises(InputError, match=r"layer: Mueller matrix: passes 1\.2 of some light"):
        refuse_active("layer", np.diag([0.6, 0.6, 0.6, 0.6]) * 2.0)
    with pytest.raises(InputError, match=r"layer: Mueller matrix: no mixture of Jones matrices"):
        refuse_active("layer", np.diag([0.5, 0.6, 0.0, 0.0]))
    with pytest.raises(InputError, match="no mixture"):
        refuse_active("layer", np.diag([0.5, 0.5, 0.5, -0.5]))
    one_way = np.zeros((4, 4))
    one_way[0, 0], one_way[1, 0] = 0.8, 0.8
    with pytest.raises(InputError, match="passes downward"):
        refuse_active("layer", one_way)
