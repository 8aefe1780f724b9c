"""Cups round the LEDs of a board: energy, closed forms, symmetry, the oracle path by path."""

import math
from dataclasses import replace

import numpy as np
import pytest
from harness import compiled
from oracle.board import all_met
from test_board import BATWING, LAMBERTIAN, board
from test_reference import BOTTOM, CLEAR, TOP, compare

from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.cavity.board import CUP_WALL, LED_SIDE, LED_TOP, Cup
from mpfcad.optics.cavity.cup import cup_hit
from mpfcad.optics.cavity.endless import OPENING, REFLECTOR
from mpfcad.optics.element import Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.forward.connection import TERMS, CellMeter
from mpfcad.optics.forward.engine import BLOCK, trace_forward
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source

ROUND = Cup(2.0, 1.2, 2.5, 0.9, 0.3)
SQUARE = replace(ROUND, rim_radius=3.0, square=True)
UPRIGHT = Cup(1.5, 2.2, 2.2, 0.8, 1.0)


def in_cups(cup, **options):
    """Return LEDs of 1.6 mm every 6 mm under a plane at 4 mm."""
    values = {"led_height": 0.4, "hole_radius": 0.8, "hole_reflectance": 0.6, "cup": cup}
    return board(4.0, 6.0, **({"emission": LAMBERTIAN, "size": 1.6} | values | options))


@pytest.mark.parametrize("cup", [None, ROUND, SQUARE, UPRIGHT], ids=["none", "r", "sq", "mirror"])
def test_paths_over_a_board_equal_the_oracle(cup):
    compare([in_cups(cup), CLEAR, BOTTOM], 200)


@pytest.mark.parametrize("cup", [None, ROUND, replace(ROUND, square=True)])
def test_paths_over_many_leds_equal_the_oracle(cup):
    place = np.array([[0.3, 0.1], [6.0, -5.0], [5.0, 2.0]])
    leds = in_cups(cup, position=place, factor=np.ones(3), led_height=1.7, led_reflectance=0.8)
    compare([replace(leds, period=(12.0, 10.0)), CLEAR], 150)


@pytest.mark.parametrize("cup", [ROUND, SQUARE, UPRIGHT, replace(UPRIGHT, square=True)])
def test_a_ray_meets_what_all_that_is_there_says(cup):
    # From above the sheet, and from any place in a cup beside its LED, whatever the direction.
    leds, hit = in_cups(cup), compiled(cup_hit)
    scene, rng = build_scene([leds]), np.random.default_rng(22)
    names = {CUP_WALL: "cup", LED_TOP: "top", LED_SIDE: "side", REFLECTOR: "floor", OPENING: "open"}
    met = set()
    for _ in range(1500):
        o = rng.uniform(-9, 9, 3) * (1, 1, 0) + (0, 0, 4.0)
        if rng.random() < 0.7:
            z = rng.uniform(0, cup.height)
            size = cup.radius + (cup.rim_radius - cup.radius) * z / cup.height
            o = np.array([*rng.uniform(-size, size, 2), z])
            far = np.abs(o[:2]).max() if cup.square else np.hypot(*o[:2])
            if far > size or (z < leds.led_height and np.abs(o[:2]).max() < 0.8):
                continue
        d = rng.standard_normal(3)
        d /= np.linalg.norm(d)
        if o[2] == 4.0:
            d[2] = -abs(d[2])
        distance, what, normal = min(all_met(leds, tuple(o), tuple(d)), key=lambda one: one[0])
        found, *place, _, nx, ny, nz = hit(scene.parameter[0], scene.led, *o, *d)
        assert names[found] == what and np.allclose(place, o + distance * d, atol=1e-9)
        if what in ("cup", "top", "side"):
            assert np.allclose((nx, ny, nz), normal, atol=1e-9)
        met.add(what)
    assert met == set(names.values())


def share_up(leds, blocks=40):
    """Return the share of the LEDs' light that leaves upward, and its standard error."""
    tally = trace(build_scene([leds]), Source(LAMPS, np.zeros(1), 0.0), blocks, seed=21)
    assert tally.fraction[FLOWS.index("lost")] == 0
    assert tally.fraction.sum() == pytest.approx(1, abs=1e-12)
    return tally.fraction[FLOWS.index("up")], tally.fraction_error[FLOWS.index("up")]


@pytest.mark.parametrize("cup", [ROUND, SQUARE, UPRIGHT])
def test_white_cups_keep_all_light(cup):
    white = replace(cup, reflectance=1.0)
    leds = in_cups(white, reflectance=1.0, led_reflectance=1.0, hole_reflectance=1.0)
    assert share_up(leds, 4)[0] == pytest.approx(1, abs=1e-12)


