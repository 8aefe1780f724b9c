"""A halftone: which pieces are printed, and what levelling makes of them."""

import itertools

import numpy as np
import pytest
from scipy.special import erf

from mpfcad.errors import InputError
from mpfcad.film import CurvatureSeries, Groove, build_halftone, modulation_left
from mpfcad.film.field.halftone import blocks_of
from mpfcad.film.process.levelling import FULL_WIDTH, levelled_fill

GROOVE = Groove(0.050, 0.025)
PRINTED, BARE = 62.0, 80.0


def tone(n=96, m=12, mean=74.0, sine=0.0):
    u, v = (np.arange(n) + 0.5) / n, (np.arange(m) + 0.5) / m
    found = CurvatureSeries(np.array([[mean, 2.0], [2.5, -0.7]])).at(u, v)
    return found + sine * np.sin(2 * np.pi * u)[:, None]


@pytest.mark.parametrize("alike", [1, 2, 4])
@pytest.mark.parametrize("mean", [67.4, 72.3, 74.6])
def test_the_mean_of_the_map_is_kept_and_its_symmetry(mean, alike):
    wanted = tone(mean=mean)
    halftone = build_halftone(GROOVE, PRINTED, wanted, alike)
    level = halftone.two_level
    assert set(np.unique(level)) == {PRINTED, BARE}
    assert np.array_equal(level, level[::-1]) and np.array_equal(level, level[:, ::-1])
    quarter = wanted.size / alike / 4
    assert abs(level.mean() - wanted.mean()) < (BARE - PRINTED) / quarter
    blocks = level.reshape(-1, alike, level.shape[1])
    assert np.array_equal(blocks, np.repeat(blocks[:, :1], alike, axis=1))
    # Over squares of 24 grooves by 4 pieces as well: an error is handed on, not piled up. Along a
    # side of 24 errors of less than half a piece come and go, twice where the map is mirrored.
    square = [part.reshape(4, 24, 3, 4).mean(axis=(1, 3)) for part in (level, wanted)]
    assert np.abs(square[0] - square[1]).max() < 5 * (BARE - PRINTED) * alike**0.5 / 96


@pytest.mark.parametrize("share", [0.35, 0.5, 0.07, 2 / 3])
@pytest.mark.parametrize("columns", [6, 12])
def test_rows_of_pieces_have_their_share_and_no_stripes(share, columns):
    """Error diffusion of two dimensions prints every third row wholly at a share of 1/3."""
    wanted = np.full((960, columns), BARE - share * (BARE - PRINTED))
    level = build_halftone(GROOVE, PRINTED, wanted, 6).two_level
    wave = 2 * np.abs(np.fft.fft2(level)) / level.size
    wave[0, 0] = 0.0
    assert wave[:6, :6].max() < 1.0  # of 18; 6 with stripes


def test_blocks_of_grooves_are_alike_and_mirrored():
    for count, width in itertools.product(range(1, 300), (1, 2, 3, 8, 33)):
        block = blocks_of(count, width)
        assert np.array_equal(block, block[-1] - block[::-1])
        size = np.bincount(block)
        assert size.sum() == count and np.ptp(size) <= 1
        assert size.min() >= min(width, count)


def test_a_small_share_is_kept_in_short_rows():
    """What error diffusion loses at the edges of six pieces would be all of a share of 1 %."""
    wanted = np.full((400, 12), BARE - 0.01 * (BARE - PRINTED))
    halftone = build_halftone(GROOVE, PRINTED, wanted)
    assert abs(halftone.printed.sum() - 48) <= 4


def test_a_lopsided_map_keeps_its_mean():
    wanted = tone(sine=1.3)
    level = build_halftone(GROOVE, PRINTED, wanted).two_level
    assert abs(level.mean() - wanted.mean()) < (BARE - PRINTED) / wanted.size
    assert not np.array_equal(level, level[::-1])


def test_ends_are_all_printed_and_all_bare():
    for value, share in ((PRINTED, 1.0), (BARE, 0.0)):
        assert build_halftone(GROOVE, PRINTED, np.full((8, 6), value)).share == share
    with pytest.raises(InputError, match=r"61\.9 … 80 /mm over the cell: expected 62 … 80"):
        build_halftone(GROOVE, PRINTED, np.linspace(61.9, 80, 12).reshape(2, 6))


def test_levelling_keeps_the_resin():
    halftone = build_halftone(GROOVE, PRINTED, tone())
    printed = halftone.printed.mean(axis=1) * GROOVE.fill_fraction(PRINTED)
    for length in (0.2, 1.0, 7.0):
        for shift in ((0.0, 0.0), (0.05, 0.0), (0.0, 0.77)):
            levelled = halftone.levelled(4.0, 16, length, shift=shift)
            fill = GROOVE.fill_fraction(levelled).mean(axis=1)
            wanted = np.roll(printed, round(shift[0] / 0.05))
            assert fill == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def gauss(y, start, length, levelling):
    """Return a piece averaged with the Gauss curve: (erf((y-a)/√2 σ) - erf((y-b)/√2 σ))/2."""
    wide = 2**0.5 * levelling / FULL_WIDTH
    return (erf((y - start) / wide) - erf((y - start - length) / wide)) / 2


