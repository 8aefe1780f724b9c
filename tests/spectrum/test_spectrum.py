"""Spectra, bands and colours against colour-science, an independent library."""

import warnings

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.spectrum import (
    Bands,
    Spectrum,
    chromaticity,
    gaussian,
    matching_functions,
    planckian,
    read_spectrum,
    uniform_chromaticity,
    wavelengths,
)

SOME = (430.0, 450.0, 480.0, 520.0, 550.0, 590.0, 630.0, 660.0)


@pytest.fixture(scope="module")
def colour():
    # It sets how numpy prints numbers, for every test after it.
    with warnings.catch_warnings(), np.printoptions():
        warnings.simplefilter("ignore")
        import colour

        return colour


def made(power, title="made"):
    return Spectrum(tuple(map(float, power)), 360.0, 830.0, title)


def test_the_observer_is_that_of_another_library(colour):
    other = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    np.testing.assert_array_equal(wavelengths(), other.wavelengths)
    np.testing.assert_array_equal(matching_functions(), other.values)


@pytest.mark.parametrize("kelvin", [2000.0, 2856.0, 6504.0, 15000.0])
def test_a_black_body_has_the_colour_that_another_library_gives(colour, kelvin):
    # That library's second radiation constant is rounded to 1.4388 cm K.
    spectrum = colour.sd_blackbody(kelvin * 1.4388 / 1.438776877, colour.SpectralShape(360, 830, 1))
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    xyz = spectrum.values @ observer.values
    found = planckian(kelvin) @ matching_functions()
    np.testing.assert_allclose(chromaticity(found), colour.XYZ_to_xy(xyz), atol=2e-8)
    expected = colour.Luv_uv_to_xy(uniform_chromaticity(found))
    np.testing.assert_allclose(expected, chromaticity(found), rtol=1e-12)


def test_luminous_efficacy_of_green_light():
    assert made(gaussian(555, 1.0)).efficacy == pytest.approx(683.0, rel=1e-3)
    # Of a blue LED some 30 lm/W.
    assert 20 < made(gaussian(450, 20)).efficacy < 50


@pytest.mark.parametrize("count", [3, 8, 31])
def test_what_treats_all_bands_alike_leaves_a_colour_as_it_is(count):
    for power in (planckian(6500), planckian(2856), gaussian(450, 20) + 0.4 * gaussian(570, 100)):
        bands = Bands(tuple(np.linspace(400, 700, count)), made(power))
        xyz = bands.channel_colour.sum(axis=0)
        np.testing.assert_allclose(
            chromaticity(xyz), chromaticity(power @ matching_functions()), rtol=1e-13
        )
        assert xyz[1] == pytest.approx(1.0, rel=1e-13)


def test_bands_share_all_of_a_spectrum_and_its_photons():
    bands = Bands(SOME, made(gaussian(450, 20)), emission={"qd": made(gaussian(545, 90))})
    emission = bands.emission["qd"]
    assert bands.share(emission).sum() == pytest.approx(1.0, rel=1e-14)
    assert bands.photons(emission).sum() == pytest.approx(1.0, rel=1e-14)
    assert (bands.photons(emission) * 1e9 >= 0).all()
    # Power by the photons' mean wavelengths is the power that the spectrum has there.
    power = bands.photons(emission) / bands.mean_wavelength
    np.testing.assert_allclose(power / power.sum(), bands.share(emission), atol=2e-3)
    edges = (440.0, 465.0)
    within = (wavelengths() >= edges[0]) & (wavelengths() < edges[1])
    assert bands.share(bands.spectrum)[1] == pytest.approx(
        bands.spectrum.values[within].sum() / bands.spectrum.values.sum()
    )


def test_a_measured_file_is_linear_between_its_rows(tmp_path):
    (tmp_path / "led.csv").write_text("wavelength_nm,power\n400,0\n450,1\n\n500,0.5\n700,0.1\n")
    found = read_spectrum("stack: light.spectrum", tmp_path, {"file": "led.csv"})
    assert (found.first, found.last) == (400.0, 700.0)
    at = dict(zip(wavelengths(), found.power, strict=True))
    assert [at[nm] for nm in (390, 425, 450, 475, 600, 701)] == [0, 0.5, 1, 0.75, 0.3, 0]


