"""The screen's mesh: catalogue figures, formulas, and what it refuses."""

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask
from mpfcad.mask.fabric import MESHES, build_mesh, coarsest_mesh, find_mesh

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)


@pytest.mark.parametrize(
    ("name", "open_area", "volume"), [("90-40", 42, 25), ("90-48", 33, 24), ("90-54", 27, 23)]
)
def test_the_catalogue_figures_come_out(name, open_area, volume):
    mesh = MESHES[name]
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
    with pytest.raises(InputError, match=r"^here: 250 threads/cm of 48 µm: finer than its thread"):
        build_mesh(250, 0.048, where="here")
    with pytest.raises(InputError, match=r"'91-48': allowed one of 43-80, .*180-27"):
        find_mesh("91-48")


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
    assert "no common mesh would do: 180-27 needs 55.56 µm, as with a period of " in text
    period = float(text.split()[-2]) / 1000
    rules = MaskRules("slot", period * 1.001, 0.010, 0.015, mesh=find_mesh("180-27"))
    build_mask(film_of([62.0] * 3), PROCESS, rules, "job")
