"""LED boards: emission, irradiance in closed form, the connected trace against chance."""

import math

import numpy as np
import pytest
from harness import BARE, film_mesh
from numba import njit, uint64

from mpfcad.errors import TraceError
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE, start_path
from mpfcad.optics.cavity.board import Board, led_start
from mpfcad.optics.cavity.emission import Emission, emitted_direction, emitted_intensity
from mpfcad.optics.element import Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.forward.connection import TERMS, CellMeter, score_at
from mpfcad.optics.forward.engine import BLOCK, trace_forward
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source
from mpfcad.store.kernel import kept

_ANGLE = np.radians([0, 20, 40, 55, 65, 72, 78, 85, 90])
_LIGHT = np.array([0.30, 0.36, 0.60, 0.85, 1.0, 0.95, 0.6, 0.15, 0.0])
BATWING = Emission.of_polar(_ANGLE, _LIGHT)
LAMBERTIAN = Emission.cosine_power(1.0)


def board(height=8.0, pitch=20.0, emission=BATWING, size=3.0, **options):
    values = {
        "position": np.zeros((1, 2)), "factor": np.ones(1), "led_height": 0.0, "led_flux": 100.0,
        "led_reflectance": 0.5, "reflectance": 0.95, "specular_fraction": 0.3,
    }  # fmt: skip
    return Board(
        height, (pitch, pitch), led_size=(size, size), emission=emission, **(values | options)
    )


@kept
@njit(error_model="numpy")
def draw(scene, seed, out):
    rng = np.zeros(RNG_SIZE, np.uint64)
    for i in range(len(out)):
        start_path(rng, uint64(seed), uint64(3), uint64(i))
        out[i, 0], out[i, 1], out[i, 2] = emitted_direction(scene.emission, rng)


@kept
@njit(error_model="numpy")
def arrive(scene, meter, height, seed, paths, terms, score):
    """Score where the light of the LEDs first meets the plane at a height."""
    rng = np.zeros(RNG_SIZE, np.uint64)
    for i in range(paths):
        start_path(rng, uint64(seed), uint64(5), uint64(i))
        x, y, z, dx, dy, dz, _ = led_start(scene, rng)
        flight = (height - z) / dz
        score_at(meter, score, terms, x + flight * dx, y + flight * dy, 1.0)


@kept
@njit(error_model="numpy")
def intensities(scene, direction, out):
    for i in range(len(out)):
        out[i] = emitted_intensity(
            scene.emission, direction[i, 0], direction[i, 1], direction[i, 2]
        )


def table(rng_seed=3, azimuths=6):
    """Return an emission that differs round."""
    rng = np.random.default_rng(rng_seed)
    return Emission(rng.uniform(0.2, 1.0, (azimuths, 1)) * BATWING.intensity + 0.05)


@pytest.mark.parametrize("emission", [LAMBERTIAN, BATWING, table()], ids=["cos", "bat", "table"])
def test_directions_are_drawn_with_the_intensity_as_density(emission):
    scene = build_scene([board(emission=emission)])
    found = np.zeros((200_000, 3))
    draw(scene, 11, found)
    assert np.allclose(np.linalg.norm(found, axis=1), 1)
    bins = (9, 12)
    number, *_ = np.histogram2d(
        np.arccos(found[:, 2]),
        np.mod(np.arctan2(found[:, 1], found[:, 0]), 2 * np.pi),
        bins,
        ((0, np.pi / 2), (0, 2 * np.pi)),
    )
    fine = 40
    polar = (np.arange(bins[0] * fine) + 0.5) / (bins[0] * fine) * np.pi / 2
    turn = (np.arange(bins[1] * fine) + 0.5) / (bins[1] * fine) * 2 * np.pi
    p, t = (part.ravel() for part in np.meshgrid(polar, turn, indexing="ij"))
    value = np.zeros(len(p))
    direction = np.stack([np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)], axis=1)
    intensities(scene, direction, value)
    share = value * np.sin(p) * (np.pi / 2 / (bins[0] * fine)) * (2 * np.pi / (bins[1] * fine))
    expected = share.reshape(bins[0], fine, bins[1], fine).sum(axis=(1, 3))
    assert expected.sum() == pytest.approx(1, abs=1e-4)
    chi2 = np.sum((number - len(found) * expected) ** 2 / (len(found) * expected))
    assert chi2 < 108 + 4 * math.sqrt(2 * 108)  # 4σ of 107 degrees of freedom


