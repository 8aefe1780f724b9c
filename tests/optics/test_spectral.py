"""Light in bands against the plain tracer, closed forms and the oracle."""

import numpy as np
import pytest
from band_path import WAVELENGTH, band_of, compare
from harness import BARE, film_mesh, groove
from numpy.polynomial.legendre import leggauss

from mpfcad.errors import TraceError
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.element import Cavity, Converter, Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.scene import build_scene, build_scenes
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source
from mpfcad.optics.spectral.converter import conversion
from mpfcad.optics.spectral.engine import build_spectral, trace_channels, trace_luminance

NONE = np.zeros((0, 3)), np.zeros(0)
#: Reflectance, absorption [1/mm], transmission at each band.
MATERIALS = [(0.90, 0.010, 0.97), (0.96, 0.002, 0.98), (0.94, 0.004, 0.90)]
POSITION = np.linspace(0, 32.69, 5)


def stack(mesh, reflectance, absorption, transmission, index=1.55):
    return [
        Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75 * reflectance, reflectance, 0.3),
        Slab(1.49, 2.0, 0.6, absorption, 0.8),
        Sheet(0.3, 1.49, transmission),
        Film(mesh, index, absorption=50 * absorption, offset=0.013),
    ]


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    return film_mesh(tmp_path_factory.mktemp("film"), [groove(60.0, chords=6), BARE])


@pytest.mark.parametrize("material", MATERIALS)
def test_one_band_has_the_bits_of_the_plain_trace(mesh, material):
    elements, source = stack(mesh, *material), Source(EYE, POSITION, 1.0)
    spectral = build_spectral(build_scenes([elements]), band_of(1), joint=True)
    plain, found = trace(build_scene(elements), source, 2), trace_luminance(spectral, source, 2)
    for name in ("score", "score2", "block2", "flow"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(found, name))


def test_each_band_is_the_plain_trace_at_its_wavelength(mesh):
    variants, source = [stack(mesh, *one) for one in MATERIALS], Source(EYE, POSITION, 1.0)
    spectral = build_spectral(build_scenes(variants), band_of(3), joint=True)
    blocks = 24
    found = trace_channels(spectral, source, blocks, seed=3)
    mean, error = found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(blocks)
    for i, elements in enumerate(variants):
        plain = trace(build_scene(elements), source, blocks, seed=4)
        sigma = (mean[:, i] - plain.radiance) / np.hypot(error[:, i], plain.own_error)
        # Five points and three bands: 4.5 σ of Student's t of some 23 degrees is 1 in 5000.
        assert np.abs(sigma).max() < 4.5, (i, sigma)
        # The tally of luminances is that of the channels.
    tally = trace_luminance(spectral, source, blocks, seed=3)
    np.testing.assert_allclose(tally.radiance, mean.mean(axis=1), rtol=1e-12)


def test_bands_traced_apart_are_the_plain_traces(mesh):
    variants = [stack(mesh, *MATERIALS[1], index=n) for n in (1.57, 1.55, 1.54)]
    source, scenes = Source(EYE, POSITION, 1.0), build_scenes(variants)
    with pytest.raises(TraceError, match="differ by absorption or reflectance alone"):
        build_spectral(scenes, band_of(3), joint=True)
    found = trace_channels(build_spectral(scenes, band_of(3), joint=False), source, 2)
    for i, elements in enumerate(variants):
        plain = trace(build_scene(elements), source, 2)
        np.testing.assert_allclose(found.mean(axis=0)[:, i], plain.radiance, rtol=1e-12)


