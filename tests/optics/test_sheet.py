"""Sheets: moves drawn as their density says, reciprocal, and none of the light kept."""

import math

import numpy as np
import pytest
from harness import compiled, pass_layers, within

from mpfcad.errors import InputError
from mpfcad.optics import sheet as kernels
from mpfcad.optics.base.sampling import RNG_SIZE, start_path
from mpfcad.optics.element import Sheet
from mpfcad.optics.lowering import Shared, lower_element
from mpfcad.optics.scene import build_scene

SHEETS = {
    "round": Sheet(0.2, 1.5, 1.0),
    "elliptic": Sheet(0.3, 1.5, 1.0, sigma_across=0.05),
    "askew": Sheet(0.3, 1.5, 1.0, sigma_across=0.08, axis=0.6),
    "two lobes": Sheet(0.05, 1.5, 1.0, wide_sigma=0.4, wide_share=0.3),
    "all": Sheet(0.04, 1.5, 1.0, sigma_across=0.15, axis=-1.1, wide_sigma=0.3, wide_share=0.2),
}


def row(sheet):
    return lower_element(sheet, Shared())[1]


def moves(sheet, count, seed=3):
    """Return moves (n, 2) of a sheet."""
    draw, rng = compiled(kernels.sheet_move), np.zeros(RNG_SIZE, np.uint64)
    compiled(start_path)(rng, np.uint64(seed), np.uint64(0), np.uint64(0))
    parameter = row(sheet)
    return np.array([draw(parameter, rng) for _ in range(count)])


@pytest.fixture(scope="module")
def density():
    return compiled(kernels.move_density)


@pytest.mark.parametrize("name", SHEETS)
def test_moves_are_drawn_from_their_density(name, density):
    # χ² over square cells; the density's integral over a cell by 6 × 6 points of Gauss.
    sheet, count, cells, half = SHEETS[name], 40_000, 14, 0.7
    drawn = moves(sheet, count)
    edge = np.linspace(-half, half, cells + 1)
    found, *_ = np.histogram2d(*drawn.T, bins=(edge, edge))
    node, weight = np.polynomial.legendre.leggauss(12)
    width = edge[1] - edge[0]
    at = (edge[:-1, None] + (node + 1) / 2 * width).ravel()
    value = np.array([[density(row(sheet), x, y) for y in at] for x in at])
    value = value.reshape(cells, 12, cells, 12)
    expected = np.einsum("iajb,a,b->ij", value, weight, weight) * width**2 / 4 * count
    assert expected.sum() == pytest.approx(count, rel=0.25)
    many = expected > 8
    rest = np.array([count - expected[many].sum()])
    seen = np.append(found[many], count - found[many].sum())
    wanted = np.append(expected[many], rest)
    chi2 = ((seen - wanted) ** 2 / np.maximum(wanted, 1)).sum()
    freedom = len(seen) - 1
    within(chi2, freedom, np.sqrt(2 * freedom), 4, name)


def test_the_density_is_that_of_the_closed_form(density):
    # A covariance matrix about the axis, inverted; the wide lobe beside it.
    one = SHEETS["all"]
    c, s = math.cos(one.axis), math.sin(one.axis)
    turn = np.array([[c, -s], [s, c]])
    covariance = turn @ np.diag([one.sigma**2, one.sigma_across**2]) @ turn.T
    inverse, size = np.linalg.inv(covariance), math.sqrt(np.linalg.det(covariance))
    for move in ((0.0, 0.0), (0.03, 0.1), (-0.1, 0.2), (0.2, -0.05)):
        m = np.array(move)
        narrow = math.exp(-m @ inverse @ m / 2) / (2 * math.pi * size)
        wide = math.exp(-m @ m / 2 / 0.09) / (2 * math.pi * 0.09)
        assert density(row(one), *move) == pytest.approx(0.8 * narrow + 0.2 * wide, rel=1e-12)


def test_moves_have_the_widths_about_the_axis():
    one, count = SHEETS["askew"], 20_000
    c, s = math.cos(one.axis), math.sin(one.axis)
    drawn = moves(one, count) @ np.array([[c, -s], [s, c]])
    for i, sigma in enumerate((one.sigma, one.sigma_across)):
        within(drawn[:, i].std(), sigma, sigma / math.sqrt(2 * count), 4)
    within(np.mean(drawn[:, 0] * drawn[:, 1]), 0, 0.3 * 0.08 / math.sqrt(count), 4)