def test_a_lambertian_led_has_the_same_luminance_everywhere():
    # A Lambertian 1 mm² emitter of 1 lm: 318,310 cd/m².
    scene = build_scene([board(emission=LAMBERTIAN, size=1.0, led_flux=1.0, reflectance=0.0)])
    eye = Source(EYE, [0.0, 0.2], 0.0, tilt_x=[0.0, 0.5], along=[0.0, 0.1], spot_along=1e-9)
    eye = eye._replace(position=np.array([0.0, 0.2 - 8.0 * 0.5 / math.sqrt(0.75)]))
    found = trace(scene, eye, 1).radiance
    assert np.allclose(found, 1e6 / math.pi, rtol=1e-4)


def k1(x):
    from scipy.special import k1 as bessel

    return x * bessel(x)


@pytest.mark.parametrize(
    ("ratio", "published"), [(1.0, 0.9516), (1.5, None), (2.0, 0.4394), (2.5, None), (3.0, 0.1470)]
)
def test_irradiance_of_an_endless_lambertian_array_in_closed_form(ratio, published):
    # E of a point over the plane is H²/(π(r²+H²)²) of its flux, whose Fourier transform is
    # kH·K1(kH): the array's harmonics, summed for the least and most, and traced.
    pitch = 20.0
    height = pitch / ratio
    wave = 2 * np.pi * height / pitch
    order = np.arange(-12, 13)
    far = np.hypot(*np.meshgrid(order, order)) * wave
    amplitude = np.where(far > 0, k1(np.where(far > 0, far, 1.0)), 1.0)
    sign = (-1.0) ** np.add.outer(order, order)
    closed = float((sign * amplitude).sum() / amplitude.sum())
    if published:
        assert closed == pytest.approx(published, abs=6e-5)
    scene = build_scene([board(height, pitch, LAMBERTIAN, size=1e-6)])
    meter, paths = CellMeter(0.0, pitch, pitch, 4), 60_000
    score = np.zeros(meter.size(1))
    arrive(scene, meter, height, 12, paths, np.zeros((2, TERMS)), score)
    found = score[: TERMS**2].reshape(TERMS, TERMS) / paths
    cosine = [0, *range(1, TERMS, 2)]
    expected = k1(np.maximum(np.hypot(*np.meshgrid(range(7), range(7))) * wave, 1e-12))
    # A mean of products of cosines has a variance of at most 1.
    off = (found[np.ix_(cosine, cosine)] - expected) * math.sqrt(paths)
    assert np.abs(off).max() < 4.5  # 49 values
    sines = found[np.ix_(range(2, TERMS, 2), range(2, TERMS, 2))] * math.sqrt(paths)
    assert np.abs(sines).max() < 4.5


def test_light_connected_through_one_sheet_in_closed_form():
    # Point LED, black board, sheet at once above: L = Σ I(θ) cos θ/r² · density · T · t.
    pitch, height, sigma = 12.0, 5.0, 0.3
    scene = build_scene([
        board(height, pitch, LAMBERTIAN, size=1e-6, reflectance=0.0, led_reflectance=0.0),
        Sheet(sigma, 1.49, 0.9),
    ])  # fmt: skip
    meter = CellMeter(0.0, pitch, pitch, 12)
    blocks = 60
    tally = trace_forward(scene, meter, blocks, seed=13)
    places = (np.arange(1, 240, 2) / 240 - 0.5) * pitch
    x, y = np.meshgrid(places, places, indexing="ij")
    expected = np.zeros_like(x)

    def reflectance(cosine):
        inner = np.sqrt(1 - (1 - cosine**2) / 1.49**2)
        s = (cosine - 1.49 * inner) / (cosine + 1.49 * inner)
        p = (1.49 * cosine - inner) / (1.49 * cosine + inner)
        return (s**2 + p**2) / 2

    normal = reflectance(1.0)
    for i in range(-8, 9):
        for k in range(-8, 9):
            dx, dy = x - i * pitch, y - k * pitch
            far = np.sqrt(dx**2 + dy**2 + height**2)
            cosine, sine2 = height / far, (dx**2 + dy**2) / far**2
            r = reflectance(cosine)
            passed = (1 - r) * (1 - normal) / (1 - r * normal)
            density = np.exp(-sine2 / (2 * sigma**2)) / (2 * np.pi * sigma**2)
            expected += 100e6 * cosine / np.pi * cosine / far**2 * density * passed * 0.9
    expected = expected.reshape(12, 10, 12, 10).mean(axis=(1, 3))
    scale = 100 / pitch**2 * 1e6 * 144 / BLOCK
    mean = tally.score[TERMS**2 :] / blocks
    error = scale * np.sqrt((tally.square / blocks - mean**2) / (blocks - 1)).reshape(12, 12)
    off = (scale * mean.reshape(12, 12) - expected) / error
    assert np.sum(off**2) < 144 + 4.5 * math.sqrt(2 * 144)


