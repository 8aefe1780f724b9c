"""A stack in bands: its table, its values at each band, its converters, and what is refused."""

import json

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.backlight.stored import describe_stack, restore_stack
from mpfcad.backlight.written import stack_tables
from mpfcad.errors import InputError

SPECTRUM = "spectrum = { peak_nm = 450, fwhm_nm = 20 }\n"
LIGHT = f"[light]\nbands = [440, 460, 530, 620]\n{SPECTRUM}"
EMISSION = "emission = { peak_nm = 535, fwhm_nm = 35 }"
QD = f'{{ kind = "converter", name = "qd", absorptance = 0.3, yield = 0.9, {EMISSION} }}'


def written(folder, light=LIGHT, value="", layers=QD):
    path = folder / "stack.toml"
    path.write_text(
        f'extends = "thesis-32in-mpf"\nlayers = ["clear_plate", {layers}, "film"]\n'
        f"{light}[value]\n{value}"
    )
    return path


def test_values_differ_at_the_bands_where_they_say_so(tmp_path):
    value = (
        "reflector_reflectance = { table_nm = [[400, 0.8], [500, 0.9], [700, 0.95]] }\n"
        "film_absorption_per_mm = { table_nm = [[400, 2], [700, 0.2]] }\n"
    )
    stack = read_stack(written(tmp_path, value=value))
    bands = stack.bands
    assert set(bands.value) == {"reflector_reflectance", "film_absorption_per_mm"}
    expected = np.interp((440, 460, 530, 620), (400, 500, 700), (0.8, 0.9, 0.95))
    np.testing.assert_allclose(bands.value["reflector_reflectance"], expected)
    assert stack.at_band(2)["reflector_reflectance"] == expected[2]
    assert stack["reflector_reflectance"] == pytest.approx(0.9125)
    assert not bands.separate
    said = {one["name"]: one["source"] for one in stack.inputs()}
    assert said["light.flat"].startswith("the same at all bands: ")
    assert "lamp_reflectance" in said["light.flat"]
    assert "qd.absorptance" in said["light.flat"]
    assert "reflector_reflectance" not in said["light.flat"]


def test_a_stack_in_bands_is_kept_in_an_export(tmp_path):
    stack = read_stack(written(tmp_path, value="plate_index = { cauchy = [1.48, 0.004] }\n",
                               light=f'{LIGHT}dispersion = "neglected"\n'))  # fmt: skip
    kept = json.loads(json.dumps(describe_stack(stack), sort_keys=True))
    assert restore_stack(kept).bands == stack.bands
    assert stack.bands.neglected == ("plate_index",)
    assert "neglected: plate_index" in str(stack.inputs())
    with pytest.raises(InputError, match="bands or LEDs"):
        stack_tables(stack)


def test_dispersion_and_particles_are_traced_band_by_band(tmp_path):
    value = (
        "plate_index = { cauchy = [1.48, 0.004] }\nplate_particle_radius_um = 1\n"
        "plate_particle_index = 1.43\nplate_particle_density_per_mm3 = 1e5\n"
    )
    stack = read_stack(written(tmp_path, value=value, layers='"bottom_sheet"'))
    assert set(stack.bands.separate) == {
        "plate_index", "plate_scattering_per_mm", "plate_asymmetry",
    }  # fmt: skip
    first, last = stack.at_band(0), stack.at_band(3)
    assert first["plate_index"] == pytest.approx(1.48 + 0.004 / 0.44**2)
    assert first["light_wavelength_nm"] == 440
    assert first["plate_scattering_per_mm"] > last["plate_scattering_per_mm"]


def test_a_value_that_is_changed_is_changed_at_all_bands(tmp_path):
    value = "reflector_reflectance = { table_nm = [[400, 0.8], [700, 0.9]] }\n"
    stack = read_stack(written(tmp_path, value=value))
    entry = stack.quantity["reflector_reflectance"]
    changed = stack.with_values(
        {"reflector_reflectance": type(entry)(1.01 * entry.value, "given", "")}
    )
    np.testing.assert_allclose(
        changed.bands.value["reflector_reflectance"],
        1.01 * np.array(stack.bands.value["reflector_reflectance"]),
    )


