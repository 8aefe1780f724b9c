"""Point spread functions of LEDs: closed form, sums, symmetry; what zones do."""

import math

import numpy as np
import pytest
from harness import BARE, film_mesh

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import (
    TraceRun,
    block_figures,
    camera_image,
    led_spread,
    light_film,
    luminance_over_cell,
)
from mpfcad.measure.cell.block import _Patterns
from mpfcad.measure.cell.spread import SpreadResult, jackknife, ratio_of
from mpfcad.record import describe_camera, describe_spread
from mpfcad.report.drawing.picture import write_pictures
from mpfcad.report.page.spread_part import spread_values

_BOARD = 'extends = "led-automotive-6mm"\n[source]\nkind = "leds"\n'
#: A black board with points of light, and one sheet.
_BLACK = """extends = "led-automotive-6mm"
layers = ["top_sheet"]
[value]
led_width_mm = 0.01
led_length_mm = 0.01
led_height_mm = 0.0
led_reflectance = 0.0
reflector_reflectance = 0.0
sheet_transmission = 0.9
"""


def stack(folder, source="zones = [3, 8]\n"):
    (folder / "board.toml").write_text(_BOARD + source)
    return read_stack(folder / "board.toml")


def bare(folder, source="zones = [3, 8]\n"):
    film_mesh(folder, [BARE])
    return light_film(stack(folder, source).with_bare(folder / "film.stl"), folder / "film.stl")


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    return bare(tmp_path_factory.mktemp("spread"))


@pytest.fixture(scope="module")
def found(lit):
    return led_spread(lit, TraceRun(path_limit=400_000), 0.001)