@pytest.fixture(scope="module")
def crossed(tmp_path_factory):
    mesh = film_mesh(tmp_path_factory.mktemp("film"), [BARE])
    leds = board(led_height=0.7, hole_radius=4.0, hole_reflectance=0.8)
    return build_scene([
        leds, Slab(1.49, 2.0, 0.3, 0.001, 0.5), Sheet(0.36, 1.49, 0.98), Film(mesh, 1.55),
        Film(mesh, 1.55, rotation=np.pi / 2), Sheet(0.35, 1.49, 0.98),
    ])  # fmt: skip


def test_connected_from_the_leds_and_by_chance_from_the_meter_agree(crossed):
    bins, blocks = 8, 100
    meter = CellMeter(math.sin(math.radians(1)), 20.0, 20.0, bins)
    tally = trace_forward(crossed, meter, blocks, seed=14)
    scale = 100 / 400 * 1e6 * bins * bins / BLOCK
    mean = tally.score[TERMS**2 :] / blocks
    error = scale * np.sqrt((tally.square / blocks - mean**2) / (blocks - 1))
    middle = (np.arange(bins) + 0.5) / bins * 20 - 10
    x, y = (part.ravel() for part in np.meshgrid(middle, middle, indexing="ij"))
    eye = Source(EYE, x, 20 / bins, acceptance=meter.acceptance, along=y, spot_along=20 / bins)
    chance = trace(crossed, eye, 6, seed=14)
    off = (scale * mean - chance.radiance) / np.hypot(error, chance.radiance_error)
    assert np.sum(off**2) < 64 + 4 * math.sqrt(2 * 64)  # 4σ


def test_no_light_is_lost_and_threads_change_nothing(crossed):
    meter = CellMeter(0.0175, 20.0, 20.0, 4)
    one, two = (trace_forward(crossed, meter, 6, seed=15, threads=n) for n in (1, 2))
    for a, b in zip(one, two, strict=True):
        assert np.array_equal(a, b)
    share = one.flow / one.paths
    assert share.sum() == pytest.approx(1, abs=1e-12)
    assert share[FLOWS.index("lost")] == 0
    # The same light by the engine for all sources.
    both = trace(crossed, Source(LAMPS, np.zeros(1), 0.0), 60, seed=16)
    error = math.hypot(both.fraction_error[0], 0.5 / math.sqrt(one.paths))
    assert abs(both.fraction[0] - share[0]) < 4 * error


def test_many_leds_share_the_light_by_their_flux():
    # Two LEDs of flux 1 and 3 half a cell apart: the first harmonic is (1 - 3)/(1 + 3) of one's.
    place = np.array([[0.0, 0.0], [10.0, 0.0]])
    scene = build_scene([
        board(6.0, 20.0, LAMBERTIAN, size=1e-6, position=place, factor=np.array([1.0, 3.0]))
    ])  # fmt: skip
    meter, paths = CellMeter(0.0, 20.0, 20.0, 4), 60_000
    score = np.zeros(meter.size(1))
    arrive(scene, meter, 6.0, 17, paths, np.zeros((2, TERMS)), score)
    wave = 2 * np.pi * 6.0 / 20.0
    off = score[TERMS] / paths + 0.5 * k1(wave)
    assert abs(off) < 4 / math.sqrt(2 * paths)


def test_a_trace_from_leds_needs_a_sheet_on_top():
    with pytest.raises(TraceError, match="expected LEDs below and a scattering sheet on top"):
        trace_forward(build_scene([board()]), CellMeter(0.01, 20.0, 20.0, 4), 1)
