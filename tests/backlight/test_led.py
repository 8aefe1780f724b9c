"""Stacks of LEDs: lattices, lists, emission files, binning, and every refusal."""

import json
import math

import numpy as np
import pytest
from harness import BARE, film_mesh

from mpfcad.backlight import read_stack, restore_spec
from mpfcad.backlight.lower import lower_stack
from mpfcad.backlight.source.emission import batwing, cosine, polar_angles, read_emission
from mpfcad.backlight.source.lattice import is_mirrored, overlap
from mpfcad.errors import InputError
from mpfcad.optics.cavity.board import Board

PRESETS = ("led-automotive-6mm", "led-tv-20mm", "mini-led-4mm")


def write(tmp_path, source, values="", name="own.toml"):
    path = tmp_path / name
    text = f'extends = "led-automotive-6mm"\n[source]\nkind = "leds"\n{source}\n[value]\n{values}\n'
    path.write_text(text, encoding="utf-8")
    return path


def refused(path, *words):
    with pytest.raises(InputError) as caught:
        read_stack(path)
    text = str(caught.value)
    assert "\n" not in text and "expected" in text
    for word in words:
        assert word in text, text


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_complete_and_lowered(tmp_path, name):
    stack = read_stack(name)
    entries = {entry["name"]: entry for entry in stack.inputs()}
    assert all(e["tag"] in ("given", "sourced", "assumed") for e in entries.values())
    assert entries["led_lattice"]["value"] == "square" and "lamp_count" not in entries
    assert stack.source.edge == "" and stack.source.is_mirrored
    board = lower_stack(stack, film_mesh(tmp_path, [BARE]))[0]
    assert isinstance(board, Board) and board.flux == stack["led_flux_lm"]
    count = {"led-automotive-6mm": 216, "led-tv-20mm": 112, "mini-led-4mm": 3234}[name]
    assert stack.source.count == count
    assert stack.source.flux == pytest.approx(count * stack["led_flux_lm"])


@pytest.mark.parametrize(
    ("lattice", "period", "count"),
    [("square", (12.15, 12.15), 1), ("staggered", (12.15, 24.3), 2),
     ("hexagonal", (12.15, 12.15 * math.sqrt(3)), 2)],
)  # fmt: skip
def test_lattices_repeat_over_their_cells(tmp_path, lattice, period, count):
    source = read_stack(write(tmp_path, f'lattice = "{lattice}"\nemission = "cosine"')).source
    assert source.period == pytest.approx(period) and len(source.placed) == count
    assert source.is_mirrored
    away = source.placed[:, :2] - source.placed[0, :2]
    if count == 2:
        assert np.hypot(*away[1]) == pytest.approx(
            12.15 if lattice == "hexagonal" else math.hypot(12.15 / 2, 12.15)
        )


def test_a_list_with_fluxes_and_repeated_cells(tmp_path):
    (tmp_path / "leds.csv").write_text("x_mm,y_mm,flux_factor\n1,2,1\n7,2,0.5\n")
    stack = read_stack(
        write(tmp_path, 'lattice = "list"\npositions = "leds.csv"\nrepeat = [2, 1]\ndead = [3]')
    )
    placed = stack.source.placed
    assert placed[:, 0] == pytest.approx([1, 7, 13.15, 19.15])
    assert placed[:, 2] == pytest.approx([1, 0.5, 0, 0.5])
    assert stack.period == pytest.approx((24.3, 12.15)) and not stack.source.is_mirrored
    described = json.loads(json.dumps(stack.spec.describe()))
    assert restore_spec(described) == stack.spec
    assert any("leds.csv, SHA-256" in entry["source"] for entry in stack.spec.inputs())