def test_a_round_sheet_moves_bit_for_bit_as_one_gaussian():
    from mpfcad.optics.base.sampling import gaussian_pair

    pair, rng = compiled(gaussian_pair), np.zeros(RNG_SIZE, np.uint64)
    compiled(start_path)(rng, np.uint64(3), np.uint64(0), np.uint64(0))
    plain = 0.2 * np.array([pair(rng) for _ in range(200)])
    assert np.array_equal(moves(SHEETS["round"], 200), plain)
    said = Sheet(0.2, 1.5, 1.0, sigma_across=0.2, axis=0.4, wide_sigma=1.0)
    assert np.array_equal(moves(said, 200), plain)


@pytest.mark.parametrize("name", ["askew", "all"])
def test_lambertian_light_from_both_sides_leaves_lambertian(name):
    scene, count, k = build_scene([SHEETS[name], SHEETS["two lobes"]]), 60_000, []
    for below in (True, False):
        out = np.empty((count, 4))
        pass_layers(scene, below, 53 + below, out)
        assert (out[:, 3] == 1).all()
        k.append(out[out[:, 0] == 1, 1:3])
    k = np.concatenate(k)
    within(len(k), count, math.sqrt(count / 2), 4)
    radius, azimuth = (k**2).sum(axis=1), np.arctan2(k[:, 1], k[:, 0])
    number, *_ = np.histogram2d(radius, azimuth, (8, 10), ((0, 1), (-np.pi, np.pi)))
    chi2 = ((number - count / 80) ** 2 / (count / 80)).sum()
    within(chi2, 80, math.sqrt(160), 4)


def test_a_sheet_is_reciprocal():
    # Light from each of two directions that ends within a small square about the other one's
    # mirror image, per projected solid angle: the same both ways, and for light from above.
    passage, rng = compiled(kernels.sheet_passage), np.zeros(RNG_SIZE, np.uint64)
    compiled(start_path)(rng, np.uint64(5), np.uint64(0), np.uint64(0))
    parameter, half, count = row(SHEETS["all"]), 0.08, 120_000
    ends = np.array([[0.1, -0.2], [0.22, -0.12]])
    found = []
    for start, end in (ends, -ends[::-1]):
        inside = 0
        spread = np.random.default_rng(1).uniform(-half, half, (count, 2))
        for kx, ky in start + spread:
            passed, ax, ay, _ = passage(
                parameter, kx, ky, math.sqrt(1 - kx * kx - ky * ky), None, rng
            )
            inside += passed and abs(ax - end[0]) < half and abs(ay - end[1]) < half
        found.append(inside)
    assert min(found) > 3000
    within(found[0] - found[1], 0, math.sqrt(sum(found)), 4)


@pytest.mark.parametrize(
    ("more", "word"),
    [
        ({"sigma_across": -0.1}, "sigma_across: -0.1"),
        ({"axis": math.nan}, "axis: nan"),
        ({"wide_share": 1.2}, "wide_share: 1.2"),
        ({"wide_sigma": -1.0}, "wide_sigma: -1"),
    ],
)
def test_unsound_lobes_are_refused(more, word):
    with pytest.raises(InputError, match=word):
        Sheet(0.2, 1.5, 1.0, "haze", **more)


def test_a_lobe_askew_is_not_its_mirror_image():
    assert not SHEETS["askew"].is_mirrored(20.0)
    assert all(SHEETS[name].is_mirrored(20.0) for name in ("round", "elliptic", "two lobes"))
    assert Sheet(0.2, 1.5, 1.0, sigma_across=0.1, axis=math.pi / 2).is_mirrored(20.0)


def test_a_narrow_sheet_passes_what_its_faces_pass():
    # Normal light through a very narrow lobe: (1-R)/(1+R) of both faces, R = 0.04.
    passage, rng = compiled(kernels.sheet_passage), np.zeros(RNG_SIZE, np.uint64)
    compiled(start_path)(rng, np.uint64(6), np.uint64(0), np.uint64(0))
    parameter = row(Sheet(1e-3, 1.5, 1.0, sigma_across=2e-3, wide_sigma=3e-3, wide_share=0.5))
    passed = np.mean([passage(parameter, 0.0, 0.0, 1.0, None, rng)[0] for _ in range(20_000)])
    within(passed, 0.96 / 1.04, math.sqrt(0.923 * 0.077 / 20_000), 4)
