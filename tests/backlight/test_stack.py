"""Backlight stacks: presets, the user's own files, and every refusal."""

import math

import pytest
from harness import BARE, film_mesh

from mpfcad.backlight import LAYERS, list_stacks, ranges_with, read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.errors import InputError
from mpfcad.optics.element import Cavity, Film, Sheet, Slab

MPF = "thesis-32in-mpf"


def write(tmp_path, text, name="own.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def refused(name, *words, **options):
    with pytest.raises(InputError) as caught:
        read_stack(name, **options)
    text = str(caught.value)
    assert "\n" not in text
    for word in (str(name), *words):
        assert word in text, text


def test_the_presets_are_complete_and_say_where_their_values_are_from():
    stacks = list_stacks()
    stacks = [stack for stack in stacks if stack.spec.kind == "tubes"]
    assert [s.name for s in stacks] == [
        f"{values}-{case}"
        for values in ("thesis-32in", "thesis-fitted")
        for case in ("bef", "conventional", "mpf", "mpf-plate")
    ]
    for stack in stacks:
        entries = stack.inputs()
        assert [e["name"] for e in entries] == list(ranges_with(stack.spec))
        for entry in entries:
            low, high = ranges_with(stack.spec)[entry["name"]]
            assert low <= entry["value"] <= high
            assert entry["tag"] in ("sourced", "assumed")
            assert len(entry["source"]) > 3
        assert set(stack.layers) <= set(LAYERS)


def test_starting_values():
    stack = read_stack(MPF)
    expected = {
        "lamp_count": 12, "lamp_pitch_mm": 32.69, "lamp_radius_mm": 1.7, "lamp_height_mm": 3.5,
        "lamp_reflectance": 0.75, "lamp_luminance_cd_m2": 20100, "thickness_mm": 20,
        "reflector_reflectance": 0.94, "reflector_specular_fraction": 0.3, "plate_index": 1.49,
        "plate_thickness_mm": 2, "plate_scattering_per_mm": 0.6, "plate_asymmetry": 0.8,
        "plate_absorption_per_mm": 0.0036, "bottom_sheet_sigma": 0.36, "top_sheet_sigma": 0.35,
        "sheet_transmission": 0.98, "film_index": 1.55, "panel_width_mm": 392.26,
        "panel_length_mm": 697.68,
    }  # fmt: skip
    assert {k: stack[k] for k in expected} == expected
    assert stack.layers == ("clear_plate", "bottom_sheet", "film", "top_sheet")
    assert stack.acceptance == pytest.approx(math.sin(math.radians(1)))
    sourced = {k for k, q in stack.quantity.items() if q.tag == "sourced"}
    assert {"lamp_count", "thickness_mm"} <= sourced
    assert "lamp_luminance_cd_m2" not in sourced


def test_lamps_stand_in_the_middle_of_the_panel():
    stack = read_stack(MPF)
    assert stack.source.lamp_position(0) == pytest.approx((392.26 - 11 * 32.69) / 2)
    assert stack.source.lamp_position(11) + stack.source.lamp_position(0) == pytest.approx(392.26)
    assert stack.source.lamp_position(5) - stack.source.lamp_position(4) == pytest.approx(32.69)


def test_overrides_and_thickness_are_tagged_given():
    stack = read_stack(MPF, thickness=16.0, overrides={"film_index": 1.6})
    assert stack.thickness == 16.0 and stack["film_index"] == 1.6
    given = {e["name"] for e in stack.inputs() if e["tag"] == "given"}
    assert given == {"thickness_mm", "film_index"}


def test_a_file_extends_a_preset_or_a_file_beside_it(tmp_path):
    write(tmp_path, f'extends = "{MPF}"\ntitle = "mine"\n[value]\nfilm_index = 1.6\n', "base.toml")
    path = write(
        tmp_path,
        'extends = "base.toml"\nlayers = ["film"]\n[value]\n'
        'lamp_radius_mm = { value = 1.5, tag = "sourced", source = "data sheet" }\n',
    )
    stack = read_stack(path)
    assert (stack.title, stack.layers, stack.name) == ("mine", ("film",), "own")
    assert stack["film_index"] == 1.6 and stack.quantity["film_index"].tag == "given"
    quantity = stack.quantity["lamp_radius_mm"]
    assert (quantity.value, quantity.tag, quantity.source) == (1.5, "sourced", "data sheet")


def test_elements_are_the_layers_from_the_lamps_up(tmp_path):
    mesh = film_mesh(tmp_path, [BARE])
    conventional = lower_stack(read_stack("thesis-32in-conventional"), mesh, 0.02)
    assert [type(e) for e in conventional] == [Cavity, Slab, Sheet, Film, Sheet]
    assert conventional[1].scattering == 0.6 and conventional[1].absorption == 0.0036
    assert conventional[3].offset == 0.02 and conventional[3].index_below == 1.0
    clear = lower_stack(read_stack(MPF), mesh)[1]
    assert clear.scattering == clear.absorption == 0 and not clear.bonded
    plate = lower_stack(read_stack("thesis-32in-mpf-plate"), mesh)
    assert [type(e) for e in plate] == [Cavity, Slab, Film, Sheet]
    assert plate[1].bonded and plate[2].index_below == plate[1].index == 1.49


def test_unknown_presets_and_missing_files(tmp_path):
    refused("thesis-40in", "no such preset", MPF)
    refused("../thesis-32in", "no such preset")
    refused(tmp_path / "none.toml", "none.toml: no such file: expected a stack")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title = x\n", ["line 2"]),
        ('tilte = "x"\n', ["tilte", "unknown key", "title"]),
        ("layers = 3\n", ["layers"]),
        ('layers = ["film", "glass"]\n', ["glass", "diffusing_plate"]),
        ('layers = ["clear_plate"]\n', ["0 films"]),
        ('layers = ["film", "film"]\n', ["2 films"]),
        ('layers = ["film", { kind = "film" }]\n', ["2 films"]),
        ('layers = ["film", { kind = "foil" }]\n', ["foil", "bef"]),
        ('layers = ["film", { kind = "film", file = "no.stl" }]\n', ["no.stl", "no such file"]),
        ('layers = ["film", { kind = "sheet" }]\n', ["sheet_2.sigma", "missing"]),
        ('layers = ["film", { kind = "bef", pitch_mm = 5 }]\n', ["pitch_mm", "pitch_um"]),
        ('layers = ["film", { kind = "bef", pitch_um = 0.0 }]\n', ["bef_2.pitch_um", "1 … 2000"]),
        ('layers = ["film", { kind = "bef", flipped = 1 }]\n', ["flipped", "true or false"]),
        ('layers = ["film", { kind = "bef", name = "film" }]\n', ["name"]),
        ('layers = ["film", { kind = "bef", name = "a" }, { kind = "bef", name = "a" }]\n', ["a"]),
        ('extent = "half"\n', ["extent", "pitch, panel"]),
        ("[value]\nlamp_3_luminance_factor = 0.5\n", ["lamp_3_luminance_factor", "extent"]),
        (
            'extent = "panel"\n[value]\nlamp_13_luminance_factor = 0.5\n',
            ["lamp_13_luminance_factor", "12"],
        ),
        ('extent = "panel"\n[value]\nlamp_1_shift_mm = -30\n', ["lamp_N_shift_mm", "392.26"]),
        ("[value]\nplate_particle_radius_um = 2.0\n", ["plate_particle_index", "missing"]),
        ('layers = ["bonded_film"]\n', ["bonded_film", "plate"]),
        ('layers = ["clear_plate", "top_sheet", "bonded_film"]\n', ["bonded_film", "plate"]),
        ("value = 3\n", ["value", "table"]),
        ("[value]\nfilm_indx = 1.5\n", ["film_indx", "film_index"]),
        ("[value]\nfilm_index = 0.5\n", ["film_index", "0.5", "1 … 4"]),
        ("[value]\nfilm_index = nan\n", ["film_index", "nan", "1 … 4"]),
        ("[value]\nfilm_index = true\n", ["film_index", "number"]),
        ('[value]\nfilm_index = "1.5"\n', ["film_index", "number"]),
        ("[value]\nlamp_count = 11.5\n", ["lamp_count", "whole"]),
        (
            "[value]\nfilm_index = { value = 1.5, tg = 3 }\n",
            ["film_index", "sigma, source, tag, value"],
        ),
        ('[value]\nfilm_index = { tag = "given" }\n', ["film_index"]),
        ("[value]\nfilm_index = {}\n", ["value.film_index: {}", "range, sigma"]),
        ('layers = ["film", { kind = "bef", index = {} }]\n', ["bef_2.index: {}", "value"]),
        (
            '[value]\nfilm_index = { value = 1.5, tag = "guess" }\n',
            ["film_index", "guess", "given"],
        ),
        ("[value]\nlamp_height_mm = 1.0\n", ["lamp_height_mm", "1.7"]),
        ("[value]\nthickness_mm = 5.0\n", ["thickness_mm", "5.2"]),
        ("[value]\nlamp_pitch_mm = 3.0\n", ["lamp_pitch_mm", "3.4"]),
        ("[value]\nlamp_count = 40\n", ["lamp_count", "392.26"]),
    ],
)
def test_every_refusal_names_file_key_value_and_range(tmp_path, text, words):
    refused(write(tmp_path, f'extends = "{MPF}"\n' + text), *words)


def test_a_file_without_base_needs_every_value(tmp_path):
    refused(write(tmp_path, 'layers = ["film"]\n[value]\nlamp_count = 3\n'), "missing")


def test_a_file_that_extends_itself_is_refused(tmp_path):
    refused(write(tmp_path, 'extends = "own.toml"\n'), "extends itself")


def test_overrides_are_checked_like_values():
    refused(MPF, "stack.override", "thickness_mm", "0.1 … 1000", thickness=-3.0)
    refused(MPF, "stack.override", "film_indx", overrides={"film_indx": 1.5})
    refused(MPF, "thickness_mm", "5.2", thickness=5.0)
    refused(MPF, "nan", thickness=math.nan)
    refused(MPF, "stack.override.film_index: {}", overrides={"film_index": {}})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('source = "tubes"\n', ["source", "expected a table"]),
        ('[source]\nkind = "candles"\n', ["source.kind", "candles", "expected tubes, leds"]),
        ('[source]\nkind = "tubes"\nsize = 3\n', ["source.size", "unknown key"]),
    ],
)
def test_an_unknown_light_source_is_refused(tmp_path, text, words):
    refused(write(tmp_path, f'extends = "{MPF}"\n' + text), *words)
