"""A mesh that states no unit: a film in another unit is named."""

import numpy as np
import pytest
from harness import BARE, extruded, row, write_facets

from mpfcad.errors import InputError
from mpfcad.optics.solid.mesh import read_film_mesh


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1e3, "in µm it would be 0.1"), (1e-3, "in m it would be 0.1")],
)
def test_a_film_far_from_mm_is_refused_with_its_unit(tmp_path, factor, words):
    facets = extruded(*row([BARE] * 2, 0.15), 0.1)
    write_facets(tmp_path / "film.stl", facets * factor)
    with pytest.raises(InputError, match=r"film\.stl: mesh: .* mm high: expected .*" + words):
        read_film_mesh(tmp_path / "film.stl")


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1 / 25.4, "in inch it would be 0.1"), (1 / 0.0254, "in mil it would be 0.1"),
     (1.0, None)],
)  # fmt: skip
def test_a_film_that_may_be_in_inch_is_said(tmp_path, factor, words):
    facets = extruded(*row([BARE] * 2, 0.15), 0.1)
    write_facets(tmp_path / "film.stl", np.round(facets * factor, 9))
    note = read_film_mesh(tmp_path / "film.stl").note
    assert (words in note) if words else ("would be" not in note)


def test_a_ply_whose_facets_have_no_vertices(tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
    head += "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    (tmp_path / "a.ply").write_text(head + "3 0 1 2\n")
    with pytest.raises(InputError, match=r"a\.ply: .*expected"):
        read_film_mesh(tmp_path / "a.ply")


def test_step_under_another_name_says_what_it_is(tmp_path):
    path = tmp_path / "a.stl"
    path.write_text("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    with pytest.raises(InputError, match=r"a\.stl: begins as STEP, .*: expected a STEP file"):
        read_film_mesh(path)