def test_binning_spreads_flux_and_place_the_same_for_a_seed(tmp_path):
    text = 'emission = "cosine"\nrepeat = [20, 20]\nseed = 7'
    values = "led_flux_spread = 0.1\nled_position_error_mm = 0.2"
    one, two = (read_stack(write(tmp_path, text, values)).source for _ in range(2))
    assert np.array_equal(one.placed, two.placed)
    off = one.placed[:, :2] - np.round(one.placed[:, :2] / 12.15) * 12.15
    # 400 LEDs: the spread of a standard deviation is 1/√800 of it; 4σ.
    assert one.placed[:, 2].std() == pytest.approx(0.1, abs=0.1 * 4 / math.sqrt(800))
    assert off.std() == pytest.approx(0.2, abs=0.2 * 4 / math.sqrt(1600))


def test_formulas_of_emission():
    half = np.interp(math.radians(60), polar_angles(), cosine(60.0)[0])
    assert half == pytest.approx(0.5, abs=1e-4)
    for peak in (50.0, 65.0, 75.0):
        assert np.degrees(polar_angles()[batwing(peak)[0].argmax()]) == pytest.approx(peak, abs=0.5)


IES = """IESNA:LM-63-2002
[TEST] a
[MANUFAC] b
TILT=NONE
1 1000 1 {n} 1 1 2 -0.003 -0.003 0
1 1 10
{angles}
0
{values}
"""


def ies(tmp_path, angles, values, name="led.ies"):
    angle, value = (" ".join(map(str, row)) for row in (angles, values))
    (tmp_path / name).write_text(IES.format(n=len(angles), angles=angle, values=value))
    return name


def test_measured_emission_of_ies_and_csv(tmp_path):
    angle = np.arange(0, 91, 5.0)
    light = np.round(100 * np.cos(np.radians(angle)) ** 2, 4)
    table = read_emission("x", tmp_path, ies(tmp_path, angle, light))
    assert np.allclose(table[0], np.interp(np.degrees(polar_angles()), angle, light), atol=1e-3)
    rows = "\n".join(f"{a:g},{v:g}" for a, v in zip(angle, light, strict=True))
    (tmp_path / "led.csv").write_text("angle_deg,intensity\n" + rows)
    assert np.allclose(read_emission("x", tmp_path, "led.csv"), table[:1], atol=0.02)
    stack = read_stack(write(tmp_path, 'emission = "led.ies"'))
    assert stack.spec.emission == "led.ies" and "led.ies" in stack.spec.files
    assert restore_spec(json.loads(json.dumps(stack.spec.describe()))) == stack.spec


def test_bad_emission_files(tmp_path):
    angle = np.arange(0, 91, 10.0)
    light = np.cos(np.radians(angle)) * 100
    broken = [*light[:3], "nan", *light[4:]]
    refused(write(tmp_path, f'emission = "{ies(tmp_path, angle, broken)}"'), "led.ies", "nan")
    refused(write(tmp_path, f'emission = "{ies(tmp_path, angle[:5], light[:5])}"'), "cut off", "40")
    text = (tmp_path / ies(tmp_path, angle, light)).read_text()
    (tmp_path / "short.ies").write_text(text[:-60])
    refused(write(tmp_path, 'emission = "short.ies"'), "short.ies")
    (tmp_path / "dark.csv").write_text("angle_deg,intensity\n0,0\n90,0\n")
    refused(write(tmp_path, 'emission = "dark.csv"'), "some light")
    (tmp_path / "down.csv").write_text("angle_deg,intensity\n0,1\n180,1\n")
    refused(write(tmp_path, 'emission = "down.csv"'), "below the board")
    (tmp_path / "head.csv").write_text("a,b\n0,1\n90,1\n")
    refused(write(tmp_path, 'emission = "head.csv"'), "row 1", "angle_deg,intensity")
    for name in ("none.ies", "none.ldt"):
        refused(write(tmp_path, f'emission = "{name}"'), f"{name}: no such file: expected")
    refused(write(tmp_path, 'emission = "none.csv"'), "none.csv: no such file: expected")
    refused(write(tmp_path, 'emission = "square"'), "square")


CUP = "led_cup_height_mm = 3\nled_cup_radius_mm = {}\nled_cup_rim_radius_mm = {}"


