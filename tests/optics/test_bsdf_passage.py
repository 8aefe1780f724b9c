"""Scattering by a table: what is drawn is what the table says, with energy and reciprocity."""

from dataclasses import replace

import numpy as np
import pytest
from harness import BARE, film_mesh, pass_layers, single_paths, within
from numba import njit, uint64
from oracle.tracer import Philox, ReferenceTracer

from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE, start_path
from mpfcad.optics.bsdf.basis import even_basis, klems_basis, ring_basis
from mpfcad.optics.bsdf.passage import bsdf_scatter, build_bsdf
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import BsdfSheet, Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source
from mpfcad.store.kernel import kept

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
RINGS = ring_basis(np.radians([0, 5, 15, 25, 35, 45, 55, 65, 75, 90]), 12)
BASES = {"klems": (klems_basis("LBNL/Klems Full"), False), "even": (even_basis(6), False),
         "isotropic": (RINGS, True)}  # fmt: skip


@kept
@njit
def scatter_many(tables, side, kx, ky, seed, out):
    """Scatter one ray len(out) times: transmitted, kx, ky, survival a row."""
    rng = np.zeros(RNG_SIZE, np.uint64)
    for i in range(len(out)):
        start_path(rng, uint64(seed), uint64(11), uint64(i))
        passed, out[i, 1], out[i, 2], out[i, 3] = bsdf_scatter(tables, 0, side, kx, ky, rng)
        out[i, 0] = 1.0 if passed else 0.0


def rough_table(name, seed=5, loss=0.0):
    """Return a reciprocal table of random values, whose light is kept but for `loss`."""
    basis, isotropic = BASES[name]
    incidences = len(basis.azimuths) if isotropic else basis.count
    value = np.random.default_rng(seed).random((2, 2, incidences, basis.count)) ** 4
    table = BsdfTable("rough", basis, isotropic, value)
    even = value / table.energy.sum(axis=0)[None, :, :, None] * (1 - loss)
    return BsdfTable("rough", basis, isotropic, even).made_reciprocal()


@pytest.mark.parametrize("name", BASES)
def test_a_table_made_reciprocal_is_and_keeps_its_energy(name):
    table = rough_table(name, loss=0.25)
    assert table.reciprocity_error < 1e-12
    np.testing.assert_allclose(table.energy.sum(axis=0), 0.75, rtol=1e-9)


def bins(table, out, turned):
    """Return how many rays left into each bin, transmitted ones first; azimuths less `turned`."""
    c, s = np.cos(turned), np.sin(turned)
    kx, ky = out[:, 1] * c + out[:, 2] * s, out[:, 2] * c - out[:, 1] * s
    o = table.basis.bin_of(kx, ky) + np.where(out[:, 0] == 1, 0, table.basis.count)
    return np.bincount(o, minlength=2 * table.basis.count)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("name", BASES)
def test_the_histogram_is_the_table(name, side):
    table = rough_table(name, loss=0.1)
    count, azimuth = 200_000, 0.4
    kx, ky = np.sin(0.5) * np.cos(azimuth), np.sin(0.5) * np.sin(azimuth)
    out = np.empty((count, 4))
    scatter_many(build_bsdf([table], [0.0]), side, kx, ky, 3, out)
    i = table.basis.ring[table.basis.bin_of(kx, ky)] if table.isotropic else None
    i = table.basis.bin_of(kx, ky) if i is None else i
    chance = np.concatenate(table.chance[:, side, i])
    np.testing.assert_allclose(out[:, 3], chance.sum(), rtol=1e-12)
    expected = chance / chance.sum() * count
    number = bins(table, out, azimuth if table.isotropic else 0.0)
    chi2 = ((number - expected) ** 2 / np.maximum(expected, 1e-300))[expected > 0].sum()
    freedom = (expected > 0).sum() - 1
    within(chi2, freedom, np.sqrt(2 * freedom), 4, "chi squared")


