"""Polarised light in bands, and of boards of LEDs: oracle, plain traces, two ways of tracing."""

import numpy as np
import pytest
from band_path import band_of, compare
from harness import film_mesh, groove
from test_board import board

from mpfcad.errors import TraceError
from mpfcad.optics.element import Cavity, Converter, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.forward.connection import TERMS, CellMeter
from mpfcad.optics.forward.engine import BLOCK, trace_forward
from mpfcad.optics.scene import build_scene, build_scenes
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.spectral.engine import (
    build_spectral,
    trace_channels,
    trace_luminance,
    trace_stokes_channels,
)
from mpfcad.optics.stokes.engine import trace_stokes
from mpfcad.optics.stokes.plane import PlaneLayer

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
DBEF = PlaneLayer(0.4, (0.9, 0.04), (0.06, 0.93))
QUARTER = PlaneLayer(-0.7, retardation=np.pi / 2)
HALF = Sheet(0.3, 1.49, 0.98, depolarisation=0.4)
METER = Source(EYE, [0.1, 9.0], 1.0, acceptance=0.1)


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    return film_mesh(tmp_path_factory.mktemp("film"), [groove(60.0, chords=6)] * 2)


def stack(mesh, loss, index=1.55):
    plate = Slab(1.49, 2.0, 0.3, 0.01 * loss, 0.8)
    return [CAVITY, plate, HALF, Film(mesh, index, absorption=loss), DBEF]


@pytest.mark.parametrize("scattering", [None, 0.0, 4.0], ids=["sheet", "clear film", "film"])
def test_paths_through_converters_and_polarisers_equal_the_oracle(mesh, scattering):
    variants = []
    for loss, depth in ((0.3, 0.7), (0.1, 0.2), (0.2, 0.0)):
        dots = Converter(depth, 1.5, 0.95)
        if scattering is not None:
            dots = Converter(depth, 1.6, 0.95, "dots", 0.2, scattering, 0.4)
        cavity, plate, sheet, film, dbef = stack(mesh, loss)
        variants.append([cavity, plate, QUARTER, dots, sheet, film, dbef])
    band = band_of(3, [[0.0, 0.8, 0.2]], (0.95,), [1.0, 0.2, 0.1])
    expected = compare(variants, band, 40, polarised=True)
    # Of light that was converted, too, meters see Q and U.
    assert (np.abs(expected[:, 1:3, [0, 1, 4, 5]]).max(axis=0) > 0).all()


def test_one_band_is_polarised_light_of_one_wavelength(mesh):
    elements = stack(mesh, 0.2)
    spectral = build_spectral(build_scenes([elements], polarised=True), band_of(1), joint=True)
    plain = trace_stokes(build_scene(elements, polarised=True), METER, 2, seed=3)
    found = trace_stokes_channels(spectral, METER, 2, seed=3)
    np.testing.assert_allclose(found[..., 0], plain, rtol=1e-12, atol=1e-9)
    whole = trace(build_scene(elements, polarised=True), METER, 2, seed=3)
    np.testing.assert_allclose(
        trace_luminance(spectral, METER, 2, seed=3).radiance, whole.radiance, rtol=1e-12
    )


