"""Resin that scatters in the grooves: equal to the oracle, to a plate, and to nothing if none."""

from dataclasses import replace

import numpy as np
import pytest
from harness import (
    BARE,
    extruded,
    film_mesh,
    groove,
    pass_layers,
    single_paths,
    within,
    write_facets,
)
from oracle.tracer import Philox, ReferenceTracer

from mpfcad.optics.base.phase import phase_quantiles
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
SHEET = Sheet(0.3, 1.49, 1.0)
FILLED = [groove(60.0, chords=5), groove(30.0, chords=5)]
COSINE = np.linspace(-1, 1, 201)
PHASE = phase_quantiles(COSINE, 1 + COSINE**2)


def film(folder, grooves=FILLED, scattering=40.0, accelerator=None, **how):
    prism = film_mesh(folder, [BARE] * len(grooves))
    mesh = film_mesh(folder, grooves)
    resin = Resin(prism, scattering, **how)
    return Film(mesh, 1.55, offset=0.013, accelerator=accelerator, resin=resin)


@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
@pytest.mark.parametrize("how", [{"asymmetry": 0.5}, {"phase": PHASE}], ids=["HG", "table"])
def test_paths_through_scattering_resin_equal_the_oracle(tmp_path, accelerator, how):
    one = film(tmp_path, accelerator=accelerator, **how)
    plate = Slab(1.49, 2.0, 0.6, 0.0036, 0.8, **({"phase": PHASE} if "phase" in how else {}))
    elements = [CAVITY, plate, one, SHEET, replace(one, rotation=np.pi / 2, flipped=True)]
    found = np.empty(20)
    flow = np.zeros(len(FLOWS) + len(elements))
    source = Source(EYE, np.array([0.1]), 0.05, acceptance=0.5)
    single_paths(build_scene(elements), source, 1, 0, found, flow)
    oracle = ReferenceTracer(elements)
    expected = [oracle.radiance(0.1, 0.05, 0.5, Philox(1, EYE, p, 1)) for p in range(20)]
    assert np.any(expected)
    away = np.abs(found - expected) / np.max(expected)
    # Last-bit differences grow 10…100 times at a lamp, and the light that it gives directly to the
    # next place on the reflector shows them.
    assert np.mean(away > 1e-9) <= 1 / 20 and away.max() < 1e-6


def transmittance(element, seed):
    source = Source(LAMBERTIAN_BELOW, np.zeros(1), 0.05)
    tally = trace(build_scene([element]), source, 400, seed=seed)
    assert tally.flow[FLOWS.index("lost")] == 0
    return tally.fraction[0], tally.fraction_error[0]


def test_a_full_groove_on_almost_no_prism_is_a_plate(tmp_path):
    flat = film_mesh(tmp_path, [groove(0.0)], base=0.175)
    low = extruded(BARE[0] + 0.025, 1e-3 + 1e-3 * BARE[1], 0.1)
    prism = read_film_mesh(write_facets(tmp_path / "prism.stl", low))
    thickness = flat.size[2]
    resin = Film(flat, 1.5, resin=Resin(prism, 10.0, 0.3))
    as_film, as_plate = (
        transmittance(element, seed)
        for seed, element in ((1, resin), (2, Slab(1.5, thickness, 10.0, 0.0, 0.3)))
    )
    clear, _ = transmittance(Slab(1.5, thickness), 3)
    within(as_film[0], as_plate[0], np.hypot(as_film[1], as_plate[1]), 4)
    assert clear - as_plate[0] > 0.1


def test_grooves_without_resin_do_not_scatter(tmp_path):
    with_none = transmittance(film(tmp_path, [BARE], scattering=500.0), 4)
    plain = transmittance(Film(film_mesh(tmp_path, [BARE]), 1.55), 5)
    within(with_none[0], plain[0], np.hypot(with_none[1], plain[1]), 4)


@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
def test_nothing_is_lost_and_as_much_passes_up_as_down(tmp_path, accelerator):
    scene = build_scene([film(tmp_path, scattering=100.0, accelerator=accelerator)])
    share = []
    for below in (True, False):
        out = np.empty((150_000, 4))
        pass_layers(scene, below, 6, out)
        assert (out[:, 0] != 0).all()
        share.append(np.mean(out[:, 0] == (1 if below else -1)))
    within(share[0], share[1], np.sqrt(sum(s * (1 - s) for s in share) / 150_000), 3.5)
