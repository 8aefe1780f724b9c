"""What a scene refuses, and which accelerator a mesh gets."""

import numpy as np
import pytest
from harness import BARE, CONCAVE, crossed_mesh, film_mesh, net_mesh

from mpfcad.errors import TraceError
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.scene import build_scene

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)


def accelerator(film):
    return build_scene([film]).accelerators


def test_the_mesh_alone_chooses_how_it_is_traced(tmp_path):
    assert accelerator(Film(film_mesh(tmp_path, [CONCAVE]), 1.5)) == "chain"
    crossed = crossed_mesh(tmp_path)
    assert accelerator(Film(crossed, 1.5)) == "grid"
    # Most facets lie about one place.
    line = np.r_[0.0, np.geomspace(1e-4, 1, 40)]
    bulge = line * (1 - line)
    uneven = net_mesh(line, 0.2 + bulge[:, None] * bulge)
    assert accelerator(Film(uneven, 1.5)) == "bvh"
    for mesh, way in ((crossed, "chain"), (uneven, "grid")):
        with pytest.raises(TraceError, match=way):
            build_scene([Film(mesh, 1.5, accelerator=way)])


def test_an_extrusion_may_be_traced_with_the_tree(tmp_path):
    assert accelerator(Film(film_mesh(tmp_path, [BARE]), 1.5, accelerator="bvh")) == "bvh"


def test_impossible_stacks_are_refused():
    for elements, words in (
        ([Sheet(0.3, 1.5, 1.0), CAVITY], "lowest"),
        ([Slab(1.5, 2.0, bonded=True)], "bonded"),
        ([Slab(1.5, 2.0, bonded=True), Sheet(0.3, 1.5, 1.0)], "bonded"),
    ):
        with pytest.raises(TraceError, match=words):
            build_scene(elements)


def test_elements_keep_their_numbers():
    scene = build_scene([CAVITY, Slab(1.49, 2.0, 0.6, 0.0036, 0.8), Sheet(0.36, 1.49, 0.98)])
    assert list(scene.kind) == [0, 1, 2]
    assert np.allclose(scene.parameter[0, :9], (20, 32.69, 0, 3.5, 1.7, 20100, 0.75, 0.94, 0.3))
    assert np.allclose(scene.parameter[1, :6], (1.49, 2, 0.6, 0.0036, 0.8, 0))
    assert np.allclose(scene.parameter[2, :3], (0.36, 1.49, 0.98))


def moved(element):
    """Return an element whose fields stand the other way round, after one that is new."""
    copy = object.__new__(type(element))
    copy.__dict__.update({"added": 7.0, **dict(reversed(vars(element).items()))})
    return copy


def test_a_field_added_or_moved_shifts_no_column(tmp_path):
    film = Film(film_mesh(tmp_path, [BARE]), 1.5, rotation=0.3, offset=0.01)
    elements = [CAVITY, Slab(1.49, 2.0, 0.6, 0.0036, 0.8), Sheet(0.36, 1.49, 0.98), film]
    expected = build_scene(elements)
    found = build_scene([moved(element) for element in elements])
    assert np.array_equal(found.kind, expected.kind)
    assert np.array_equal(found.parameter, expected.parameter)


def test_an_element_of_no_known_kind_is_refused():
    with pytest.raises(TraceError, match="expected one of Cavity"):
        build_scene(["a mirror"])
