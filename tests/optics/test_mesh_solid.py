"""Meshes that cross or touch themselves, or whose bodies lie wrongly: found in their place."""

import re

import numpy as np
import pytest
from harness import BARE, CONCAVE, extruded, row, write_facets
from scipy.spatial.transform import Rotation
from solid import BESIDE, BOW, NOTCH, OVERHANG, SMALL, SPIKE, SQUARE, box, drawn, turned

from mpfcad.errors import InputError
from mpfcad.optics.solid.closed import find_fault, is_height_field
from mpfcad.optics.solid.crossing_facet import facet_contact
from mpfcad.optics.solid.crossing_section import extruded_section, section_contact
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.optics.solid.weld import weld


def fault(facets):
    return find_fault(*weld(np.asarray(facets, "<f4")))


def place(text):
    return np.array([float(v) for v in re.search(r"\((.*?)\) mm", text).group(1).split(",")])


#: Name: outlines, what is said, x and z of the place.
WRONG = {
    "bow": ([BOW], "crosses itself", (1 / 3, 2 / 3)),
    "spike": ([SPIKE], "touches itself", (1.0, 0.5)),
    "notch": ([NOTCH], "touches itself", (0.5, 0.0)),
    "overlap": ([SQUARE, [(x + 0.75, z + 0.5) for x, z in SQUARE]], "crosses itself", (1.0, 0.5)),
    "bodies side by side": ([SQUARE, BESIDE], "touches itself", None),
    "hole outside": ([SQUARE, [(x + 2, z) for x, z in SMALL[::-1]]], "a body is inverted", None),
    "body in a body": ([SQUARE, SMALL], "a body is inverted", None),
}
RIGHT = {
    "overhang": [OVERHANG],
    "hole": [SQUARE, SMALL[::-1]],
    "body in a hole": [SQUARE, SMALL[::-1], [(x / 2 + 0.18, z / 2 + 0.18) for x, z in SMALL]],
    "two": [SQUARE, [(x + 2, z) for x, z in SQUARE]],
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_in_a_section_is_found_in_its_place(name):
    rings, what, where = WRONG[name]
    text = fault(drawn(*rings, fan=True))
    assert text.startswith(what) and "\n" not in text
    if where:
        assert place(text)[[0, 2]] == pytest.approx(where, abs=1e-6)


@pytest.mark.parametrize("name", WRONG)
def test_the_same_by_facets_alone(name):
    # Which of several contacts is found first is another matter: the end faces lie on each other.
    found = facet_contact(*weld(drawn(*WRONG[name][0], fan=True).astype("<f4")))
    assert found[0].endswith("inverted" if name == "hole outside" else "itself")


@pytest.mark.parametrize("name", RIGHT)
def test_what_is_right_is_taken(name):
    facets = drawn(*RIGHT[name])
    solid = weld(facets.astype("<f4"))
    assert extruded_section(*solid) is not None
    assert find_fault(*solid) is None
    assert facet_contact(*solid) is None
    assert fault(turned(facets)) is None


def test_crossing_facets_are_found_in_their_place():
    # A small box through the top of a large one, along z, and touching in an edge or a corner.
    large = box((0, 0, 0), (1, 1, 1))
    for low, high, what in (
        ((0.4, 0.4, 0.5), (0.6, 0.6, 1.5), "crosses itself"),
        ((0.4, 0.4, 1.0), (0.6, 0.6, 1.5), "touches itself"),
        ((1.0, 0.4, 1.0), (1.5, 0.6, 1.5), "touches itself"),
    ):
        text = fault(np.concatenate([large, box(low, high)]))
        assert text.startswith(what), text
        assert (place(text) >= np.array(low) - 1e-6).all()
        assert (place(text) <= np.minimum(high, 1) + 1e-6).all()
    apart = box((0.4, 0.4, 1.0 + 2**-20), (0.6, 0.6, 1.5))
    assert fault(np.concatenate([large, apart])) is None


def test_two_boxes_that_share_a_corner_only_touch():
    text = fault(np.concatenate([box((0, 0, 0), (1, 1, 1)), box((1, 1, 1), (2, 2, 2))]))
    assert text.startswith("touches itself") and place(text) == pytest.approx((1, 1, 1))


@pytest.mark.parametrize("seed", range(3))
def test_random_crossings_of_two_boxes_are_told_from_boxes_apart(seed):
    # Two turned boxes: manifold3d says whether they have a volume in common.
    from manifold3d import Manifold, Mesh

    rng = np.random.default_rng(seed)
    unit = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)).reshape(-1, 3)
    outcome = []
    for _ in range(40):
        turns = Rotation.random(2, rng=rng)
        shift = rng.uniform(-1.7, 1.7, 3)
        pair = [(turns[k].apply(unit) + k * shift).astype("<f4").reshape(-1, 3, 3) for k in (0, 1)]
        solids = [weld(facets) for facets in pair]
        one, other = (Manifold(Mesh(v.astype("<f4"), f.astype(np.uint32))) for v, f in solids)
        together = (one ^ other).volume() > 0
        outcome.append(together)
        found = facet_contact(*weld(np.concatenate(pair)))
        assert (found is not None) == together
    assert 5 < sum(outcome) < 35


def test_a_film_is_known_to_be_one_height():
    solid = weld(extruded(*row([CONCAVE, BARE], 0.15), 0.1).astype("<f4"))
    assert is_height_field(*solid)
    assert section_contact(extruded_section(*solid)) is None
    assert facet_contact(*solid) is None
    assert not is_height_field(*weld(drawn(OVERHANG).astype("<f4")))


def test_a_crossing_film_is_refused_in_one_line(tmp_path):
    x, z = row([BARE] * 2, 0.15)
    x[2], z[2] = 0.090, 0.155  # a tip within the wall of the next
    outline = [(0, 0), (0.1, 0), *zip(x[::-1], z[::-1], strict=True)]
    path = write_facets(tmp_path / "a.stl", drawn(outline, fan=True))
    with pytest.raises(InputError) as caught:
        read_film_mesh(path)
    assert str(caught.value).startswith(f"{path}: mesh: crosses itself at (0.0")
    assert "\n" not in str(caught.value)