def test_a_converter_has_the_depth_of_its_absorption(tmp_path):
    from mpfcad.optics.element import Converter

    layers = (
        f'{QD}, {{ kind = "converter", name = "red", absorption_per_mm = 5, thickness_um = 100, '
        f"index = 1.4, yield = 0.8, {EMISSION} }}"
    )
    path = written(tmp_path, layers=layers)
    text = path.read_text().replace(', "film"]', "]")
    path.write_text(text.replace("thesis-32in-mpf", "led-tv-20mm"))
    found = [e for e in lower_stack(read_stack(path), None) if isinstance(e, Converter)]
    assert found[0].depth == pytest.approx(-np.log(0.7))
    assert (found[0].index, found[0].quantum_yield) == (1.5, 0.9)
    assert found[1].depth == pytest.approx(0.5)
    assert list(read_stack(path).bands.emission) == ["qd", "red"]
    # A sheet: light within it is not followed.
    assert [e.thickness for e in found] == [0.0, 0.0]


def test_a_converter_that_says_how_it_scatters_is_a_film(tmp_path):
    from mpfcad.optics.element import Converter

    own = f'{{ kind = "converter", name = "NAME", yield = 0.8, {EMISSION}, thickness_um = 100, '
    path = written(tmp_path, layers=", ".join([
        f"{own.replace('NAME', 'a')} absorption_per_mm = 5, scattering_per_mm = 20, "
        "asymmetry = 0.7 }",
        f"{own.replace('NAME', 'b')} absorptance = 0.3, scattering_per_mm = 0, index = 1.6 }}",
    ]))  # fmt: skip
    path.write_text(path.read_text().replace(', "film"]', "]").replace(
        "thesis-32in-mpf", "led-tv-20mm"))  # fmt: skip
    stack = read_stack(path)
    a, b = (e for e in lower_stack(stack, None) if isinstance(e, Converter))
    assert (a.thickness, a.scattering, a.asymmetry) == (0.1, 20.0, 0.7)
    assert a.depth == pytest.approx(0.5)
    assert (b.thickness, b.scattering, b.index) == (0.1, 0.0, 1.6)
    assert b.depth == pytest.approx(-np.log(0.7))
    said = {one["name"]: one["value"] for one in stack.inputs()}
    assert said["a.scattering_per_mm"] == 20


@pytest.mark.parametrize(
    ("light", "message"),
    [
        (f"[light]\nbands = [440, 450]\n{SPECTRUM}", "light.bands: 2 bands: expected 3 … 31"),
        (f"[light]\nbands = 32\n{SPECTRUM}", "light.bands: 32: expected 3 … 31 bands"),
        (f"[light]\nbands = [440, 430, 500]\n{SPECTRUM}", "entry 2: 430: expected a wavelength in"),
        (f"[light]\nbands = [440, true, 500]\n{SPECTRUM}", "entry 2: True: expected a wavelength"),
        (f"[light]\nbands = [100, 430, 500]\n{SPECTRUM}", "entry 1: 100: expected a wavelength in"),
        (f'[light]\nbands = "blue"\n{SPECTRUM}', "light.bands: 'blue': expected 3 … 31 rising"),
        ("[light]\nbands = 8\n", "light.spectrum: missing: expected with bands"),
        (f"[light]\n{SPECTRUM}", "light.bands: missing: expected with spectrum"),
        (f'{LIGHT}dispersion = "no"\n', "light.dispersion: 'no': expected traced or neglected"),
        ('[light]\ndispersion = "traced"\n', "light.dispersion: needs bands and spectrum"),
        (f"{LIGHT}colour = 1\n", "expected a table with polarised, bands"),
        ("", r"layers: qd: converter: needs light.bands and spectrum"),
        (
            "[light]\nbands = 8\nspectrum = { table_nm = [[420, 1], [700, 1]] }\n",
            r"light.spectrum: 420 … 700 nm: does not cover the bands, 400 … 700 nm",
        ),
    ],
)
def test_wrong_light_is_refused(tmp_path, light, message):
    with pytest.raises(InputError, match=message):
        read_stack(written(tmp_path, light=light))


