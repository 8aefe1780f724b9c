"""Resin of another index or absorption than the prisms: the oracle, plates, and laws of light."""

import math
from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, extruded, film_mesh, groove, write_facets
from test_film_materials import passed, plates
from test_reference import BOTTOM, CAVITY, TOP, compare

from mpfcad.errors import InputError
from mpfcad.optics.element import Film, Slab
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.solid.mesh import read_film_mesh

FILLED = [groove(60.0, chords=5), groove(30.0, chords=5)]


def film(folder, grooves=FILLED, accelerator=None, prism_absorption=0.0, **resin):
    prism = film_mesh(folder, [BARE] * len(grooves))
    own = {"index": 1.48, **resin}
    mesh = film_mesh(folder, grooves)
    return Film(
        mesh, 1.6, offset=0.013, accelerator=accelerator, absorption=prism_absorption,
        resin=Resin(prism, **own),
    )  # fmt: skip


@pytest.mark.parametrize("accelerator", ["chain", "section", "bvh"])
@pytest.mark.parametrize(
    "how",
    [{}, {"absorption": 8.0}, {"index": 1.7, "scattering": 40.0, "asymmetry": 0.5}],
    ids=["index", "absorption", "scattering"],
)
def test_paths_through_resin_of_another_material_equal_the_oracle(tmp_path, accelerator, how):
    one = film(tmp_path, accelerator=accelerator, prism_absorption=2.0, **how)
    compare([CAVITY, BOTTOM, one, TOP], 30, grown=1 / 30)


def test_films_that_lie_otherwise_equal_the_oracle(tmp_path):
    one = film(tmp_path, prism_absorption=1.0, absorption=5.0)
    turned = replace(one, rotation=0.4)
    over = replace(one, rotation=math.pi / 2, flipped=True)
    base = Slab(1.65, 0.1, 0.0, 0.3, bonded=True)
    compare([base, replace(one, index_below=1.65), turned, over], 30, below=1.0)


def test_flat_resin_on_almost_no_prism_is_two_bonded_plates(tmp_path):
    flat = film_mesh(tmp_path, [groove(0.0)], base=0.175)
    low = extruded(BARE[0] + 0.025, 0.1 + 1e-5 * BARE[1], 0.1)
    prism = read_film_mesh(write_facets(tmp_path / "prism.stl", low))
    resin = Resin(prism, index=1.42, absorption=3.0)
    layers = [(1.7, 0.1, 0.8), (1.42, flat.size[2] - 0.1, 3.0)]
    node, weight = np.polynomial.legendre.leggauss(200)
    mu, weight = (node + 1) / 2, weight / 2
    exact = np.array([plates(m, layers) for m in mu])
    wanted = 2 * (exact * (mu * weight)[:, None]).sum(axis=0)
    found = passed([Film(flat, 1.7, resin=resin, absorption=0.8)], True)
    for (value, error), expected in zip(found, wanted, strict=True):
        assert abs(value - expected) < 4 * error + 1e-4, (value, expected, error)


@pytest.mark.parametrize("how", [{}, {"absorption": 8.0}, {"scattering": 60.0}], ids=str)
@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
def test_nothing_is_lost_and_light_passes_both_ways_alike(tmp_path, accelerator, how):
    one = film(tmp_path, accelerator=accelerator, **how)
    up, down = (passed([one], side, seed=3) for side in (True, False))
    assert abs(up[0][0] - down[0][0]) < 4 * math.hypot(up[0][1], down[0][1])
    for (through, _), (back, _) in (up, down):
        if "absorption" in how:
            assert through + back < 0.99
        else:
            assert through + back == pytest.approx(1, abs=1e-12)


def test_grooves_without_resin_are_the_plain_film(tmp_path):
    with_none = passed([film(tmp_path, [BARE], index=1.2, absorption=50.0)], True)
    plain = passed([Film(film_mesh(tmp_path, [BARE]), 1.6, offset=0.013)], True, seed=2)
    for (a, e), (b, f) in zip(with_none, plain, strict=True):
        assert abs(a - b) < 4 * math.hypot(e, f)


def test_resin_almost_of_the_prisms_index_is_the_matched_film(tmp_path):
    near = passed([film(tmp_path, index=1.6 + 1e-7)], True)
    matched = film(tmp_path, index=1.6, absorption=0.0)
    assert not matched.shows_prism
    same = passed([matched], True, seed=2)
    for (a, e), (b, f) in zip(near, same, strict=True):
        assert abs(a - b) < 4 * math.hypot(e, f)


@pytest.mark.parametrize(
    ("how", "words"),
    [({"index": 0.9}, "resin.index"), ({"absorption": -1.0}, "resin.absorption")],
)
def test_wrong_resins_are_refused(tmp_path, how, words):
    with pytest.raises(InputError, match=words):
        film(tmp_path, **how)
