"""Colour of the screen: chromaticities and their intervals, colour Mura, light through a stack."""

import numpy as np
import pytest
from harness import BARE, film_file

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import TraceRun, light_film, luminance_over_cell, screen_colour
from mpfcad.measure.colour.chromaticity import colour_of, difference, points_of
from mpfcad.measure.colour.mura import colour_mura, largest
from mpfcad.spectrum import chromaticity, matching_functions, planckian, uniform_chromaticity


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch):
    """Trace no more than a test needs."""
    monkeypatch.setattr("mpfcad.measure.colour.screen._LEAST_BLOCKS", 8)


RUNS = 300
#: 95 % ± 3.3 standard errors of so many runs (99.9 %).
LEAST, MOST = 0.95 - 3.3 * np.sqrt(0.95 * 0.05 / RUNS), 0.95 + 3.3 * np.sqrt(0.95 * 0.05 / RUNS)


def simulated(rng, xyz, noise, blocks=64):
    """Return X, Y, Z of blocks: the luminance's noise is common, the colour's is small."""
    xyz = np.asarray(xyz, float)
    common = 1 + 0.05 * rng.normal(size=(blocks, *xyz.shape[:-1], 1))
    return xyz * common * (1 + noise * rng.normal(size=(blocks, *xyz.shape)))


def test_chromaticities_are_held_by_their_intervals():
    rng, xyz = np.random.default_rng(1), np.array([60.0, 50.0, 120.0])
    true = {"luminance": 50.0, **dict(zip("xy", chromaticity(xyz), strict=True)),
            **dict(zip("uv", uniform_chromaticity(xyz), strict=True))}  # fmt: skip
    held = dict.fromkeys(true, 0)
    for _ in range(RUNS):
        found = colour_of(simulated(rng, xyz, 0.02))
        for name, value in true.items():
            held[name] += getattr(found, name).low <= value <= getattr(found, name).high
    assert all(LEAST <= count / RUNS <= MOST for count in held.values()), held


@pytest.mark.parametrize("shift", [0.0, 0.001, 0.02])
def test_a_shift_of_colour_is_held_by_its_interval(shift):
    rng, xyz = np.random.default_rng(2), np.array([60.0, 50.0, 120.0])
    other = xyz * (1.0, 1.0, 1 - shift)
    true = np.hypot(*(uniform_chromaticity(xyz) - uniform_chromaticity(other)))
    held = 0
    for _ in range(RUNS):
        found = difference(simulated(rng, xyz, 0.02), simulated(rng, other, 0.02))
        held += found.low <= true <= found.high
    # Of no shift the interval begins at 0 in all but its upper tail.
    assert LEAST <= held / RUNS <= (1.0 if shift < 0.005 else MOST), held / RUNS


def test_errors_of_points_are_those_of_repeated_runs():
    rng, xyz = np.random.default_rng(3), np.array([[60.0, 50.0, 120.0], [40.0, 50.0, 30.0]])
    runs = [points_of(simulated(rng, xyz, 0.02)) for _ in range(RUNS)]
    spread = np.std([uv for uv, _ in runs], axis=0, ddof=1)
    stated = np.sqrt(np.mean([error**2 for _, error in runs], axis=0))
    np.testing.assert_allclose(spread, stated, rtol=0.15)


SHAPES = {
    "none": lambda x: np.zeros((len(x), 2)),
    "wave": lambda x: np.outer(np.cos(2 * np.pi * x), (0.6, 0.8)),
    "peak": lambda x: np.outer(np.exp(-(((x - 0.5) / 0.06) ** 2)), (0.6, -0.8)),
}


@pytest.mark.parametrize(
    ("name", "noise"), [("none", 0.2), ("wave", 0.05), ("peak", 0.1), ("peak", 0.33)]
)
def test_the_largest_shift_is_held_by_its_interval(name, noise):
    runs, blocks = 60, 32
    away = SHAPES[name](np.linspace(0, 1, 33))
    true, held = np.hypot(*away.T).max(), 0
    for run in range(runs):
        rng = np.random.default_rng(run)
        block = rng.normal(size=(blocks, 33, 2)) * noise * np.sqrt(blocks)
        scatter = (block - block.mean(axis=0)) / np.sqrt(blocks * (blocks - 1))
        found = largest(away + block.mean(axis=0), scatter, blocks - 1, 1)
        held += found.low <= true <= found.high
    assert held / runs >= 0.95 - 3.3 * np.sqrt(0.95 * 0.05 / runs), held / runs


def test_a_known_pattern_of_colour_has_its_mura():
    x = np.linspace(0, 1, 33)
    xyz = np.array([60.0, 50.0, 120.0]) * np.ones((64, 33, 1))
    xyz[..., 2] *= 1 + 0.1 * np.cos(2 * np.pi * x)
    uv, mean = uniform_chromaticity(xyz[0]), uniform_chromaticity(xyz[0].mean(axis=0))
    found = colour_mura(xyz, 1)
    assert found.value == pytest.approx(np.hypot(*(uv - mean).T).max(), rel=1e-12)
    assert (found.low, found.high) == pytest.approx((found.value, found.value), rel=1e-12)


LIGHT = "[light]\nbands = {bands}\nspectrum = {{ {spectrum} }}\n"
PLANCK = "planckian_k = 5000"
BLUE = "peak_nm = 450, fwhm_nm = 20"
QD = (
    '{ kind = "converter", name = "green", absorptance = { table_nm = [[360, 0.25], [480, 0.2], '
    "[520, 0.03], [560, 0], [830, 0]] }, yield = 0.95, "
    "emission = { peak_nm = 535, fwhm_nm = 35 } }, "
    '{ kind = "converter", name = "red", absorptance = { table_nm = [[360, 0.18], [480, 0.14], '
    "[560, 0.04], [640, 0], [830, 0]] }, yield = 0.95, emission = { peak_nm = 625, fwhm_nm = 35 } }"
)