@pytest.mark.parametrize("shape", ["round", "square"])
def test_cups_are_read_described_and_lowered(tmp_path, shape):
    text = f'emission = "cosine"\ncup = "{shape}"'
    values = CUP.format(2, 6.075) + "\nled_cup_specular_fraction = 0.1"
    stack = read_stack(write(tmp_path, text, values))
    cup = lower_stack(stack, film_mesh(tmp_path, [BARE]))[0].cup
    assert (cup.height, cup.radius, cup.rim_radius) == (3, 2, 6.075)
    assert cup.square == (shape == "square")
    assert cup.reflectance == stack["reflector_reflectance"] and cup.specular_fraction == 0.1
    named = {entry["name"]: entry["value"] for entry in stack.inputs()}
    assert named["led_cup"] == shape and named["led_cup_rim_radius_mm"] == 6.075
    assert f"in {shape} cups 3 mm high" in stack.source.emitters().note
    assert restore_spec(json.loads(json.dumps(stack.spec.describe()))) == stack.spec
    plain = read_stack("led-automotive-6mm")
    assert not [e["name"] for e in plain.inputs() if "cup" in e["name"]]
    assert lower_stack(plain, film_mesh(tmp_path, [BARE]))[0].cup is None
    straight = read_stack(write(tmp_path, text, CUP.format(2, 3).rpartition("\n")[0]))
    assert straight["led_cup_rim_radius_mm"] == 2


@pytest.mark.parametrize(
    ("source", "values", "words"),
    [
        ('lattice = "round"', "", ["source.lattice", "round", "hexagonal"]),
        ('lattice = "list"', "", ["source.positions"]),
        ('positions = "a.csv"', "", ["source.positions"]),
        ("size = 3", "", ["source.size", "unknown key"]),
        ("repeat = [0, 1]", "", ["source.repeat"]),
        ("dead = [2]", "", ["source.dead", "LED 2"]),
        ("dead = [1]", "", ["source.dead", "all LEDs"]),
        ("seed = -1", "", ["source.seed"]),
        ("", "led_width_mm = 12.5", ["overlap their own repetition in a cell of 12.15 ×"]),
        ("", "led_height_mm = 7", ["thickness_mm"]),
        ('cup = "hexagonal"', "", ["source.cup", "hexagonal", "round or square"]),
        ("", "led_cup_radius_mm = 3", ["led_cup_radius_mm: 3", "source.cup"]),
        ('cup = "round"', "led_cup_radius_mm = 3", ["led_cup_height_mm: 0", "0.7 mm or more"]),
        ('cup = "round"', "led_cup_height_mm = 0.6", ["led_cup_height_mm: 0.6"]),
        ('cup = "round"', "led_cup_height_mm = 6", ["led_cup_height_mm: 6", "thickness_mm 6"]),
        ('cup = "round"', CUP.format(1.5, 3), ["led_cup_radius_mm: 1.5", "1.98 or more"]),
        ('cup = "square"', CUP.format(1.3, 3), ["led_cup_radius_mm: 1.3", "1.4 or more"]),
        ('cup = "round"', CUP.format(3, 2), ["led_cup_rim_radius_mm: 2", "3 or more"]),
        ('cup = "round"', CUP.format(3, 6.1), ["led_cup_rim_radius_mm: 6.1", "LEDs 1 and 1"]),
        ('cup = "square"\nlattice = "staggered"', CUP.format(3, 6.08), ["LEDs 1 and 1"]),
        (
            'cup = "round"\nlattice = "hexagonal"\nrepeat = [2, 2]',
            CUP.format(3, 6.1),
            ["LEDs 1 and 2"],
        ),
    ],
)
def test_boards_that_cannot_be(tmp_path, source, values, words):
    refused(write(tmp_path, 'emission = "cosine"\n' + source, values), *words)