def test_rows_nearer_than_a_nanometre_are_averaged(tmp_path):
    # Lines of a lamp, 0.2 nm wide, between the observer's wavelengths, on a weak ground.
    nm = np.arange(400, 700.05, 0.1)
    power = np.full(len(nm), 0.01)
    for line in (435.85, 546.05, 611.35):
        power += np.maximum(0, 1 - np.abs(nm - line) / 0.2)
    rows = "\n".join(f"{a:.2f},{b:.6f}" for a, b in zip(nm, power, strict=True))
    (tmp_path / "lamp.csv").write_text(f"wavelength_nm,power\n{rows}\n")
    found = read_spectrum("stack", tmp_path, {"file": "lamp.csv"}).values
    assert found.sum() == pytest.approx(np.trapezoid(power, nm), rel=1e-9)
    # A line of area 0.2 is shared by the two wavelengths beside it, or lies whole at one.
    assert found[wavelengths() == 436] == pytest.approx(0.21, abs=2e-3)
    assert found[wavelengths() == 546] == pytest.approx(0.21, abs=2e-3)
    part = found[(wavelengths() == 611) | (wavelengths() == 612)]
    assert part.sum() == pytest.approx(0.22, abs=2e-3) and part.min() > 0.01
    # Sampled, they would be missed or doubled.
    assert np.interp(wavelengths(), nm, power).sum() != pytest.approx(found.sum(), rel=0.05)


@pytest.mark.parametrize("peak", [550.0, 550.5])
def test_a_narrow_peak_has_its_power_wherever_it_lies(peak):
    # The area of a Gaussian is fwhm √(π / (4 ln 2)).
    assert gaussian(peak, 1.0).sum() == pytest.approx(np.sqrt(np.pi / (4 * np.log(2))), rel=1e-9)
    wide = gaussian(peak, 20.0) / np.exp(-4 * np.log(2) * ((wavelengths() - peak) / 20) ** 2)
    np.testing.assert_allclose(wide[178:203], 1.0, atol=0.005)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nm,power\n400,1\n500,1\n", r"row 1: nm,power: expected wavelength_nm,power"),
        ("wavelength_nm,power\n400,1\n400,1\n", r"row 3: 400 nm: expected above 400"),
        ("wavelength_nm,power\n400,1\n500,-1\n", r"row 3: power -1: expected 0 or more"),
        ("wavelength_nm,power\n400,1\n500,many\n", r"row 3: 500,many: expected two numbers"),
        ("wavelength_nm,power\n400,1\n", r"1 rows: expected two numbers in two rows"),
        ("wavelength_nm,power\n400,nan\n500,1\n", r"row 2: power nan: expected 0 or more"),
        ("wavelength_nm,power\n400,0\n500,0\n", r"no power in 360"),
        ("", r"row 1: : expected wavelength_nm,power"),
    ],
)
def test_wrong_files_are_refused_with_their_row(tmp_path, text, message):
    (tmp_path / "led.csv").write_text(text)
    with pytest.raises(InputError, match=rf"led\.csv: {message}"):
        read_spectrum("stack", tmp_path, {"file": "led.csv"})


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"peak_nm": 450}, "expected a table with file, table_nm, peak_nm with fwhm_nm"),
        ("led.csv", "expected a table with file"),
        ({"peak_nm": 450, "fwhm_nm": 0}, r"fwhm_nm: 0: expected a number in 1 … 400"),
        ({"planckian_k": True}, r"planckian_k: True: expected a number in 500"),
        ({"peak_nm": 300, "fwhm_nm": 20}, r"peak_nm: 300: expected a number in 360 … 830"),
        ({"file": "none.csv"}, r"none\.csv: no such file"),
        ({"table_nm": [[400, 1], [500]]}, r"expected two numbers in two rows"),
        ({"peak_nm": 450, "fwhm_nm": 20, "tag": "mine"}, "tag: mine: expected given, sourced"),
    ],
)
def test_wrong_entries_are_refused(tmp_path, entry, message):
    with pytest.raises(InputError, match=message):
        read_spectrum("stack: light.spectrum", tmp_path, entry)