def test_same_bits_at_any_number_of_threads(mesh):
    variants = [stack(mesh, *one) for one in MATERIALS]
    spectral = build_spectral(build_scenes(variants), band_of(3), joint=True)
    source = Source(EYE, POSITION, 1.0)
    one, two = (trace_channels(spectral, source, 5, threads=threads) for threads in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_white_furnace_and_energy_of_each_band(mesh):
    # Lossless: all bands see the surroundings. With losses: what does not come out was absorbed.
    lossless = [[Slab(1.5, 2.0, 0.5, 0.0, 0.8), Sheet(0.3, 1.49, 1.0), Film(mesh, 1.55)]] * 3
    source = Source(LAMBERTIAN_BELOW, np.zeros(1), 0.03)
    scenes = build_scenes(lossless, below=1.0, above=1.0)
    found = trace_channels(build_spectral(scenes, band_of(3), joint=True), source, 4)
    np.testing.assert_allclose(found, 1.0, rtol=1e-12)
    lossy = [[Slab(1.5, 2.0, 0.5, a, 0.8), Sheet(0.3, 1.49, t), Film(mesh, 1.55, absorption=9 * a)]
             for a, t in ((0.05, 0.9), (0.0, 1.0), (0.2, 0.95))]  # fmt: skip
    scenes = build_scenes(lossy, below=1.0, above=1.0)
    found = trace_channels(build_spectral(scenes, band_of(3), joint=True), source, 16)[:, 0]
    mean, error = found.mean(axis=0), found.std(axis=0, ddof=1) / 4
    for i, elements in enumerate(lossy):
        plain = trace(build_scene(elements), source, 16, seed=2)
        absorbed = plain.fraction[len(FLOWS) :].sum()
        sigma = np.sqrt((plain.fraction_error[len(FLOWS) :] ** 2).sum())
        assert abs(mean[i] + absorbed - 1) < 4 * np.hypot(error[i], sigma) + 1e-12, i


def test_a_stack_passes_each_band_both_ways_alike(mesh):
    # Of Lambertian light: what an upward meter of Lambertian acceptance sees is what goes down.
    lossy = [[Slab(1.5, 1.0, 0.5, a, 0.8), Film(mesh, 1.55, absorption=9 * a), Sheet(0.3, 1.49, t)]
             for a, t in ((0.05, 0.9), (0.0, 1.0), (0.2, 0.95))]  # fmt: skip
    down = build_scenes(lossy, below=1.0)
    up = build_scenes(lossy, above=1.0)
    seen = [
        trace_channels(build_spectral(scenes, band_of(3), joint=True), source, 24)[:, 0]
        for scenes, source in (
            (down, Source(EYE, [0.05], 0.1, acceptance=1.0)),
            (up, Source(LAMBERTIAN_BELOW, [0.05], 0.1)),
        )
    ]
    mean = [one.mean(axis=0) for one in seen]
    error = np.hypot(*(one.std(axis=0, ddof=1) / np.sqrt(24) for one in seen))
    assert (np.abs(mean[0] - mean[1]) < 3.5 * error).all()


def absorbed(depth, index=1.5):
    """Return cosines, their weights in Lambertian light, and what is taken at them, (b, n)."""
    node, weight = leggauss(300)
    cosine = (node + 1) / 2
    slant = 1 / np.sqrt(1 - (1 - cosine**2) / index**2)
    return cosine * weight, 1 - np.exp(-np.asarray(depth)[:, None] * slant)


def test_two_converters_between_equal_skies_have_their_geometric_series():
    wavelength, source = np.array([450.0, 530.0, 560.0, 620.0]), np.array([1.0, 0.3, 0.2, 0.1])
    depth = np.array([[0.6, 0.1, 0.02, 0.0], [0.3, 0.25, 0.2, 0.05]])
    photons, quantum_yield = np.array([[0, 0.6, 0.3, 0.1], [0, 0, 0.2, 0.8]]), (1.0, 0.9)
    pairs = [conversion(y, wavelength, q) for y, q in zip(quantum_yield, photons, strict=True)]
    matrix = [np.outer(emitted, taken) for taken, emitted in pairs]
    weight, first = absorbed(depth[0])
    _, second = absorbed(depth[1])
    takes = [first @ weight, second @ weight]
    lit = [(first * (2 - second)) @ weight * source, (second * (2 - first)) @ weight * source]
    # Each takes what the skies send, through the other, and half of what the other emits.
    coupled = np.block(
        [
            [np.eye(4), -matrix[0] * takes[0] / 2],
            [-matrix[1] * takes[1] / 2, np.eye(4)],
        ]
    )
    emitted = np.linalg.solve(
        coupled, np.concatenate([m @ p for m, p in zip(matrix, lit, strict=True)])
    )
    passed = np.exp(-depth)
    expected = np.array([passed.prod(axis=0), passed[1] * emitted[:4] / 2, emitted[4:] / 2])
    variants = [[Converter(depth[i, b], 1.5, quantum_yield[i]) for i in range(2)] for b in range(4)]
    scenes = build_scenes(variants, below=1.0, above=1.0)
    band = band_of(4, photons, quantum_yield, source, wavelength)
    found = trace_channels(
        build_spectral(scenes, band, joint=True), Source(EYE, [0.0], 0.0), 100
    )[:, 0]  # fmt: skip
    mean, error = found.mean(axis=0).reshape(3, 4), found.std(axis=0, ddof=1).reshape(3, 4) / 10
    np.testing.assert_allclose(mean[0], expected[0], rtol=1e-12)
    assert (np.abs(mean[1:] - expected[1:]) <= 3.5 * error[1:] + 1e-12).all()
    assert expected[1:].max() > 0.1


def test_a_yield_of_one_conserves_photons(mesh):
    # A diffusing stack with a converter among equal skies: as many photons leave as come.
    source = np.array([1.0, 0.4, 0.2])
    depth = (0.8, 0.3, 0.02)
    variants = [
        [
            Sheet(0.3, 1.49, 1.0),
            Converter(d, 1.4, 1.0),
            Slab(1.5, 1.0, 1.0, 0.0, 0.5),
            Film(mesh, 1.5),
        ]
        for d in depth
    ]
    band = band_of(3, [[0.0, 0.5, 0.5]], (1.0,), source)
    leaves = np.zeros(3)
    square = np.zeros(3)
    for flipped in (False, True):
        ways = [list(reversed(one)) if flipped else one for one in variants]
        if flipped:
            ways = [[Film(mesh, 1.5, flipped=True), *one[1:]] for one in ways]
        scenes = build_scenes(ways, below=1.0, above=1.0)
        found = trace_channels(
            build_spectral(scenes, band, joint=True),
            Source(EYE, [0.05], 0.1, acceptance=1.0), 64, seed=5,
        )[:, 0]  # fmt: skip
        power = found[:, :3] * source + found[:, 3:]
        leaves += power.mean(axis=0)
        square += power.std(axis=0, ddof=1) ** 2 / 64
    photons, come = leaves @ WAVELENGTH, 2 * source @ WAVELENGTH
    assert abs(photons - come) < 3 * np.sqrt(square @ WAVELENGTH**2), (photons, come)
    assert leaves[2] > 1.2 * 2 * source[2]


def test_paths_of_a_film_in_bands_equal_the_oracle(mesh):
    compare([stack(mesh, *one) for one in MATERIALS], band_of(3), 40)


def test_paths_through_two_materials_equal_the_oracle(mesh, tmp_path):
    prism = film_mesh(tmp_path, [BARE] * 2)
    variants = [
        [Film(mesh, 1.55, absorption=a, resin=Resin(prism, 0.0, 0.0, None, 1.5, 2 * a))]
        for a in (1.0, 0.5, 3.0)
    ]
    compare(variants, band_of(3), 40, below=1.0)


def test_paths_through_converters_equal_the_oracle(mesh):
    variants = []
    for (one, two), material in zip(((0.7, 0.3), (0.1, 0.3), (0.0, 0.05)), MATERIALS, strict=True):
        cavity, plate, sheet, film = stack(mesh, *material)
        green, red = Converter(one, 1.5, 0.95, "green"), Converter(two, 1.4, 0.9, "red")
        variants.append([cavity, plate, green, red, sheet, film])
    band = band_of(3, [[0.0, 0.8, 0.2], [0.0, 0.05, 0.95]], (0.95, 0.9), [1.0, 0.2, 0.1])
    expected = compare(variants, band, 40)
    assert (expected[:, 0, [4, 5, 8]].max(axis=0) > 0).all()


def test_light_is_converted_on_paths_from_a_meter_alone():
    band = band_of(3, [[0.0, 0.5, 0.5]], (1.0,))
    spectral = build_spectral(build_scenes([[Converter(0.5)]] * 3), band, joint=True)
    with pytest.raises(TraceError, match="from a meter alone"):
        trace_channels(spectral, Source(LAMBERTIAN_BELOW, [0.0], 0.0), 1)