@pytest.mark.parametrize("blend", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", BASES)
def test_lambertian_light_from_both_sides_leaves_lambertian(name, blend):
    # A table without loss is doubly stochastic in projected solid angle: even light stays even,
    # also between the bins' middles.
    scene = build_scene([BsdfSheet(rough_table(name), blend)])
    count = 100_000
    k = []
    for below in (True, False):
        out = np.empty((count, 4))
        pass_layers(scene, below, 61 + below, out)
        np.testing.assert_allclose(out[:, 3], 1.0, rtol=1e-9)
        k.append(out[out[:, 0] == 1, 1:3])
    k = np.concatenate(k)
    within(len(k), count, np.sqrt(count / 2), 4)
    number, _, _ = np.histogram2d(
        (k**2).sum(axis=1), np.arctan2(k[:, 1], k[:, 0]), (17, 13), ((0, 1), (-np.pi, np.pi))
    )
    chi2 = ((number - count / 221) ** 2 / (count / 221)).sum()
    within(chi2, 221, np.sqrt(442), 4)


@pytest.mark.parametrize("name", BASES)
def test_lambertian_in_lambertian_out_of_an_ideal_diffuser(name):
    basis, isotropic = BASES[name]
    incidences = len(basis.azimuths) if isotropic else basis.count
    value = np.full((2, 2, incidences, basis.count), 0.5 / np.pi)
    out = np.empty((100_000, 4))
    scatter_many(
        build_bsdf([BsdfTable("ideal", basis, isotropic, value)], [1.0]), 0, 0.7, 0.1, 8, out
    )
    for passed in (0, 1):
        k = out[out[:, 0] == passed, 1:3]
        within(len(k), 50_000, np.sqrt(25_000), 4)
        number, _, _ = np.histogram2d(
            (k**2).sum(axis=1), np.arctan2(k[:, 1], k[:, 0]), (10, 12), ((0, 1), (-np.pi, np.pi))
        )
        chi2 = ((number - len(k) / 120) ** 2 / (len(k) / 120)).sum()
        within(chi2, 119, np.sqrt(238), 4)


def test_white_furnace_with_tables():
    # Black lamps of luminance 1 under a sky of 1 and a reflector and sheet that lose nothing.
    lamps = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 1.0, 0.0, 0.0, 0.0, brdf=mirror_like(), blend=1.0)
    sheet = BsdfSheet(rough_table("klems"))
    scene = build_scene([lamps, Slab(1.49, 2.0), sheet, Sheet(0.3, 1.49, 1.0)], above=1.0)
    tally = trace(scene, Source(EYE, np.array([0.0, 9.0]), 1.0, acceptance=0.1), 4, seed=3)
    np.testing.assert_allclose(tally.radiance, 1.0, rtol=1e-9)
    np.testing.assert_allclose(tally.score2, tally.paths, rtol=1e-9)


def mirror_like(reflectance=1.0):
    """Return an isotropic BRDF that keeps light in its bin, from above only."""
    value = np.zeros((2, 2, 9, RINGS.count))
    for r in range(9):
        value[1, 1, r, RINGS.first[r]] = reflectance / RINGS.projected[RINGS.first[r]]
    return BsdfTable("mirror", RINGS, True, value)


def test_forward_equals_backward():
    # The same light by the adjoint: a reciprocal lossy table passes as much up as down.
    table = rough_table("klems", loss=0.2)
    passed = []
    for below in (True, False):
        out = np.empty((150_000, 4))
        pass_layers(build_scene([BsdfSheet(table)]), below, 71, out)
        passed.append((out[:, 3] * (out[:, 0] == (1 if below else -1))).mean())
    within(passed[0], passed[1], 0.5 * np.sqrt(2 / 150_000), 4)


def test_energy_balance_names_the_table():
    sheet = BsdfSheet(rough_table("isotropic", loss=0.2), name="measured sheet")
    scene = build_scene([CAVITY, Slab(1.49, 2.0), sheet])
    tally = trace(scene, Source(LAMPS, np.zeros(1), 0.0), 40, seed=5)
    share = dict(zip(FLOWS, tally.fraction, strict=False))
    rest = 1 - share["up"] - share["lamps"] - tally.fraction[len(FLOWS) :].sum()
    assert tally.fraction[-1] > 0.05
    assert abs(rest - share["roulette"]) < 1e-12
    within(share["roulette"], 0.0, tally.fraction_error[FLOWS.index("roulette")], 4)


@pytest.mark.parametrize("blend", [0.0, 1.0])
@pytest.mark.parametrize("name", BASES)
def test_paths_equal_the_oracle(name, blend):
    cavity = Cavity(
        20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3, brdf=mirror_like(0.9), blend=blend
    )
    compare([cavity, Slab(1.49, 2.0), BsdfSheet(rough_table(name, loss=0.1), blend)], 120)


def test_a_reflector_by_table_in_a_finite_panel_equals_the_oracle():
    panel = Panel(-40.0, 60.0, -50.0, 50.0, (-20.0, 9.0), (1.0, 0.4), 80.0, 0.9, 0.4)
    compare([replace(CAVITY, brdf=rough_brdf(), panel=panel), Slab(1.49, 2.0)], 60)


def rough_brdf():
    """Return a reciprocal BRDF of random values; nothing is transmitted."""
    value = rough_table("isotropic").value.copy()
    value[0] = 0.0
    return BsdfTable("rough white", RINGS, True, value)


def test_paths_with_film_and_tables_equal_the_oracle(tmp_path):
    film = Film(film_mesh(tmp_path, [BARE]), 1.55)
    compare(
        [CAVITY, BsdfSheet(rough_table("klems")), film, BsdfSheet(rough_table("isotropic"))], 60
    )


def compare(elements, count):
    engine = np.empty(count)
    source = Source(EYE, np.array([0.1]), 0.05, acceptance=0.5)
    flow = np.zeros(len(FLOWS) + len(elements))
    single_paths(build_scene(elements), source, 1, 0, engine, flow)
    oracle = ReferenceTracer(elements)
    expected = np.array(
        [oracle.radiance(0.1, 0.05, 0.5, Philox(1, EYE, p, 1)) for p in range(count)]
    )
    assert expected.any()
    np.testing.assert_allclose(engine, expected, rtol=1e-9, atol=1e-9 * expected.max())
