"""Stacks of many layers, of a whole panel and with resin that scatters, and what is traced."""

import numpy as np
import pytest
from harness import BARE, film_file, film_mesh, groove

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.errors import InputError
from mpfcad.optics.element import Film, Sheet, Slab
from mpfcad.optics.scene import build_scene

MPF = "thesis-32in-mpf"
MANY = f"""
extends = "{MPF}"
layers = [
  "clear_plate",
  {{ kind = "plate", name = "second", thickness_mm = 1.0, scattering_per_mm = 0.5 }},
  "bottom_sheet",
  {{ kind = "bef", flipped = true }},
  "film",
  {{ kind = "film", name = "other", file = "other.stl", rotation_deg = 90, index = 1.6 }},
  {{ kind = "sheet", sigma = 0.1 }},
]
[value]
"second.index" = {{ value = 1.5, tag = "sourced", source = "data sheet" }}
"""


@pytest.fixture
def many(tmp_path):
    film_file(tmp_path / "other.stl", [groove(50.0)], length=0.2)
    path = tmp_path / "many.toml"
    path.write_text(MANY, encoding="utf-8")
    return path


def test_a_stack_of_many_layers(tmp_path, many):
    stack = read_stack(many, overrides={"other": {"rotation_deg": 80.0}, "bef_4.pitch_um": 24.0})
    assert stack.layers == (
        "clear_plate", "second", "bottom_sheet", "bef_4", "film", "other", "sheet_7",
    )  # fmt: skip
    assert [stack.kind_of(layer) for layer in stack.layers] == [
        "plate", "plate", "sheet", "film", "film", "film", "sheet",
    ]  # fmt: skip
    assert stack.sheet_count == 7
    mesh = film_mesh(tmp_path, [groove(60.0)])
    elements = lower_stack(stack, mesh, 0.01)
    _, _, plate, _, bef, film, other, sheet = elements
    assert isinstance(plate, Slab) and (plate.index, plate.thickness) == (1.5, 1.0)
    assert plate.scattering == 0.5
    assert isinstance(bef, Film) and bef.flipped and bef.mesh.size == (0.024, 0.024, 0.225)
    assert (film.mesh, film.offset, film.rotation) == (mesh, 0.01, 0.0)
    assert other.index == 1.6 and other.mesh.size[1] == pytest.approx(0.2)
    assert other.rotation == pytest.approx(np.radians(80))
    assert isinstance(sheet, Sheet) and sheet.sigma == 0.1 and sheet.index == 1.49
    assert len(build_scene(elements).tiles.size) == 3


def test_every_value_of_a_layers_own_has_a_tag_and_a_source(many):
    entries = {e["name"]: e for e in read_stack(many).inputs()}
    assert entries["second.index"]["tag"] == "sourced"
    assert entries["second.thickness_mm"]["tag"] == "given"
    assert entries["bef_4.index"]["source"].startswith("as film_index")
    assert entries["bef_4.pitch_um"]["tag"] == "assumed"
    assert all(e["tag"] in ("given", "sourced", "assumed") for e in entries.values())


def test_the_jobs_film_may_lie_crossed_and_upside_down(tmp_path):
    path = tmp_path / "own.toml"
    layers = 'layers = ["clear_plate", { kind = "film", rotation_deg = 90, flipped = true }]'
    path.write_text(f'extends = "{MPF}"\n{layers}\n', encoding="utf-8")
    film = lower_stack(read_stack(path), film_mesh(tmp_path, [BARE]))[-1]
    assert film.flipped and film.rotation == pytest.approx(np.pi / 2)


def test_a_film_bonded_on_a_plate_of_its_own(tmp_path):
    path = tmp_path / "own.toml"
    layers = 'layers = [{ kind = "plate", index = 1.6 }, "bonded_film"]'
    path.write_text(f'extends = "{MPF}"\n{layers}\n', encoding="utf-8")
    _, plate, film = lower_stack(read_stack(path), film_mesh(tmp_path, [BARE]))
    assert plate.bonded and film.index_below == plate.index == 1.6


def test_a_whole_panel_has_walls_and_its_lamps_one_by_one(tmp_path):
    over = {"extent": "panel", "lamp_3_luminance_factor": 0.8, "lamp_12_shift_mm": 1.5}
    stack = read_stack(MPF, overrides=over)
    panel = lower_stack(stack, film_mesh(tmp_path, [BARE]))[0].panel
    assert panel.right - panel.left == pytest.approx(392.26)
    assert (panel.near, panel.far) == pytest.approx((-697.68 / 2, 697.68 / 2))
    assert len(panel.lamp_position) == 12 and panel.lamp_position[5] == pytest.approx(0)
    assert panel.lamp_factor[2] == 0.8 and panel.lamp_factor[0] == 1.0
    assert panel.lamp_position[11] == pytest.approx(6 * 32.69 + 1.5)
    assert panel.wall_reflectance == stack["reflector_reflectance"]
    names = {e["name"] for e in stack.inputs()}
    assert {*over} - {"extent"} <= names and "wall_reflectance" in names
    assert "wall_reflectance" not in {e["name"] for e in read_stack(MPF).inputs()}


def test_scattering_resin_needs_the_prisms(tmp_path):
    stack = read_stack(MPF, overrides={"resin_scattering_per_mm": 5.0})
    assert stack["resin_asymmetry"] == 0 and stack.resin_scatters
    mesh = film_mesh(tmp_path, [groove(60.0)] * 2)
    with pytest.raises(InputError, match=r"resin_scattering_per_mm: .* --prism FILE"):
        lower_stack(stack, mesh)
    prism = film_file(tmp_path / "prism.stl", [BARE] * 2)
    film = lower_stack(stack.with_prism(prism), mesh)[3]
    assert film.resin.scattering == 5.0 and film.resin.phase is None
    narrow = film_file(tmp_path / "narrow.stl", [BARE])
    with pytest.raises(InputError, match="wide"):
        lower_stack(stack.with_prism(narrow), mesh)
    particles = {
        "resin_particle_radius_um": 5.0,
        "resin_particle_index": 1.45,
        "resin_particle_density_per_mm3": 1e5,
    }
    stack = read_stack(MPF, overrides=particles).with_prism(prism)
    resin = lower_stack(stack, mesh)[3].resin
    assert resin.scattering == pytest.approx(stack["resin_scattering_per_mm"]) and len(resin.phase)