def test_one_led_through_one_sheet_in_closed_form(tmp_path):
    # L = I(θ) cos θ/r² · density of the sheet · what passes it, of one LED of the lattice.
    (tmp_path / "black.toml").write_text(_BLACK)
    lit = light_film(read_stack(tmp_path / "black.toml"), None)
    found = led_spread(lit, TraceRun(path_limit=300_000), 0.001)
    value, error = found.map_of(0)
    bins, reach = found.bins, found.reach
    fine = 5
    side = len(value) * fine
    place = ((np.arange(side) + 0.5) / (bins * fine) - reach - 0.5) * 12.15
    x, y = np.meshgrid(place, place, indexing="ij")
    far = np.sqrt(x**2 + y**2 + 36.0)
    cosine, sine2 = 6.0 / far, (x**2 + y**2) / far**2

    def reflectance(cosine):
        inner = np.sqrt(1 - (1 - cosine**2) / 1.49**2)
        s = (cosine - 1.49 * inner) / (cosine + 1.49 * inner)
        p = (1.49 * cosine - inner) / (1.49 * cosine + inner)
        return (s**2 + p**2) / 2

    r, normal = reflectance(cosine), reflectance(1.0)
    passed = (1 - r) * (1 - normal) / (1 - r * normal)
    density = np.exp(-sine2 / (2 * 0.35**2)) / (2 * np.pi * 0.35**2)
    exact = 25e6 * cosine / np.pi * cosine / far**2 * density * passed * 0.9
    exact = exact.reshape(side // fine, fine, side // fine, fine).mean(axis=(1, 3))
    near = exact > 0.003 * exact.max()
    off = (value - exact)[near] / error[near]
    count = int(near.sum())
    # Of 31 degrees of freedom: mean square 31/29, variance of the square about 2.5.
    assert count > 100
    assert abs(np.sum(off**2) - count * 31 / 29) < 4.5 * math.sqrt(2.5 * count)
    middle = len(value) // 2
    assert value[middle, middle] == pytest.approx(exact[middle, middle], abs=4 * error.max())


def test_all_leds_together_are_the_uniform_board(lit, found):
    whole = found.uniform()
    mean, error = whole.mean(axis=0), whole.std(axis=0, ddof=1) / math.sqrt(len(whole))
    other = luminance_over_cell(lit, TraceRun(seed=9, path_limit=400_000), half_width_goal=1e-4)
    bins = found.bins
    step = len(other.luminance) // bins
    value = other.luminance.reshape(bins, step, bins, step).mean(axis=(1, 3))
    own = (other.standard_error**2).reshape(bins, step, bins, step).sum(axis=(1, 3))
    off = (mean - value) / np.hypot(error, np.sqrt(own) / step**2)
    assert np.sum(off**2) < 64 * 31 / 29 + 4.5 * math.sqrt(2.5 * 64)
    shares = found.share().mean(axis=0)[0]
    assert shares.sum() + found.beside.mean() == pytest.approx(1, abs=1e-9)
    assert shares.max() == shares[found.reach, found.reach]


def test_a_mirrored_cell_spreads_light_as_its_mirror_image(found):
    value, error = found.map_of(0)
    light = found.batch[:, 0].sum(axis=(2, 4))
    for axis in (1, 2):
        off = light - np.flip(light, axis=axis)
        mean, spread = off.mean(axis=0), off.std(axis=0, ddof=1) / math.sqrt(len(off))
        half = np.take(mean, range(found.reach), axis=axis - 1)
        sigma = half / np.take(spread, range(found.reach), axis=axis - 1)
        assert np.sum(sigma**2) < sigma.size * 31 / 29 + 4.5 * math.sqrt(2.5 * sigma.size)
    assert value[error > 0].min() >= 0


def test_zones_add_up_to_the_board(lit, found):
    board = lit.stack.source
    zones = board.zones
    assert zones.leds == 9 and len(zones.edge) == 24
    patterns = _Patterns(found, board, zones)
    all_cells = (3, 5), (8, 10)
    total = sum(
        patterns.luminance(zones.number == number, *all_cells) for number in range(len(zones.edge))
    )
    whole = patterns.luminance(np.ones_like(zones.number, dtype=bool), *all_cells)
    assert np.allclose(total, whole, rtol=1e-12)
    assert np.allclose(whole[:, :8, :8], found.uniform(), rtol=1e-12)
    block = block_figures(found, board, 1)
    assert block.white.value + block.black.value == pytest.approx(1, abs=1e-9)
    assert block.contrast.value == pytest.approx(block.white.value / block.black.value)
    # Of the light of nine LEDs most leaves outside; on a checkerboard white is brighter.
    assert block.halo.low > 0.5 and block.checkerboard.low > 1
    assert block.even[0].high < block.even[1].low
    # The line through the middle is highest inside.
    inside = np.abs(block.across.place) < 18
    assert block.across.luminance[inside].min() > block.across.luminance[~inside].min()
    assert block.across.place.min() > -60  # it ends with the panel


def test_a_block_of_light_that_stays_has_no_halo():
    # Each LED lights its own cell alone, evenly: no halo, black blocks are black.
    class Board:
        cells, origin = (4, 4), (5.0, 5.0)

    rng = np.random.default_rng(3)
    batch = np.zeros((32, 1, 7, 8, 7, 8))
    batch[:, :, 3, :, 3, :] = 100 * (1 + 0.01 * rng.standard_normal((32, 1, 8, 8)))
    spread = SpreadResult((10.0, 10.0), np.zeros((1, 2)), batch, np.zeros(32), 1)
    from mpfcad.backlight.source.zone import ZoneSpec, lay_zones

    place = np.arange(4) * 10.0 + 5
    led = np.stack(np.meshgrid(place, place, indexing="ij"), axis=-1)[None]
    board = Board()
    board.origin = (15.0, 15.0)
    board.zones = lay_zones("z", ZoneSpec((2, 2)), led, (40.0, 40.0), (40.0, 40.0))
    block = block_figures(spread, board, 1)
    assert block.halo.value == pytest.approx(0, abs=1e-12)
    assert (
        block.contrast is None
        and block.white.value == pytest.approx(1)
        and block.black.value == pytest.approx(0)
    )
    assert block.even[0].value == pytest.approx(1, abs=0.02)


def test_intervals_of_ratios_hold_the_truth():
    rng, held, runs = np.random.default_rng(5), 0, 400
    for _ in range(runs):
        a = rng.gamma(4.0, 1.0, 32)
        b = 0.5 * a + rng.gamma(2.0, 1.0, 32)
        found = ratio_of(a, b)
        held += found.low <= 1.0 <= found.high
    # 95 % of 400 is 380 ± 4.4.
    assert 365 <= held <= 395
    constant = jackknife(lambda weight: float(weight @ np.ones(32) / weight.sum()), 32)
    assert constant.value == constant.low == constant.high == 1


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("zones = [0, 2]\n", r"\[0, 2\]: expected \[across, along\]"),
        ("zones = [20, 8]\n", "no LED in it"),
        ("zones = [3, 8]\nrepeat = [2, 1]\n", "expected \\[1, 1\\]"),
        ('zones = "none.csv"\n', "none.csv"),
        ('zones = "zones.csv"\n', "in no zone: expected one"),
        ('zones = "over.csv"\n', "in zones 1 and 2"),
        ('zones = "turned.csv"\n', "row 2: .*left_mm below right_mm"),
    ],
)
def test_wrong_zones_are_refused_in_a_line(tmp_path, source, words):
    head = "left_mm,right_mm,bottom_mm,top_mm\n"
    (tmp_path / "zones.csv").write_text(head + "0,50,0,292\n")
    (tmp_path / "over.csv").write_text(head + "0,110,0,292\n0,110,0,292\n")
    (tmp_path / "turned.csv").write_text(head + "50,0,0,292\n")
    with pytest.raises(InputError, match=words) as error:
        stack(tmp_path, source)
    assert len(str(error.value)) <= 300


