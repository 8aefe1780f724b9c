"""The table of a film mesh against closed forms, reference figures and the film itself."""

from itertools import pairwise

import numpy as np
import pytest
from harness import BARE, extruded, film_mesh, pass_layers, within, write_facets

from mpfcad.optics.bsdf.basis import klems_basis
from mpfcad.optics.bsdf_film import trace_film_bsdf
from mpfcad.optics.element import BsdfSheet, Film
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import read_film_mesh

FULL, QUARTER = klems_basis("LBNL/Klems Full"), klems_basis("LBNL/Klems Quarter")


def fresnel_slab(sin2, index):
    """Return the transmittance (1-R)/(1+R) of a clear slab, R from the amplitudes."""
    cosine, inner = np.sqrt(1 - sin2), np.sqrt(1 - sin2 / index**2)
    s = ((cosine - index * inner) / (cosine + index * inner)) ** 2
    p = ((index * cosine - inner) / (index * cosine + inner)) ** 2
    reflectance = (s + p) / 2
    return (1 - reflectance) / (1 + reflectance)


def test_a_flat_film_is_the_fresnel_slab(tmp_path):
    path = write_facets(tmp_path / "flat.stl", extruded([0.0, 0.05], [0.2, 0.2], 0.1))
    made = trace_film_bsdf(read_film_mesh(path), 1.49, FULL, rays=4000)
    edge = FULL.sin2_edge
    part = (np.arange(400) + 0.5) / 400
    ring = [fresnel_slab(a + (b - a) * part, 1.49).mean() for a, b in pairwise(edge)]
    expected = np.array(ring)[FULL.ring]
    for side in (0, 1):
        within(made.traced.energy[0, side], expected, made.energy_error[side], 4.5)
    np.testing.assert_allclose(made.table.energy.sum(axis=0), 1.0, rtol=1e-12)
    # Direct and mirrored light stays in its bin: the diagonal.
    off = made.table.chance * (1 - np.eye(145))
    assert off.max() < 1e-12
    # 0.8471 of Lambertian light (docs/tracing.md).
    within(made.table.hemispherical[0, 0], 0.8471, 0.36 / np.sqrt(4000 * 290), 4)


def test_the_bare_film_and_its_table_pass_as_much(tmp_path):
    mesh = film_mesh(tmp_path, [BARE])
    made = trace_film_bsdf(mesh, 1.5, QUARTER, rays=4000)
    assert made.table.reciprocity_error < 1e-12
    assert made.traced.reciprocity_error < 4 * made.noise
    np.testing.assert_allclose(made.table.energy.sum(axis=0), 1.0, rtol=1e-12)
    # 0.5382 ± 0.0001 (docs/tracing.md): sums over all rays, at most √(1/4n).
    error = 0.5 / np.sqrt(4000 * 82)
    within(made.table.hemispherical[0], 0.5382, error, 4)
    out = np.empty((100_000, 4))
    pass_layers(build_scene([BsdfSheet(made.table)]), True, 5, out)
    within((out[:, 0] == 1).mean(), 0.5382, np.hypot(error, 0.5 / np.sqrt(1e5)), 4)


def test_the_table_sends_light_where_the_film_does(tmp_path):
    # Lambertian light through both: the same histogram of ways out, within the noise of each.
    mesh = film_mesh(tmp_path, [BARE])
    made = trace_film_bsdf(mesh, 1.5, QUARTER, rays=8000)
    number = []
    for element in (Film(mesh, 1.5), BsdfSheet(made.table, 0.0)):
        out = np.empty((150_000, 4))
        pass_layers(build_scene([element]), True, 6, out)
        o = QUARTER.bin_of(out[:, 1], out[:, 2]) + np.where(out[:, 0] == 1, 0, 41)
        number.append(np.bincount(o, minlength=82))
    mean = sum(number) / 2
    # The table's own noise: half of the film's light in a bin came from 8000·82 rays.
    variance = mean * (2 + 150_000 / (8000 * 41))
    within(number[0] - number[1], 0.0, np.sqrt(np.maximum(variance, 1)), 4.5)


@pytest.mark.parametrize("threads", [1, 2])
def test_threads_do_not_change_a_bit(tmp_path, threads):
    mesh = film_mesh(tmp_path, [BARE])
    made = trace_film_bsdf(mesh, 1.5, QUARTER, rays=200, threads=threads, seed=9)
    assert made.traced.chance.sum() == pytest.approx(82)
    again = trace_film_bsdf(mesh, 1.5, QUARTER, rays=200, threads=3, seed=9)
    assert np.array_equal(made.table.value, again.table.value)
