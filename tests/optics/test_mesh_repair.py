"""Repairs of meshes: each kind brings back the solid it was made from, and is counted."""

import numpy as np
import pytest
from harness import BARE, extruded, row
from solid import BOW, OVERHANG, SMALL, SQUARE, box, drawn, turned

from mpfcad.optics.solid.closed import find_fault, volume
from mpfcad.optics.solid.repair import describe_repair, repair_solid
from mpfcad.optics.solid.weld import weld

FILM = extruded(*row([BARE] * 2, 0.15), 0.1)
WALLS = np.ptp(FILM[..., 1], axis=1) > 0
TUBE = drawn(SQUARE, SMALL[::-1])
VOLUME = 0.1 * 0.1 * 0.1625


def repaired(facets):
    """Return the repair, and the mesh as float32 holds it."""
    repair = repair_solid(*weld(np.asarray(facets, "<f4")))
    return repair, weld(repair.vertex[repair.facet].astype("<f4"))


def flipped(facets, which):
    return np.where(which[:, None, None], facets[:, ::-1], facets)


def scattered(facets, by, seed=1):
    return facets + np.random.default_rng(seed).uniform(-by, by, facets.shape)


SOME = np.random.default_rng(1).random(len(FILM)) < 0.4
CASES = {
    "one facet missing": (np.delete(FILM, 3, axis=0), {"filled_holes": 1}, VOLUME),
    "both ends missing": (FILM[WALLS], {"filled_holes": 2}, VOLUME),
    "ends of a tube": (TUBE[np.ptp(TUBE[..., 1], axis=1) > 0], {"filled_holes": 4}, 0.09375),
    "inverted": (FILM[:, ::-1], {"turned_facets": len(FILM)}, VOLUME),
    "an inverted tube": (TUBE[:, ::-1], {"turned_facets": len(TUBE)}, 0.09375),
    "some turned": (flipped(FILM, SOME), {"turned_facets": int(SOME.sum())}, VOLUME),
    "some twice": (np.r_[FILM, FILM[:5]], {"dropped_facets": 5}, VOLUME),
    "one twice, once turned": (np.r_[FILM, FILM[:1, ::-1]], {"dropped_facets": 1}, VOLUME),
    "a flap": (np.r_[FILM, FILM[:1], FILM[:1, ::-1]], {"dropped_facets": 2}, VOLUME),
    "corners apart": (scattered(FILM, 2e-5), {}, VOLUME),
    "two bodies that overlap": (
        np.r_[drawn(SQUARE), drawn([(x + 0.75, z + 0.5) for x, z in SQUARE])],
        {"united_bodies": 2}, 0.1875,
    ),
    "two turned boxes that overlap": (
        turned(np.r_[box((0, 0, 0), (1, 1, 1)), box((0.5, 0.5, 0.5), (1.5, 1.5, 1.5))]),
        {"united_bodies": 2}, 1.875,
    ),
    "lines that cross": (drawn(BOW, fan=True), {"united_bodies": 1}, 1 / 30),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_each_fault_is_repaired_and_counted(name):
    facets, changes, whole = CASES[name]
    assert find_fault(*weld(np.asarray(facets, "<f4")))
    repair, solid = repaired(facets)
    assert find_fault(*solid) is None
    # float32 keeps seven digits; scattered corners move the faces by up to 2e-5 of 0.1 mm.
    assert volume(*solid) == pytest.approx(whole, rel=1e-3 if name == "corners apart" else 1e-6)
    for change, count in changes.items():
        assert getattr(repair, change) == count
        assert f"{count}" in describe_repair(repair)
    if name == "corners apart":
        assert repair.merged_corners > 20 and len(solid[0]) == len(weld(FILM.astype("<f4"))[0])


def test_a_sound_mesh_is_left_as_it_is():
    for facets in (FILM, TUBE, drawn(OVERHANG)):
        repair, _ = repaired(facets)
        assert describe_repair(repair) == ""
        assert (repair.facet == weld(facets.astype("<f4"))[1]).all()


def test_what_is_not_plain_is_left_to_be_refused():
    # A hole over an edge is not flat; a point contact is one after any union.
    tip = np.flatnonzero((FILM[:, :, 2] > 0.17).sum(axis=1) >= 2)
    bent = np.delete(FILM, tip[(FILM[tip] != 0.1).any(axis=2).all(axis=1)][:4], axis=0)
    assert find_fault(*repaired(bent)[1]).startswith("open")
    corner = np.r_[box((0, 0, 0), (1, 1, 1)), box((1, 1, 1), (2, 2, 2))]
    assert find_fault(*repaired(corner)[1]).startswith("touches")
