"""Polarised light in a stack's file: layers, what is refused, kept and restored."""

import math

import pytest
from harness import BARE, film_mesh

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.backlight.stored import describe_stack, restore_stack
from mpfcad.errors import InputError
from mpfcad.optics.element import Sheet
from mpfcad.optics.stokes.plane import PlaneLayer

LCD = '{ kind = "polariser", name = "lcd", transmission_along = 0.85, transmission_across = 0.001 }'
DBEF = """{ kind = "reflective_polariser", name = "dbef", axis_deg = 20, transmission_along = 0.9,
 transmission_across = 0.03, reflection_along = 0.08, reflection_across = 0.96 }""".replace(
    "\n", ""
)
PLATE = '{ kind = "retarder", name = "plate", axis_deg = 45, retardation_nm = 137.5 }'


def written(folder, *layers, light="[light]\npolarised = true\n", value=""):
    path = folder / "stack.toml"
    path.write_text(
        f'extends = "thesis-32in-mpf"\nlayers = ["film", "top_sheet", {", ".join(layers)}]\n'
        f"{light}[value]\n{value}\n"
    )
    return path


def lowered(folder, *layers, **more):
    return lower_stack(read_stack(written(folder, *layers, **more)), film_mesh(folder, [BARE]))


def test_layers_are_lowered_with_axis_shares_and_retardation(tmp_path):
    lcd, dbef, plate = lowered(tmp_path, LCD, DBEF, PLATE)[-3:]
    assert lcd == PlaneLayer(0.0, (0.85, 0.001), name="lcd")
    assert dbef == PlaneLayer(math.radians(20), (0.9, 0.03), (0.08, 0.96), name="dbef")
    assert plate.axis == pytest.approx(math.pi / 4)
    # 137.5 nm at 550 nm: a quarter wave.
    assert plate.retardation == pytest.approx(math.pi / 2)


def test_retardation_follows_the_wavelength(tmp_path):
    plate = lowered(tmp_path, PLATE, value="light_wavelength_nm = 275")[-1]
    assert plate.retardation == pytest.approx(math.pi)


def test_sheets_depolarise_wholly_unless_they_say_otherwise(tmp_path):
    own = '{ kind = "sheet", name = "own", sigma = 0.1, depolarisation = 0.2 }'
    shares = [e.depolarisation for e in lowered(tmp_path, own) if isinstance(e, Sheet)]
    assert shares == [1.0, 0.2]
    some = lowered(tmp_path, own, value="sheet_depolarisation = 0.5")
    assert [e.depolarisation for e in some if isinstance(e, Sheet)] == [0.5, 0.2]


@pytest.mark.parametrize("layer", [LCD, DBEF, PLATE])
def test_layers_need_polarised_light(tmp_path, layer):
    with pytest.raises(InputError, match=r"layers: \w+: \w+: needs light\.polarised = true"):
        read_stack(written(tmp_path, layer, light=""))


def test_a_job_asks_for_polarised_light(tmp_path):
    path = written(tmp_path, LCD, light="")
    assert read_stack(path, overrides={"light": {"polarised": True}}).polarised
    assert not read_stack("thesis-32in-mpf").polarised


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("reflection_along = 0.08", "reflection_along = 0.2"),
         r"dbef: transmission_along 0\.9 and reflection_along 0\.2: expected at most 1 together"),
        (("transmission_along = 0.9", "transmission_along = 1.2"), r"1\.2: expected a number in 0"),
        (("transmission_across = 0.03,", ""), r"dbef\.transmission_across: missing"),
    ],
)  # fmt: skip
def test_a_layer_that_is_not_passive_is_refused_with_its_place(tmp_path, change, said):
    with pytest.raises(InputError, match=said):
        read_stack(written(tmp_path, DBEF.replace(*change)))


@pytest.mark.parametrize("values", ["", ", retardation_nm = 10, retardation_waves = 0.2"])
def test_a_retarder_has_one_retardation(tmp_path, values):
    layer = '{ kind = "retarder", name = "plate"' + values + " }"
    with pytest.raises(InputError, match=r"plate: .*retardation.*: expected one of the two"):
        read_stack(written(tmp_path, layer))