def lit(folder, light, layers='"bottom_sheet", "film", "top_sheet"', value="", base="mpf"):
    path = folder / "stack.toml"
    path.write_text(
        f'extends = "thesis-32in-{base}"\nlayers = ["clear_plate", {layers}]\n'
        f"{light}[value]\n{value}"
    )
    return light_film(read_stack(path), film_file(folder / "film.stl", [BARE] * 4, length=2.0))


def test_a_black_body_keeps_its_colour_through_neutral_elements(tmp_path):
    light = LIGHT.format(bands=8, spectrum=PLANCK)
    found = screen_colour(lit(tmp_path, light), TraceRun(path_limit=1), 1.0)
    xy = chromaticity(planckian(5000) @ matching_functions())
    assert found.mean.x.value == pytest.approx(xy[0], rel=1e-12)
    assert found.mean.y.value == pytest.approx(xy[1], rel=1e-12)
    assert found.mura.high < 1e-12
    assert max(one.high for one in found.shift) < 1e-12
    assert found.mean.luminance.value > 1000


def test_a_yellow_plate_turns_a_black_body_yellow(tmp_path):
    light = LIGHT.format(bands=5, spectrum=PLANCK)
    value = "reflector_reflectance = { table_nm = [[400, 0.8], [500, 0.95], [700, 0.95]] }\n"
    found = screen_colour(lit(tmp_path, light, value=value), TraceRun(path_limit=1), 1.0)
    xy = chromaticity(planckian(5000) @ matching_functions())
    assert found.mean.x.low > xy[0] + 0.005 and found.mean.y.low > xy[1] + 0.005


def test_quantum_dots_make_white_of_blue_and_more_so_where_light_is_recycled(tmp_path):
    # A composite film over quantum dots is published to shift x by 0.010 and y by 0.019: light that
    # is sent back passes the dots again. Here it is the diffuser of a diffuser-on-prism film.
    light = LIGHT.format(bands="[440, 460, 500, 530, 550, 600, 625, 650]", spectrum=BLUE)
    bare, composite = (
        screen_colour(lit(tmp_path, light, f"{QD}, {films}"), TraceRun(path_limit=1), 1.0,
                      directions=False)
        for films in ('"film"', '"film", "top_sheet"')
    )  # fmt: skip
    dx = composite.mean.x.value - bare.mean.x.value
    dy = composite.mean.y.value - bare.mean.y.value
    assert 0.005 < dx < 0.04 and 0.008 < dy < 0.04, (dx, dy)
    assert dx > 8 * bare.mean.x.standard_error and dy > 8 * bare.mean.y.standard_error
    assert bare.power[0] + bare.power[1] > 0.2 and bare.power[3] + bare.power[6] > 0.1


@pytest.mark.slow
def test_leds_have_the_luminance_of_their_bands_and_a_colour_over_the_cell(tmp_path):
    sheet = '"clear_plate", "bottom_sheet"'
    path = tmp_path / "led.toml"
    path.write_text(
        f'extends = "led-tv-20mm"\nlayers = [{sheet}, {QD}, "top_sheet"]\n'
        + LIGHT.format(bands="[440, 460, 500, 530, 550, 600, 625, 650]", spectrum=BLUE)
    )
    film = light_film(read_stack(path), None)
    run = TraceRun(path_limit=1)
    forward = luminance_over_cell(film, run, half_width_goal=1.0)
    backward = screen_colour(film, run, 1.0, directions=False)
    ahead, back = forward.mean_luminance, backward.mean.luminance
    error = np.hypot(ahead.standard_error, back.standard_error)
    assert abs(ahead.value - back.value) < 4 * error, (ahead, back)
    assert error < 0.05 * ahead.value
    assert len(backward.position) == 64 and backward.mean.x.value > 0.17


@pytest.mark.slow
def test_colours_over_a_cell_are_those_of_paths_from_the_meter(tmp_path):
    from mpfcad.measure.colour.screen import _of_parts, _of_points, _over_cell

    path = tmp_path / "led.toml"
    path.write_text(
        f'extends = "led-tv-20mm"\nlayers = ["bottom_sheet", {QD}, "top_sheet"]\n'
        "[light]\nbands = [440, 460, 530, 620]\nspectrum = { peak_nm = 450, fwhm_nm = 20 }\n"
        "[value]\nled_width_mm = 12\nled_length_mm = 12\n"
        "reflector_reflectance = { table_nm = [[360, 0.8], [830, 0.95]] }\n"
    )
    film = light_film(read_stack(path), None)
    source, run = _over_cell(film), TraceRun(seed=3)
    forward = _of_parts(film, source, range(40), run, None) @ film.spectral.colour
    backward = _of_points(film, source, range(16), run, None) @ film.spectral.colour
    error = np.hypot(*(one.std(axis=0, ddof=1) / np.sqrt(len(one)) for one in (forward, backward)))
    away = (forward.mean(axis=0) - backward.mean(axis=0)) / error
    # 64 parts of X, Y, Z with errors of some 15 degrees of freedom.
    assert np.abs(away).max() < 5.5 and np.abs(np.mean(away**2) - 1) < 0.6, np.mean(away**2)
    assert np.abs(away.mean(axis=0)).max() < 3.5 / np.sqrt(64) * 2


def test_a_stack_without_bands_has_no_colour(tmp_path):
    with pytest.raises(InputError, match=r"colour: needs light\.bands and light\.spectrum"):
        screen_colour(lit(tmp_path, ""), TraceRun(), 1.0)
