"""Stokes parameters of the normal light: their intervals, and a polariser on top."""

import math

import numpy as np
import pytest
from harness import BARE, film_file

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import TraceRun, light_film, polarisation
from mpfcad.measure.polarisation import ANGLES, read_stokes
from mpfcad.measure.rays import gate_of

SOME = pytest.param(150, id="some")
MANY = pytest.param(4000, id="many", marks=pytest.mark.slow)


def reaches(held, runs):
    """Assert that 95 % held, within 3.3 standard errors of so many runs (99.9 %)."""
    assert (np.abs(np.asarray(held) - 0.95) <= 3.3 * math.sqrt(0.95 * 0.05 / runs)).all(), held


def simulated(rng, vector, blocks=64):
    """Return I, Q, U, V of blocks whose noise differs by component and goes with the luminance."""
    bright = 100.0 * (1 + 0.05 * rng.normal(size=blocks))
    noise = rng.normal(size=(blocks, 3)) * (3.0, 2.0, 1.0)
    return np.column_stack([bright, bright[:, None] * vector + noise])


@pytest.mark.parametrize("runs", [SOME, MANY])
def test_shares_are_held_by_their_intervals(runs):
    rng, vector = np.random.default_rng(3), np.array([0.04, -0.01, 0.0])
    held = np.zeros(3)
    for _ in range(runs):
        found = read_stokes(simulated(rng, vector))
        for i, one in enumerate((found.along, found.diagonal, found.circular)):
            held[i] += one.low <= vector[i] <= one.high
    reaches(held / runs, runs)


@pytest.mark.parametrize("runs", [SOME, MANY])
@pytest.mark.parametrize("vector", [(0.04, -0.01, 0.0), (0.0, 0.3, 0.1)])
def test_the_degree_is_held_by_its_interval(vector, runs):
    rng, vector = np.random.default_rng(4), np.array(vector)
    true = np.linalg.norm(vector)
    found = [read_stokes(simulated(rng, vector)).degree for _ in range(runs)]
    reaches(np.mean([one.low <= true <= one.high for one in found]), runs)
    assert abs(np.mean([one.value for one in found]) - true) < 0.05 * true


def test_no_polarisation_is_within_the_interval_of_the_degree():
    rng = np.random.default_rng(5)
    found = [read_stokes(simulated(rng, np.zeros(3))).degree for _ in range(150)]
    assert np.mean([one.low == 0 for one in found]) > 0.9
    assert all(one.high > 0 for one in found)


def lit(folder, top, light="[light]\npolarised = true\n"):
    path = folder / "stack.toml"
    path.write_text(f'extends = "thesis-32in-mpf"\nlayers = ["clear_plate", "film"{top}]\n{light}')
    return light_film(read_stack(path), film_file(folder / "film.stl", [BARE] * 4, length=2.0))


def test_a_polariser_on_top_polarises_wholly_along_its_axis(tmp_path):
    layer = ', { kind = "polariser", axis_deg = 30, transmission_along = 0.8 }'
    found = polarisation(lit(tmp_path, layer), TraceRun(path_limit=40_000), 1.0)
    # Within a cone of some degrees the axis turns with the direction by sin²/2 of them at most.
    assert found.degree.value == pytest.approx(1.0, abs=2e-3)
    assert found.along.value == pytest.approx(math.cos(math.radians(60)), abs=2e-3)
    assert found.diagonal.value == pytest.approx(math.sin(math.radians(60)), abs=2e-3)
    expected = found.luminance.value * np.cos(ANGLES - math.radians(30)) ** 2
    behind = [one.value for one in found.behind]
    np.testing.assert_allclose(behind, expected, atol=4e-3 * found.luminance.value)


def test_same_bits_at_any_number_of_threads(tmp_path):
    film = lit(tmp_path, "")
    one, two = (
        polarisation(film, TraceRun(threads=threads, path_limit=40_000), 1.0) for threads in (1, 2)
    )
    assert one == two
    assert one.along.standard_error < 0.02


BANDS = "bands = [450, 550, 640]\nspectrum = { planckian_k = 6500 }\n"


def test_bands_alike_are_light_of_one_wavelength(tmp_path):
    plain, banded = (
        polarisation(lit(tmp_path, "", f"[light]\npolarised = true\n{bands}"),
                     TraceRun(path_limit=40_000), 1.0)
        for bands in ("", BANDS)
    )  # fmt: skip
    for name in ("along", "diagonal", "circular"):
        assert getattr(banded, name).value == pytest.approx(getattr(plain, name).value, rel=1e-9)
    assert banded.luminance.value == pytest.approx(plain.luminance.value, rel=1e-9)
    assert plain.by_band == () and [nm for nm, _ in banded.by_band] == [450, 550, 640]
    for _, share in banded.by_band:
        assert share.value == pytest.approx(plain.along.value, rel=1e-9)


def test_light_of_leds_behind_crossed_polarisers(tmp_path):
    # All light that leaves is polarised along 30°; the sheet on top takes a tenth of that.
    path = tmp_path / "stack.toml"
    path.write_text(
        'extends = "led-tv-20mm"\nlayers = ["clear_plate", "bottom_sheet", '
        '{ kind = "polariser", name = "lcd", axis_deg = 30, transmission_along = 0.8 }, '
        '{ kind = "sheet", name = "last", sigma = 0.1, depolarisation = 0.1 }]\n'
        f"[light]\npolarised = true\n{BANDS}"
    )
    found = polarisation(light_film(read_stack(path), None), TraceRun(path_limit=60_000), 1.0)
    assert found.degree.value == pytest.approx(0.9, abs=0.02)
    angle = math.degrees(math.atan2(found.diagonal.value, found.along.value)) / 2
    assert angle == pytest.approx(30, abs=1.5)
    assert len(found.by_band) == 3


def test_unpolarised_light_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"polarisation: needs light\.polarised = true"):
        polarisation(lit(tmp_path, "", light=""), TraceRun(), 1.0)


def test_a_ray_file_of_polarised_light_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"light\.polarised: ray files hold no polarisation"):
        gate_of(lit(tmp_path, ""), "screen")