def test_overlapping_leds_of_a_list_are_named(tmp_path):
    (tmp_path / "leds.csv").write_text("x_mm,y_mm\n1,1\n6,6\n7,8\n")
    refused(
        write(tmp_path, 'lattice = "list"\npositions = "leds.csv"'),
        "LEDs 2 and 3 overlap, 1 mm apart across and 2 mm along: expected",
    )
    for text, word in (("x,y\n1,1\n", "row 1"), ("x_mm,y_mm\n1,a\n", "row 2: y_mm: a")):
        (tmp_path / "leds.csv").write_text(text)
        refused(write(tmp_path, 'lattice = "list"\npositions = "leds.csv"'), word)
    assert overlap(np.array([[0.0, 0, 1], [11.5, 0, 1]]), (12.0, 12.0), (1.0, 1.0)) == (1, 2)


def test_a_lattice_that_does_not_close_on_the_panel_says_so(tmp_path):
    stack = read_stack(write(tmp_path, 'emission = "cosine"', "panel_width_mm = 100"))
    assert "8 × 24 whole cells" in stack.source.edge
    assert stack.source.edge in stack.source.emitters().note


def test_leds_have_no_finite_panel(tmp_path):
    path = write(tmp_path, 'emission = "cosine"')
    path.write_text('extent = "panel"\n' + path.read_text())
    refused(path, "extent", "expected pitch")


def test_mirror_images():
    period = (10.0, 8.0)
    assert is_mirrored(np.array([[0.0, 0, 1], [5.0, 4.0, 1]]), period)
    assert is_mirrored(np.array([[2.0, 0, 1], [-2.0, 0, 1]]), period)
    assert not is_mirrored(np.array([[2.0, 0, 1], [-2.0, 0, 0.5]]), period)
    assert not is_mirrored(np.array([[2.0, 1, 1], [-2.0, -1, 1]]), period)


def rays(count=120_000):
    """Return rays (n, 7) of cos² θ."""
    rng = np.random.default_rng(8)
    cosine, turn = rng.random(count) ** (1 / 3), rng.random(count) * 2 * np.pi
    sine = np.sqrt(1 - cosine**2)
    place = rng.uniform(-1, 1, (count, 3)) * (1, 1, 0)
    direction = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=1)
    return np.concatenate([place, direction, np.full((count, 1), 0.5)], axis=1).astype("<f4")


def ray_file(form, table):
    n = len(table)
    if form == ".tm25ray":
        head = bytearray(36288)
        head[:4] = b"TM25"
        head[20:28] = np.array([n], "<u8").tobytes()
        head[256:288] = np.array([1, 1, 1, 0, 0, 0, 0, 0], "<i4").tobytes()
    elif form == ".dat":
        head = bytearray(208)
        head[:8] = np.array([1010, n], "<u4").tobytes()
    else:
        head = bytearray(44)
        head[:4] = b"LTRF"
    return bytes(head) + table.tobytes()


@pytest.mark.parametrize("form", [".tm25ray", ".dat", ".ray"])
def test_rays_become_intensity(tmp_path, form):
    (tmp_path / f"led{form}").write_bytes(ray_file(form, rays()))
    table = read_emission("x", tmp_path, f"led{form}")
    mean = table.mean(axis=0)
    expected = np.cos(polar_angles()) ** 2
    assert np.allclose(mean / mean[8], expected / expected[8], atol=0.04)
    assert table.shape[0] == 72


@pytest.mark.parametrize("form", [".tm25ray", ".dat", ".ray"])
def test_ray_files_whose_count_and_size_disagree(tmp_path, form):
    name, data = f"led{form}", ray_file(form, rays(1000))
    for wrong in (data[:-5], data[:30]) if form == ".ray" else (data[:-5], data[:-28], data[:300]):
        (tmp_path / name).write_bytes(wrong)
        refused(write(tmp_path, f'emission = "{name}"'), name)
    if form != ".ray":
        (tmp_path / name).write_bytes(data + bytes(28_000))
        refused(write(tmp_path, f'emission = "{name}"'), "count and size disagree")
    table = rays(1000)
    table[3, 4] = np.nan
    (tmp_path / name).write_bytes(ray_file(form, table))
    refused(write(tmp_path, f'emission = "{name}"'), "not finite")
    (tmp_path / name).write_bytes(b"some text that is no ray file")
    refused(write(tmp_path, f'emission = "{name}"'), "expected a TM-25")
