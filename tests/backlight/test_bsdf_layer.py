"""Stacks with BSDF tables: read, refused, traced, described and restored."""

from pathlib import Path
from shutil import copyfile

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.backlight.stored import describe_stack, restore_stack
from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import klems_basis, ring_basis
from mpfcad.optics.bsdf.file import bsdf_texts, write_texts
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.element import BsdfSheet, Cavity

BACK_ONLY = Path(__file__).parents[1] / "optics" / "case" / "white-black-back-only.xml"
QUARTER = klems_basis("LBNL/Klems Quarter")
RINGS = ring_basis(np.radians([0, 15, 45, 90]), 4)


def write_table(folder, name="sheet", transmitted=0.7, reflected=0.2, form="csv"):
    value = np.empty((2, 2, 3, RINGS.count))
    value[0], value[1] = transmitted / np.pi, reflected / np.pi
    write_texts(folder, bsdf_texts(BsdfTable(name, RINGS, True, value), name, form))


def write_stack(folder, layers, more=""):
    path = folder / "stack.toml"
    path.write_text(f'extends = "thesis-32in-mpf"\nlayers = [{layers}]\n{more}\n')
    return path


def test_tables_stand_where_the_layers_say(tmp_path):
    write_table(tmp_path)
    write_table(tmp_path, "white", 0.0, 0.9, "klems")
    path = write_stack(
        tmp_path,
        '"clear_plate", { kind = "bsdf", file = "sheet.csv", interpolation = "none", '
        'tag = "sourced", source = "a data sheet" }, "top_sheet", { kind = "bsdf", '
        'name = "white", file = "white.xml", reciprocal = true }',
        'reflector = { file = "white.xml" }',
    )
    stack = read_stack(path)
    assert stack.layers == ("clear_plate", "bsdf_2", "top_sheet", "white")
    assert not stack.has_slot
    elements = lower_stack(stack, None)
    assert [e.name for e in elements[1:] if isinstance(e, BsdfSheet)] == ["bsdf 2", "white"]
    assert [e.blend for e in elements if isinstance(e, BsdfSheet)] == [0.0, 1.0]
    assert isinstance(elements[0], Cavity) and elements[0].brdf is stack.tables["reflector"].table
    rows = {row["name"]: row for row in stack.inputs()}
    assert rows["bsdf_2"]["tag"] == "sourced" and "a data sheet" in rows["bsdf_2"]["source"]
    assert rows["reflector"]["value"] == "white.xml"
    assert stack.tables["bsdf_2"].sha256 in rows["bsdf_2"]["source"]


def test_a_stack_with_tables_is_restored_from_its_description(tmp_path):
    write_table(tmp_path)
    layers = '"clear_plate", { kind = "bsdf", file = "sheet.csv" }, "film", "top_sheet"'
    stack = read_stack(write_stack(tmp_path, layers, 'reflector = { file = "sheet.csv" }'))
    (tmp_path / "sheet.csv").unlink()
    again = restore_stack(describe_stack(stack))
    assert again.layers == stack.layers
    for name in ("bsdf_2", "reflector"):
        assert np.array_equal(again.tables[name].table.value, stack.tables[name].table.value)
        assert again.tables[name].sha256 == stack.tables[name].sha256
        assert again.tables[name].blend == stack.tables[name].blend
    assert describe_stack(again) == describe_stack(stack)


@pytest.mark.parametrize(
    ("layers", "words"),
    [
        ('{ kind = "bsdf", file = "gone.csv" }', "gone.csv: no such file"),
        ('{ kind = "bsdf" }', "layers: bsdf_1: file: None: expected a file name"),
        ('{ kind = "glass", file = "sheet.csv" }', "expected a name, or a table with a kind of"),
        ('{ kind = "bsdf", file = "sheet.csv", size = 1 }', "layers: bsdf_1: size: unknown key"),
        ('{ kind = "bsdf", file = "sheet.csv", interpolation = "cubic" }', "linear or none"),
        ('{ kind = "bsdf", file = "sheet.csv", interpolation = [] }', "linear or none"),
        ('{ kind = "bsdf", file = "sheet.csv", symmetric = 1 }', "symmetric: 1: expected true"),
        ('{ kind = "bsdf", file = "sheet.csv", reflection = 1.2 }', "reflection: 1.2: expected 0"),
        ('{ kind = "bsdf", file = "sheet.csv", reflection = "all" }', "or lossless"),
        ('{ kind = "bsdf", file = "back.xml" }', "transmission from below: not in the file"),
        ('{ kind = "bsdf", file = "sheet.csv", reciprocal = 1 }', "reciprocal: 1: expected true"),
        ('{ kind = "bsdf", file = "hot.csv" }', "hot.csv: light from below, incidence"),
        ('"bsdf"', "layers: 'bsdf': expected one of"),
        (
            '{ kind = "bsdf", name = "reflector", file = "sheet.csv" }',
            "name: expected one that no named layer has",
        ),
        ('"top_sheet"', "0 films for the job's film: expected exactly one"),
    ],
)
def test_wrong_tables_are_refused(tmp_path, layers, words):
    write_table(tmp_path)
    write_table(tmp_path, "hot", 0.9, 0.2)
    copyfile(BACK_ONLY, tmp_path / "back.xml")
    with pytest.raises(InputError) as error:
        read_stack(write_stack(tmp_path, layers))
    assert words in str(error.value)


def test_a_mesh_and_a_film_go_together(tmp_path):
    write_table(tmp_path)
    stack = read_stack(write_stack(tmp_path, '{ kind = "bsdf", file = "sheet.csv" }'))
    with pytest.raises(InputError, match="has no film: expected no mesh"):
        lower_stack(stack, object())
    with pytest.raises(InputError, match="its film needs a mesh"):
        lower_stack(read_stack("thesis-32in-mpf"), None)


def test_what_is_said_of_a_missing_side_stands_in_the_inputs_and_is_restored(tmp_path):
    copyfile(BACK_ONLY, tmp_path / "back.xml")
    path = write_stack(
        tmp_path,
        '"clear_plate", { kind = "bsdf", name = "white", file = "back.xml", reflection = 0.0 }',
        # A reflector is lit from above only.
        'reflector = { file = "back.xml" }',
    )
    stack = read_stack(path)
    rows = {row["name"]: row for row in stack.inputs()}
    assert "reflection from below: Lambertian (reflection = 0)" in rows["white"]["source"]
    assert "transmission from below: by reciprocity from above" in rows["white"]["source"]
    assert "reflection from below: not in the file" in rows["reflector"]["source"]
    again = restore_stack(describe_stack(stack))
    assert describe_stack(again) == describe_stack(stack)


def test_files_that_are_no_unicode_are_restored_as_the_same_bytes(tmp_path):
    copyfile(BACK_ONLY.parent / "comment-cp1252.bsdf", tmp_path / "a.bsdf")
    layers = (
        '"clear_plate", { kind = "bsdf", name = "a", file = "a.bsdf", symmetric = true, '
        "transmission = 0.5 }"
    )
    stack = read_stack(write_stack(tmp_path, layers))
    again = restore_stack(describe_stack(stack))
    assert again.tables["a"].sha256 == stack.tables["a"].sha256
    assert np.array_equal(again.tables["a"].table.value, stack.tables["a"].table.value)