def test_zones_of_a_list(tmp_path):
    head = "left_mm,right_mm,bottom_mm,top_mm\n"
    rows = "0,54.75,0,146\n54.75,110,0,146\n0,54.75,146,292\n54.75,110,146,292\n"
    (tmp_path / "zones.csv").write_text(head + rows)
    board = stack(tmp_path, 'zones = "zones.csv"\n').source
    assert board.zones.colour.tolist() == [0, 1, 1, 0]
    assert np.bincount(board.zones.number.ravel()).sum() == 216
    (tmp_path / "zones.csv").write_text(
        head + rows.replace("0,54.75,0,146\n54.75,110,0,146\n", "0,110,0,146\n")
    )
    assert stack(tmp_path, 'zones = "zones.csv"\n').source.zones.colour is None


def test_record_page_and_picture(lit, found, tmp_path):
    record = describe_spread(found, block_figures(found, lit.stack.source, 1))
    values = spread_values(record)
    assert len(values["rows"]) == 3 and len(values["block"]["rows"]) == 7
    camera = describe_camera(camera_image(lit, TraceRun(path_limit=60_000), 0.05))
    assert camera["cells"] == [4, 4] and len(camera["luminance_cd_m2"]) == 13
    write_pictures(tmp_path, camera, True)
    from tifffile import imread

    picture = imread(tmp_path / "camera.tif")
    assert picture.shape == (52, 52)
    assert np.array_equal(picture[:13, :13], picture[13:26, 39:])


def test_maps_of_too_many_leds_are_refused(tmp_path):
    lit = bare(tmp_path, "repeat = [3, 6]\n")
    with pytest.raises(InputError, match="18 LEDs are traced together"):
        led_spread(lit, TraceRun(), 0.1)


def test_several_leds_of_a_cell_have_maps_of_their_own(tmp_path):
    # Two LEDs of flux 1 and 3 in a cell: each alone, and the share of light of each.
    (tmp_path / "led.csv").write_text("x_mm,y_mm,flux_factor\n0,0,1\n6,0,3\n")
    source = 'lattice = "list"\npositions = "led.csv"\n'
    found = led_spread(bare(tmp_path, source), TraceRun(path_limit=1), 1.0)
    light = found.batch.sum(axis=(0, 2, 3, 4, 5))
    # Of 262,144 paths: relative standard error about 1.5/√65,000.
    assert light[1] / light[0] == pytest.approx(3, abs=4 * 3 * 1.7 / math.sqrt(65_000))
    whole = found.share().mean(axis=0).sum(axis=(1, 2)) + found.beside.mean()
    assert whole == pytest.approx(np.ones(2), abs=1e-9)


def test_a_spread_is_the_same_at_any_number_of_threads(lit):
    one, two = (led_spread(lit, TraceRun(path_limit=1, threads=n), 1.0) for n in (1, 2))
    assert np.array_equal(one.batch, two.batch)