@pytest.mark.parametrize(
    "light", ["light = 1\n", "[light]\npolarised = 1\n", "[light]\nother = true\n"]
)
def test_a_table_of_light_that_means_nothing_is_refused(tmp_path, light):
    with pytest.raises(InputError, match=r"light.*expected"):
        read_stack(written(tmp_path, light=light).with_name("stack.toml"))


def test_a_depolarisation_without_polarised_light_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"sheet_depolarisation: needs light\.polarised = true"):
        read_stack(written(tmp_path, light="", value="sheet_depolarisation = 0.5"))


def test_leds_have_polarised_light():
    stack = read_stack("led-tv-20mm", overrides={"light": {"polarised": True}})
    assert stack.polarised and restore_stack(describe_stack(stack)).polarised


BANDS = "bands = [440, 550, 660]\nspectrum = { planckian_k = 6500 }\n"


def test_a_retardation_is_a_phase_of_its_own_in_each_band(tmp_path):
    light = f"[light]\npolarised = true\n{BANDS}"
    stack = read_stack(written(tmp_path, PLATE, light=light))
    assert stack.bands.separate == ("plate.retardation_nm",)
    mesh = film_mesh(tmp_path, [BARE])
    found = [lower_stack(stack.at_band(i), mesh)[-1].retardation for i in range(3)]
    assert found == pytest.approx([2 * math.pi * 137.5 / nm for nm in (440, 550, 660)])
    neglected = read_stack(written(tmp_path, PLATE, light=f'{light}dispersion = "neglected"\n'))
    assert not neglected.bands.separate and neglected.bands.neglected == ("plate.retardation_nm",)
    found = [lower_stack(neglected.at_band(i), mesh)[-1].retardation for i in range(3)]
    assert found == pytest.approx([math.pi / 2] * 3)
    said = [one["name"] for one in stack.inputs()]
    assert "light.polarised" in said and "light.bands" in said


def test_a_base_delays_each_band_by_a_phase_of_its_own(tmp_path):
    base = "film_base_index = 1.64\nfilm_base_thickness_um = 50\nfilm_base_retardation_nm = 1000\n"
    light = f"[light]\npolarised = true\n{BANDS}"
    stack = read_stack(written(tmp_path, light=light, value=base))
    mesh = film_mesh(tmp_path, [BARE])
    found = [max(getattr(e, "delay", 0) for e in lower_stack(stack.at_band(i), mesh))
             for i in range(3)]  # fmt: skip
    assert found == pytest.approx([2 * math.pi * 1000 / nm / 0.05 for nm in (440, 550, 660)])


def test_it_is_kept_and_restored(tmp_path):
    stack = read_stack(written(tmp_path, LCD, DBEF))
    again = restore_stack(describe_stack(stack))
    assert again == stack
    assert again.polarised
    assert "polarised" not in describe_stack(read_stack("thesis-32in-mpf"))
    assert stack.inputs()[-1]["name"] == "light.polarised"


def mueller(rows):
    return f'{{ kind = "mueller", name = "layer", axis_deg = 10, matrix = {rows} }}'


def test_a_mueller_matrix_is_read_row_by_row(tmp_path):
    rows = [[0.5, 0.1, 0.0, 0.05], [0.1, 0.2, 0.0, 0.0], [0.0, 0.05, 0.1, 0.0], [0, 0, 0, 0.1]]
    layer = lowered(tmp_path, mueller(rows))[-1]
    assert layer.matrix.tolist() == rows
    assert layer.axis == pytest.approx(math.radians(10))


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([[1.0, 0, 0, 0]] * 3, "layers: layer: matrix: .*expected four rows of four numbers"),
        ([[0.9, 0.3, 0, 0], [0.3, 0.9, 0, 0], [0, 0, 0.8, 0], [0, 0, 0, 0.8]],
         r"layers: layer: Mueller matrix: passes 1\.2 of some light"),
        ([[0.5, 0, 0, 0], [0, 0.9, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]], "no mixture of Jones"),
        ([["a", 0, 0, 0]] + [[0, 0, 0, 0]] * 3, r"layer\.m00: 'a': expected a number"),
    ],
)  # fmt: skip
def test_a_mueller_matrix_that_is_no_passive_element_is_refused(tmp_path, rows, said):
    with pytest.raises(InputError, match=said):
        read_stack(written(tmp_path, mueller(rows).replace("'", '"')))