@pytest.mark.parametrize(
    ("layer", "message"),
    [
        (f'kind = "converter", name = "qd", absorptance = 0.3, yield = 1.1, {EMISSION}',
         r"qd\.yield: 1\.1: expected a number in 0 … 1"),
        (f'kind = "converter", name = "qd", absorptance = -0.1, yield = 0.9, {EMISSION}',
         r"qd\.absorptance: -0\.1: expected a number in 0"),
        (f'kind = "converter", name = "qd", absorptance = 0.3, {EMISSION}',
         r"qd\.yield: missing"),
        (f'kind = "converter", name = "qd", yield = 0.9, {EMISSION}',
         r"qd: no absorption: expected absorptance, or absorption_per_mm with thickness_um"),
        (f'kind = "converter", name = "qd", absorption_per_mm = 1, yield = 0.9, {EMISSION}',
         r"qd: absorption_per_mm: expected absorptance, or"),
        ('kind = "converter", name = "qd", absorptance = 0.3, thickness_um = 9, yield = 1, '
         f"{EMISSION}",
         r"qd: absorptance, thickness_um: expected absorptance, or"),
        ('kind = "converter", name = "qd", absorptance = 0.3, scattering_per_mm = 1, yield = 1, '
         f"{EMISSION}", r"qd: absorptance: expected absorptance with thickness_um, or"),
        ('kind = "converter", name = "qd", absorptance = 0.3, asymmetry = 0.1, yield = 1, '
         f"{EMISSION}",
         r"qd: scattering_per_mm: missing: expected with asymmetry"),
        ('kind = "converter", name = "qd", absorptance = 0.3, thickness_um = 9, '
         f"scattering_per_mm = -1, yield = 1, {EMISSION}", r"scattering_per_mm: -1: expected a"),
        ('kind = "converter", name = "qd", absorptance = 0.3, yield = 0.9',
         r"qd\.emission: None: expected a table with file"),
        ('kind = "converter", name = "qd", absorptance = { table_nm = [[450, 0.3], [700, 0.0]] }, '
         f"yield = 0.9, {EMISSION}", r"qd\.absorptance: table_nm: 450 … 700 nm: does not cover"),
        ('kind = "converter", name = "qd", absorptance = 0.3, yield = 0.9, '
         "emission = { table_nm = [[500, 1], [600, 1]] }",
         r"qd\.emission: 500 … 600 nm: does not cover the bands"),
        ('kind = "plate", name = "own", emission = 1', r"own: emission: unknown key"),
    ],
)  # fmt: skip
def test_wrong_converters_are_refused(tmp_path, layer, message):
    with pytest.raises(InputError, match=message):
        read_stack(written(tmp_path, layers=f"{{ {layer} }}"))


def test_negative_absorption_at_a_band_is_refused(tmp_path):
    value = "plate_absorption_per_mm = { table_nm = [[400, -1], [500, 0.1], [700, 0.1]] }\n"
    with pytest.raises(InputError, match=r"plate_absorption_per_mm: table_nm: row 1: -1 at 400"):
        read_stack(written(tmp_path, value=value))


def test_dispersion_beside_a_converter_has_to_be_neglected(tmp_path):
    value = "plate_index = { cauchy = [1.48, 0.004] }\n"
    with pytest.raises(InputError, match=r"plate_index depends on the wavelength and qd converts"):
        read_stack(written(tmp_path, value=value))


def test_a_job_states_bands_but_no_file(tmp_path):
    stack = read_stack(
        "thesis-32in-mpf",
        overrides={"light": {"bands": 5, "spectrum": {"planckian_k": 6500}}},
    )
    assert stack.bands.wavelength == (400, 475, 550, 625, 700)
    with pytest.raises(InputError, match=r"spectrum\.file: led\.csv: expected in a stack file"):
        read_stack(
            "thesis-32in-mpf", overrides={"light": {"bands": 5, "spectrum": {"file": "led.csv"}}}
        )