def point(cup):
    """Return black boards of points of light at the bottom of cups."""
    leds = in_cups(cup, led_height=0.0, led_reflectance=0.0, reflectance=0.0, hole_radius=0.0)
    return replace(leds, led_size=(1e-6, 1e-6))


def test_a_black_cup_lets_out_what_its_rim_lets_see():
    # A Lambertian point on the axis: r²/(r²+h²); the form factor of a square (Siegel and Howell,
    # "Thermal radiation heat transfer", configuration 4).
    black = replace(ROUND, reflectance=0.0)
    found, error = share_up(point(black))
    assert abs(found - 2.5**2 / (2.5**2 + 2.0**2)) < 4 * error
    found, error = share_up(point(replace(black, square=True)))
    a = 2.5 / 2.0
    root = math.sqrt(1 + a * a)
    assert abs(found - 4 * a / root * math.atan(a / root) / math.pi) < 4 * error


def meridian(cup, angle):
    """Return how many mirrorings a ray from the axis at a polar angle has in a plane section."""
    slope = (cup.rim_radius - cup.radius) / cup.height
    r, z, dr, dz, count = 0.0, 0.0, math.sin(angle), math.cos(angle), 0
    while True:
        # r = ± (radius + slope z), ahead.
        ahead = []
        for sign in (1, -1):
            rate = sign * dr - slope * dz
            if rate > 1e-12:
                ahead.append(((cup.radius + slope * z - sign * r) / rate, sign))
        distance, sign = min(ahead, default=(math.inf, 0))
        if dz > 0 and z + distance * dz >= cup.height:
            return count, True
        r, z, count = r + distance * dr, z + distance * dz, count + 1
        if z < 0:
            return count, False
        n = (-sign, slope)
        into = 2 * (dr * n[0] + dz * n[1]) / (1 + slope**2)
        dr, dz = dr - into * n[0], dz - into * n[1]


@pytest.mark.parametrize("rim", [1.0, 1.4, 2.5])
def test_a_mirror_cup_is_a_sum_over_mirrorings(rim):
    # A ray from the axis of a cone stays in a plane through it.
    cup = Cup(3.0, 1.0, rim, 0.7, 1.0)  # wider at its rim, or upright
    found, error = share_up(point(cup))
    sine = np.sqrt((np.arange(4000) + 0.5) / 4000)
    ways = [meridian(cup, float(angle)) for angle in np.arcsin(sine)]
    assert all(leaves for _, leaves in ways)
    expected = np.mean([0.7**count for count, _ in ways])
    assert abs(found - expected) < 4 * error + 1e-4


@pytest.mark.parametrize("cup", [ROUND, SQUARE])
def test_connected_from_the_leds_and_by_chance_from_the_meter_agree(cup):
    bins, blocks, pitch = 6, 60, 6.0
    leds = in_cups(cup, emission=BATWING)
    scene = build_scene([leds, Slab(1.49, 1.0, 0.3, 0.001, 0.5), TOP])
    meter = CellMeter(math.sin(math.radians(3)), pitch, pitch, bins)
    tally = trace_forward(scene, meter, blocks, seed=24)
    scale = 100 / pitch**2 * 1e6 * bins**2 / BLOCK
    mean = tally.score[TERMS**2 :] / blocks
    error = scale * np.sqrt((tally.square / blocks - mean**2) / (blocks - 1))
    middle = ((np.arange(bins) + 0.5) / bins - 0.5) * pitch
    x, y = (part.ravel() for part in np.meshgrid(middle, middle, indexing="ij"))
    eye = Source(
        EYE, x, pitch / bins, acceptance=meter.acceptance, along=y, spot_along=pitch / bins
    )
    chance = trace(scene, eye, 6, seed=24)
    off = (scale * mean - chance.radiance) / np.hypot(error, chance.radiance_error)
    assert np.sum(off**2) < 36 + 4 * math.sqrt(2 * 36)  # 4σ
    # The cell is the same mirrored at x = 0, y = 0, and at its diagonal.
    n = TERMS * TERMS
    term = tally.score[:n].reshape(TERMS, TERMS) / blocks
    spread = np.sqrt(np.diag(tally.outer / blocks - np.outer(term, term)) / blocks)
    noise = spread.reshape(TERMS, TERMS)
    sines = range(2, TERMS, 2)
    assert np.abs(term / noise)[sines].max() < 4.7 and np.abs(term / noise)[:, sines].max() < 4.7
    off = (term - term.T) / np.hypot(noise, noise.T)
    np.fill_diagonal(off, 0.0)
    assert np.abs(off).max() < 4.7  # 78 pairs