def test_small_differences_level_as_a_gauss_curve_averages():
    """A step of 1 % between long pieces: f(y) = 1 + 0.01 Φ(y/σ), an error function."""
    length, levelling, parts = 6.0, 0.8, 600
    fill = 0.05 * np.array([[1.0, 1.01]])
    found = levelled_fill(fill, length, parts, levelling, 0.05)[0] / 0.05 - 1
    y = (np.arange(2 * parts) + 0.5) * length / parts
    expected = sum(gauss(y, turn * length, length, 0.8) for turn in (-1, 1, 3))
    assert np.abs(found - 0.01 * expected).max() < 1e-4


def test_a_drop_in_a_bare_groove_spreads_as_barenblatt_s():
    """A = t^-1/(m+1) (c - k z²/t^2/(m+1))^1/(m-1), m = 3/2, of dA/dt = d²(A^m)/dz²."""
    m, kappa = 1.5, 0.5 / (2 * 1.5 * 2.5)

    def drop(z, t):
        return t ** (-1 / (m + 1)) * np.maximum(1 - kappa * z**2 * t ** (-2 / (m + 1)), 0) ** 2

    count, length = 4000, 0.005
    z = (np.arange(count) + 0.5) * length - count * length / 2
    first, last = 1.0, 2.5
    # (2/3) σ²/2 is the time; σ = FWHM/2.355.
    levelling = FULL_WIDTH * np.sqrt(3 * (last - first))
    start = drop(z, first)[None]
    found = levelled_fill(start, length, 1, levelling, 1.0)
    assert np.abs(found - drop(z, last)).max() < 1e-3
    coarse = start.reshape(1, 80, 50).mean(axis=2)
    found = levelled_fill(coarse, 50 * length, 1, levelling, 1.0)
    assert np.abs(found - drop(z, last).reshape(80, 50).mean(axis=1)).max() < 0.01


def test_long_pieces_stay_in_the_middle_and_short_ones_become_even():
    wanted = np.tile([[PRINTED, BARE]], (1, 6))
    halftone = build_halftone(GROOVE, PRINTED, wanted)
    assert np.array_equal(halftone.two_level, wanted)
    long = halftone.levelled(5.0, 25, 1.0)
    assert abs(long[0, 12] - PRINTED) < 1e-3 and abs(long[0, 37] - BARE) < 1e-12
    half = float(GROOVE.curvature_of_fill(GROOVE.fill_fraction(PRINTED) / 2))
    assert halftone.levelled(0.2, 8, 1.0) == pytest.approx(half, abs=1e-3)
    # Resin, not C, is kept: spread out, it covers more of the walls.
    assert half < (PRINTED + BARE) / 2 - 1.5
    for length in (0.5, 1.0, 2.0, 4.0):
        fill = GROOVE.fill_fraction(halftone.levelled(length, 201, 1.0))
        left = (fill.max() - fill.min()) / (fill.max() + fill.min())
        assert left == pytest.approx(modulation_left(length, 1.0), abs=0.01)


def test_a_print_beside_its_grooves_falls_into_both():
    halftone = build_halftone(GROOVE, PRINTED, tone(), 4)
    fill = [
        GROOVE.fill_fraction(halftone.levelled(4.0, 8, 0.5, shift=(x, 0.0)))
        for x in (0.0, 0.05, 0.0125, -0.0125)
    ]
    assert fill[1] == pytest.approx(np.roll(fill[0], 1, axis=0), abs=1e-12)
    # A quarter of a groove aside: a block's edge falls into two, which then hold it together.
    for moved, sign in ((fill[2], 1), (fill[3], -1)):
        split = 0.75 * fill[0] + 0.25 * np.roll(fill[0], sign, axis=0)
        assert moved.mean(axis=1) == pytest.approx(split.mean(axis=1), rel=1e-9)
        assert np.abs(moved - split).max() < 0.2 * halftone.fill


def test_along_a_shift_of_parts_is_a_roll():
    halftone = build_halftone(GROOVE, PRINTED, tone())
    still, moved = (halftone.levelled(4.0, 8, 0.7, shift=(0.0, y)) for y in (0.0, -1.5))
    fill = [GROOVE.fill_fraction(c) for c in (np.roll(still, -3, axis=1), moved)]
    assert fill[1] == pytest.approx(fill[0], rel=1e-9, abs=1e-14)


def test_a_gauss_curve_would_run_further_into_bare_groove():
    """Pieces of 4 levelling lengths, every other one printed: what the Gauss curve is off by."""
    length, parts, fill = 4.0, 200, float(GROOVE.fill_fraction(PRINTED))
    found = levelled_fill(np.array([[fill, 0.0]]), length, parts, 1.0, fill)[0] / fill
    y = (np.arange(2 * parts) + 0.5) * length / parts
    curve = sum(gauss(y, turn, length, 1.0) for turn in (-2 * length, 0.0, 2 * length))
    assert found.sum() == pytest.approx(curve.sum(), rel=1e-9)
    beside = (y > length) & (y < 1.5 * length)
    front = [(y[beside & (part > 1e-4)]).max() - length for part in (found, curve)]
    mean = [float(GROOVE.curvature_of_fill(fill * part).mean()) for part in (found, curve)]
    # Sharp ends have 71; the flow takes 0.9 /mm off that, a Gauss curve would take 1.45.
    assert mean == pytest.approx([70.09, 69.55], abs=0.02)
    assert front == pytest.approx([0.60, 1.57], abs=0.05)
    assert np.abs(found - curve).max() < 0.09