def test_the_same_bits_at_any_number_of_threads_and_the_same_means(mesh):
    variants = [stack(mesh, loss) for loss in (0.1, 0.4, 0.2)]
    spectral = build_spectral(build_scenes(variants, polarised=True), band_of(3), joint=True)
    one, two = (trace_stokes_channels(spectral, METER, 3, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one, two)
    # A single row is followed for luminances: other paths by last bits alone.
    np.testing.assert_allclose(trace_channels(spectral, METER, 3), one[:, :, 0], rtol=1e-9)


def test_bands_traced_apart_are_polarised_light_of_each(mesh):
    variants = [stack(mesh, 0.2, index) for index in (1.57, 1.55, 1.54)]
    scenes = build_scenes(variants, polarised=True)
    found = trace_stokes_channels(build_spectral(scenes, band_of(3), joint=False), METER, 2)
    for band, elements in enumerate(variants):
        plain = trace_stokes(build_scene(elements, polarised=True), METER, 2)
        np.testing.assert_allclose(found[..., band], plain, rtol=1e-12, atol=1e-9)


def test_white_furnace_of_every_band(mesh):
    elements = [Slab(1.5, 2.0, 0.5, 0.0, 0.8), QUARTER, Film(mesh, 1.55),
                Converter(0.0, 1.6, 1.0, "dots", 0.2, 2.0)]  # fmt: skip
    scenes = build_scenes([elements] * 3, below=1.0, above=1.0, polarised=True)
    spectral = build_spectral(scenes, band_of(3, [[0, 0.5, 0.5]], (1.0,)), joint=True)
    found = trace_stokes_channels(spectral, METER, 16)[:, 0, :, :3]
    np.testing.assert_allclose(found[:, 0], 1.0, rtol=1e-9)
    error = found[:, 1:].std(axis=0, ddof=1) / 4
    assert (np.abs(found[:, 1:].mean(axis=0)) < 4 * error + 1e-12).all()


def test_stokes_vectors_need_polarised_light(mesh):
    variants = build_scenes([[Slab(1.5, 2.0)]] * 3, below=1.0)
    with pytest.raises(TraceError, match="expected polarised light"):
        trace_stokes_channels(build_spectral(variants, band_of(3), joint=True), METER, 1)


LEDS = board(height=8.0, pitch=12.0, size=3.0)
WHOLE = Source(EYE, [0.0], 12.0, acceptance=0.05, along=[0.0], spot_along=12.0)


def forward_mean(scene, blocks, spectral=None):
    """Return the mean luminance of a cell, from the LEDs, and its standard error."""
    tally = trace_forward(scene, CellMeter(0.05, 12.0, 12.0, 4), blocks, spectral=spectral)
    scale = LEDS.flux / 144.0 * 1e6 / BLOCK
    mean = tally.score[0] / blocks
    square = (tally.outer[0, 0] / blocks - mean**2) / (blocks - 1)
    assert len(tally.score) == TERMS**2 + 16
    return scale * mean, scale * np.sqrt(square)


def leds(mesh, loss, *more):
    return [LEDS, Slab(1.49, 2.0, 0.3, 0.01 * loss, 0.8), *more,
            Film(mesh, 1.55, absorption=loss, rotation=0.3), DBEF, HALF]  # fmt: skip


@pytest.mark.slow
def test_polarised_light_of_leds_is_the_same_traced_from_the_meter(mesh):
    scene = build_scene(leds(mesh, 0.2, DBEF), polarised=True)
    found, error = forward_mean(scene, 8)
    back = trace(scene, WHOLE, 200)
    sigma = np.hypot(error, back.radiance_error[0])
    assert abs(found - back.radiance[0]) < 3.5 * sigma, (found, back.radiance, sigma)
    # The test sees polarisation: without it the reflective polarisers pass other shares.
    plain = [one for one in leds(mesh, 0.2) if one is not DBEF]
    assert abs(forward_mean(build_scene(plain), 4)[0] / found - 1) > 0.05
    assert sigma < 0.02 * found


@pytest.mark.slow
@pytest.mark.parametrize("polarised", [False, True], ids=["plain", "polarised"])
def test_leds_under_a_film_of_dots_are_the_same_both_ways(mesh, polarised):
    variants = []
    for loss, depth in ((0.3, 0.7), (0.1, 0.2), (0.2, 0.0)):
        made = leds(mesh, loss, Converter(depth, 1.6, 0.95, "dots", 0.2, 3.0, 0.4))
        variants.append([one for one in made if polarised or one is not DBEF])
    scenes = build_scenes(variants, polarised=polarised)
    band = band_of(3, [[0.0, 0.8, 0.2]], (0.95,), [1.0, 0.2, 0.1])
    spectral = build_spectral(scenes, band, joint=True)
    found, error = forward_mean(scenes[0], 8, spectral)
    back = trace_luminance(spectral, WHOLE, 200)
    sigma = np.hypot(error, back.radiance_error[0])
    assert abs(found - back.radiance[0]) < 3.5 * sigma, (found, back.radiance, sigma)
    assert sigma < 0.03 * found
