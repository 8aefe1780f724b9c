"""The screen's mesh: catalogue figures, formulas, and what it refuses."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask
from mpfcad.mask.fabric import (
    build_mesh,
    coarsest_mesh,
    find_mesh,
    read_catalogue,
    shipped_catalogue,
)

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)


@pytest.mark.parametrize(
    ("name", "open_area", "volume"), [("90-40", 42, 25), ("90-48", 33, 24), ("90-54", 27, 23)]
)
def test_the_catalogue_figures_come_out(name, open_area, volume):
    mesh = find_mesh(name)
    assert mesh.is_sourced
    assert round(100 * mesh.open_area) == open_area
    assert round(1000 * mesh.fabric_volume) == volume  # mm of height are 1000 cm³/m²


def test_a_full_groove_needs_12_5_cm3_a_square_metre():
    assert BEF.area / BEF.pitch * 1000 == pytest.approx(12.5)
    mesh = find_mesh("90-48")
    assert mesh.transfer_factor(BEF) == pytest.approx(1000 * mesh.volume / 12.5)
    assert mesh.release(BEF, mesh.transfer_factor(BEF, 0.6)) == pytest.approx(0.6)


def test_emulsion_adds_its_thickness():
    bare, coated = find_mesh("120-34"), find_mesh("120-34", emulsion=0.005)
    assert coated.volume - bare.volume == pytest.approx(0.005)
    assert coated.min_feature == bare.min_feature


def test_openings_follow_from_count_and_thread():
    mesh = build_mesh(100, 0.040)
    assert mesh.opening == pytest.approx(0.060)
    assert mesh.open_area == pytest.approx(0.36)


def test_a_mesh_finer_than_its_thread_is_refused():
    with pytest.raises(InputError, match=r"^here: thread_um: 48: .* 250 threads/cm leaves nothing"):
        build_mesh(250, 0.048, where="here: ")


@pytest.mark.parametrize(
    ("field", "value", "material", "expected"),
    [
        ("opening", 0.080, "polyester", "39.1 … 52.7: opening and thread (34 µm) make 83.33 µm"),
        ("opening", 0.030, "polyester", "39.1 … 52.7"),
        ("thickness", 0.300, "polyester", "34 … 74.8: 1 to 2.2 threads of 34 µm (polyester)"),
        ("thickness", 0.005, "polyester", "34 … 74.8"),
        ("thickness", 0.030, "steel", "34 … 74.8"),
        ("thickness", 0.025, "calendered steel", "27.2 … 74.8"),
    ],
)
def test_figures_that_no_weave_has_are_refused(field, value, material, expected):
    with pytest.raises(InputError) as error:
        build_mesh(120, 0.034, material=material, where="here.", **{field: value})
    assert str(error.value).startswith(f"here.{field}_um: {1000 * value:g}: expected {expected}")


def test_a_calender_makes_less_than_one_wire():
    build_mesh(120, 0.034, thickness=0.030, material="calendered steel")


@pytest.mark.parametrize(
    ("name", "volume"),
    [("43-80", 53), ("48-70", 46), ("54-64", 39), ("61-64", 30), ("77-55", 22), ("100-40", 20)],
)
def test_ink_volumes_of_a_weaver_lie_in_the_computed_interval(name, volume):
    """Theoretical ink volumes quoted of SEFAR PET 1500, cm³/m²; its threads per inch read so."""
    mesh = find_mesh(name)
    assert abs(1000 * mesh.fabric_volume - volume) < mesh.volume_width * 1000 * mesh.fabric_volume


def test_a_flattened_thread_closes_what_it_covers():
    # The trade journal's 305/40 per inch: 25 % open, 63 µm thick.
    assert find_mesh("120-40").open_area == pytest.approx(0.25, abs=0.001)
    # 61-64 with an opening of 90 µm holds SEFAR's 30 cm³/m².
    mesh = build_mesh(61, 0.064, opening=0.090, thickness=0.100)
    assert 1000 * mesh.fabric_volume == pytest.approx(30, abs=0.5)


@pytest.mark.parametrize(("count", "thread"), [(3, 0.034), (500, 0.010), (120, 0.003), (10, 0.5)])
def test_counts_and_threads_that_are_not_woven_are_refused(count, thread):
    with pytest.raises(InputError, match=r"^(threads_per_cm|thread_um): \S+: expected "):
        build_mesh(count, thread, where="")


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("120-34", "120-34"),
        ("120/305-34", "120-34"),
        ("305-34", "120-34"),
        ("120.34", "120-34"),
        ("120/305-34W PW", "120-34"),
        ("PET 1500 120/305-34Y PW", "120-34"),
        ("225-48", "90-48"),
        ("90/225-40", "90-40"),
        ("355-34", "140-34"),
        ("460-27", "180-27"),
        (" 180-27Y ", "180-27"),
        ("SS 325-28", "SS 325-28"),
        ("128/325-28", "SS 325-28"),
        ("SUS 400-19", "SS 400-19"),
        ("stainless 500-19", "SS 500-19"),
        ("325-28 calendered", "SS 325-28 C"),
        ("400-18 C", "SS 400-18 C"),
    ],
)
def test_the_trade_s_spellings(text, name):
    assert find_mesh(text).name == name


@pytest.mark.parametrize(
    ("text", "near"),
    [
        ("91-48", "90-48, 95-48, 100-48"),
        ("120T", "120-31, 120-34"),
        ("460/27", "180-27"),
        ("?", "43"),
        ("{}-0", ""),
        ("0", ""),
        ("9" * 400 + "-31", ""),
        ("120-" + "9" * 400, "120-31"),
    ],
)
def test_an_unknown_name_lists_the_nearest(text, near):
    with pytest.raises(InputError, match=rf"^here: '.*': not in the catalogue: .*{near}"):
        find_mesh(text, where="here")


def test_the_catalogue_has_the_trade_s_meshes():
    meshes = shipped_catalogue()
    assert len(meshes) >= 60
    assert {mesh.material for mesh in meshes} == {"polyester", "steel", "calendered steel"}
    assert all(42.5 < mesh.count * 10 < 200 for mesh in meshes)
    # Every name in the catalogue means its own mesh, and what is sourced says from where.
    assert all(find_mesh(mesh.name).name == mesh.name for mesh in meshes)
    assert all(mesh.is_sourced == mesh.source.startswith("figures:") for mesh in meshes)
    assert all(bool(mesh.computed) != mesh.is_sourced for mesh in meshes)


def test_how_far_steel_was_rolled_is_carried():
    woven, rolled = find_mesh("SS 325-28"), find_mesh("SS 325-28 C")
    assert rolled.thickness < woven.thickness and rolled.volume_width > 2 * woven.volume_width


def test_what_is_computed_carries_its_width():
    for mesh in shipped_catalogue():
        assert mesh.is_sourced == ("computed" not in mesh.source)
        assert (0.01 < mesh.volume_width < 0.03) == mesh.is_sourced
        assert mesh.volume_width < {"polyester": 0.4, "steel": 0.2}.get(mesh.material, 0.3)
    # The rule for thickness holds for the meshes whose thickness is known.
    for mesh in (mesh for mesh in shipped_catalogue() if mesh.is_sourced):
        guess = build_mesh(mesh.count * 10, mesh.thread)
        assert abs(guess.thickness - mesh.thickness) <= guess.thickness_width + 0.0005
        assert abs(guess.opening - mesh.opening) <= guess.opening_width + 0.0005


HEADER = "name,material,threads_per_cm,thread_um,opening_um,thickness_um,source\n"


def test_a_weaver_s_table_is_a_catalogue(tmp_path):
    file = tmp_path / "weaver.csv"
    file.write_text(HEADER + 'SD 165/30,steel,165,30,30.6,46,"sheet, 2025"\n', "utf-8")
    (mesh,) = read_catalogue(file)
    assert (mesh.material, mesh.is_sourced) == ("steel", True)
    assert find_mesh("sd 165/30", catalogue=(mesh,)) is not None
    assert find_mesh("165-30", catalogue=(mesh,), emulsion=0.004).emulsion == 0.004


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("a,polyester,120,34,,", "row 2: 6 columns: expected 7"),
        (
            "a,nylon,120,34,,,x",
            "row 2: material: 'nylon': expected 'polyester', 'steel' or 'calendered steel'",
        ),
        ("a,steel,120,,,,x", "row 2: thread_um: '': expected a number above 0"),
        ("a,steel,120,34,-3,,x", "row 2: opening_um: '-3': expected a number above 0"),
        ("a,steel,120,34,300,,x", "row 2: opening_um: 300: expected 39.1 … 52.7"),
        ("a,steel,120,34,49,5,x", "row 2: thickness_um: 5: expected 34 … 74.8"),
        ("a,steel,120,90,,,x", "row 2: thread_um: 90: a mesh of 120 threads/cm leaves"),
        ("a,steel,120,34,,,", "row 2: name, source: expected both"),
        ("a,steel,120,34,,,x\nA,steel,100,34,,,x", "row 3: name: A: expected it once"),
    ],
)
def test_a_table_that_is_wrong_is_refused(tmp_path, row, words):
    file = tmp_path / "weaver.csv"
    file.write_text(HEADER + row + "\n", "utf-8")
    with pytest.raises(InputError, match=r"weaver\.csv: ") as error:
        read_catalogue(file)
    assert words in str(error.value)


def test_the_coarsest_mesh_gives_most_resin():
    assert coarsest_mesh(0.112).name == "90-40"
    assert coarsest_mesh(0.054) is None


def film_of(curvature):
    return PrismFilm(BEF, 0.2, 50.0, "filled", np.asarray(curvature, float))


def refusal(curvature, rules):
    with pytest.raises(InputError) as error:
        build_mask(film_of(curvature), PROCESS, rules, "job")
    return str(error.value)


def test_grooves_that_a_mesh_cannot_print_are_named_with_the_mesh_that_would():
    # C = 60 needs ratio 0.0593: 59 µm of 1 mm; a cell of 90 threads/cm is 111 µm.
    coarse = MaskRules("slot", 1.0, 0.015, 0.015, mesh=find_mesh("90-48"))
    text = refusal([52.0, 60.0, 60.0, 52.0], coarse)
    assert "grooves 1-2: " in text
    assert "min_aperture 111.1 µm" in text
    assert "mesh 180-27 would do" in text
    fine = MaskRules("slot", 1.0, 0.015, 0.015, mesh=find_mesh("180-27"))
    assert build_mask(film_of([52.0, 60.0]), PROCESS, fine, "job").aperture_count == 100


def test_without_a_mesh_that_would_do_the_period_is_named():
    text = refusal([62.0] * 3, MaskRules("slot", 0.4, 0.010, 0.015, mesh=find_mesh("120-34")))
    assert "no mesh at this period: 180-27 needs 55.56 µm (period " in text
    period = float(text.split("(period ")[1].split()[0]) / 1000
    rules = MaskRules("slot", period * 1.001, 0.010, 0.015, mesh=find_mesh("180-27"))
    build_mask(film_of([62.0] * 3), PROCESS, rules, "job")
