"""Patterns: every one reaches the wanted ratio; what levelling leaves; maps in both directions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import CurvatureField, FieldFilm, Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask
from mpfcad.mask.noise import rank_columns
from mpfcad.mask.pattern.levelling import FULL_WIDTH, levelling_residual
from mpfcad.units import deg

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)
LENGTH = 20.0
#: Ratio of one dot of 40 µm over a whole groove.
ONE_DOT = 0.04**2 / (0.05 * LENGTH)
PATTERNS_1D = ("slot", "dot", "staggered", "angled", "blue-noise", "error-diffused")
PATTERNS_2D = ("slot", "dot", "blue-noise", "error-diffused")


def rules(pattern, **other):
    period = 0.4 if pattern == "slot" else 0.05
    return MaskRules(pattern, period, 0.008, 0.010, **other)


def film_of(curvature, length=LENGTH):
    return PrismFilm(BEF, 0.2, length, "filled", np.asarray(curvature, float))


def field_film(n=40, length=LENGTH, low=56.0, high=63.0):
    x, y = np.linspace(0, n * BEF.pitch, 9), np.linspace(0, length, 21)
    wave = np.cos(3 * x / x[-1]) * np.cos(5 * y[:, None] / y[-1])
    curvature = (low + high) / 2 + (high - low) / 2 * wave
    return FieldFilm(BEF, length, n, CurvatureField(x, y, curvature))


def flat(mask):
    """Return left, bottom, width, length of every aperture, flattened one by one."""
    found = []
    for array in mask.arrays:
        place = array.place.positions()
        found.append(np.column_stack([place, np.tile(array.size, (len(place), 1))]))
    for tiles in mask.tile_arrays:
        for corner in tiles.place.positions():
            for array in tiles.tile.arrays:
                place = corner + array.place.positions()
                found.append(np.column_stack([place, np.tile(array.size, (len(place), 1))]))
    return np.concatenate(found)


def masks():
    one = [(film_of(np.linspace(56, 63, 40)), p) for p in PATTERNS_1D]
    return one + [(field_film(), p) for p in PATTERNS_2D]


@pytest.mark.parametrize(("film", "pattern"), masks())
def test_what_a_mask_tells_is_what_its_apertures_are(film, pattern):
    """Count, ratio of every groove and of every square, from the flattened apertures."""
    mask = build_mask(film, PROCESS, rules(pattern), "job")
    box = flat(mask)
    assert len(box) == mask.aperture_count
    assert box[:, :2].min() >= 0
    assert (box[:, 0] + box[:, 2]).max() <= 40 * 50_000
    assert (box[:, 1] + box[:, 3]).max() <= 20_000_000
    groove = box[:, 0] // 50_000
    area = np.bincount(groove, box[:, 2] * box[:, 3], minlength=40)
    assert area / (50_000 * 20_000_000) == pytest.approx(mask.aperture_ratio, rel=1e-12)
    edge = np.append(np.arange(0, 20_000_000, 700_000), 20_000_000)
    drawn = np.zeros((len(edge) - 1, 3))
    for k in range(len(edge) - 1):
        top, bottom = box[:, 1] + box[:, 3], box[:, 1]
        inside = np.clip(np.minimum(top, edge[k + 1]) - np.maximum(bottom, edge[k]), 0, None)
        length = np.bincount(groove, inside * box[:, 2], minlength=40)
        for i, (a, b) in enumerate(((0, 14), (14, 28), (28, 40))):
            size = (b - a) * 50_000 * (edge[k + 1] - edge[k])
            drawn[k, i] = length[a:b].sum() / size
    assert np.abs(mask.ratio_map(0.7) - drawn).max() < 1e-9


@pytest.mark.parametrize(("film", "pattern"), masks())
def test_every_groove_has_the_wanted_ratio(film, pattern):
    mask = build_mask(film, PROCESS, rules(pattern), "job")
    if isinstance(film, PrismFilm):
        wanted = PROCESS.aperture_ratio_of_curvature(film.curvature)
    else:
        y = (np.arange(4000) + 0.5) * (LENGTH / 4000)
        curvature = film.curvature_at(film.groove_position[:, None], y[None])
        wanted = PROCESS.aperture_ratio_of_curvature(curvature).mean(axis=1)
    assert np.abs(mask.wanted_ratio - wanted).max() < 1e-5
    limit = 1e-5  # the 1 nm grid
    if pattern == "error-diffused":
        limit = ONE_DOT
    elif isinstance(film, FieldFilm):
        limit = 1e-4  # levels are 2.5e-4 apart
    assert np.abs(mask.aperture_ratio - wanted).max() <= limit


@pytest.mark.parametrize("pattern", PATTERNS_1D)
@settings(max_examples=15)
@given(curvature=st.floats(30, 63.5))
def test_any_makeable_ratio_is_reached(pattern, curvature):
    mask = build_mask(film_of([curvature] * 3), PROCESS, rules(pattern), "job")
    wanted = PROCESS.aperture_ratio_of_curvature(curvature)
    limit = ONE_DOT if pattern == "error-diffused" else 2e-5
    assert np.abs(mask.aperture_ratio - wanted).max() <= limit


@pytest.mark.parametrize("pattern", ["staggered", "angled"])
def test_lattices_lean_as_asked(pattern):
    mask = build_mask(film_of([60.0] * 8), PROCESS, rules(pattern, angle=30 * deg), "job")
    middle = mask.bottom + mask.along / 2
    step = 25_000 if pattern == "staggered" else round(50_000 * np.tan(np.pi / 6))
    moved = (np.diff(middle) - step) % 50_000
    assert np.minimum(moved, 50_000 - moved).max() <= 2
    assert set(mask.count) == {400, 399}


def test_blue_noise_columns_are_even_by_themselves():
    order = rank_columns(20, 20)
    assert np.array_equal(np.sort(order, axis=1), np.tile(np.arange(20), (20, 1)))
    for number in (2, 4, 5, 10):
        cells = np.sort(order[:, :number], axis=1)
        gap = np.diff(cells, axis=1, append=cells[:, :1] + 20)
        assert gap.max() <= 2 * 20 / number
    # and no two neighbours are the same
    dots = np.zeros((20, 20))
    np.put_along_axis(dots, order[:, :4], 1, axis=1)
    beside = np.mean(dots * np.roll(dots, 1, axis=0)) / dots.mean() ** 2
    assert beside < 0.3


def test_error_diffusion_keeps_any_stretch_of_a_groove_right():
    mask = build_mask(field_film(), PROCESS, rules("error-diffused"), "job")
    position = np.linspace(0, LENGTH, 401)
    error = mask.open_length(0, 40, position) - mask.wanted_length(0, 40, position)
    assert np.abs(error).max() < 2 * 0.04**2 / 0.05  # two dots of 40 µm [mm]


def test_levelling_takes_a_short_period_away_and_leaves_a_long_one():
    """A Gauss curve damps harmonic k, 2 a sinc(k a), by exp(-2 π² k² σ²/P²)."""
    wanted = float(PROCESS.aperture_ratio_of_curvature(60.0))
    short = levelling_residual(build_mask(film_of([60.0] * 4, 60.0), PROCESS, rules("slot"), "j"))
    assert short.worst < 1e-4
    long = MaskRules("slot", 2.0, 0.010, 0.010, levelling_length=1.0)
    left = levelling_residual(build_mask(film_of([60.0] * 4, 60.0), PROCESS, long, "j"))
    sigma = 1.0 / FULL_WIDTH
    k = np.array([1, 2])
    harmonic = 2 * wanted * np.sinc(k * wanted) * np.exp(-2 * (np.pi * k * sigma / 2.0) ** 2)
    assert left.worst == pytest.approx(harmonic.sum(), rel=0.01)
    assert left.rms == pytest.approx(np.hypot(*harmonic) / 2**0.5, rel=0.02)
    assert left.mean_ratio == pytest.approx(wanted, rel=1e-6)


def test_the_same_map_gives_the_same_mask_and_another_does_not():
    one, two = (build_mask(field_film(), PROCESS, rules("error-diffused"), "j") for _ in "ab")
    other = build_mask(field_film(high=63.1), PROCESS, rules("error-diffused"), "j")
    assert np.array_equal(one.is_dot, two.is_dot)
    assert one.content_hash == two.content_hash != other.content_hash


def refused(film, asked):
    with pytest.raises(InputError) as error:
        build_mask(film, PROCESS, asked, "job")
    assert "\n" not in str(error.value)
    return str(error.value)


def test_what_a_pattern_cannot_reach_is_refused():
    small = rules("error-diffused", dot=0.010)
    assert "grooves 0-39: aperture_ratio" in refused(field_film(), small)
    assert "expected 0 or 0.0001 … 0.04" in refused(film_of([60.0] * 40), small)
    assert "mask.dot_um: 45: expected 8 … 40 µm" in refused(
        field_film(), rules("error-diffused", dot=0.045)
    )
    assert "mask.dot_um: 9: expected 11.31 … 40 µm" in refused(
        field_film(), rules("blue-noise", dot=0.009)
    )
    coarse = MaskRules("blue-noise", 0.05, 0.025, 0.010, levelling_length=0.2)
    assert "groove 1: aperture_ratio" in refused(film_of([50.0, 64.0]), coarse)
    words = (
        "mask.pattern: angled: expected 'slot', 'dot', 'blue-noise' or 'error-diffused' for a map"
    )
    assert words in refused(field_film(), rules("angled"))


def test_closed_stretches_of_a_field_stay_closed():
    x, y = np.array([0.0, 2.0]), np.array([0.0, 9.0, 11.0, 20.0])
    curvature = np.tile([[55.0], [55.0], [80.0], [80.0]], (1, 2))
    film = FieldFilm(BEF, LENGTH, 40, CurvatureField(x, y, curvature))
    mask = build_mask(film, PROCESS, rules("error-diffused"), "job")
    assert mask.ratio_map(1.0)[12:].max() == 0
    assert mask.ratio_map(1.0)[:8].min() > 0.08
