"""Films of phosphor or dots with an index of their own: oracle, closed forms, photons."""

import numpy as np
import pytest
from band_path import WAVELENGTH, band_of, compare
from harness import film_mesh, groove
from numpy.polynomial.legendre import leggauss

from mpfcad.optics.element import Cavity, Converter, Film, Sheet, Slab
from mpfcad.optics.scene import build_scenes
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source
from mpfcad.optics.spectral.converter import conversion
from mpfcad.optics.spectral.engine import build_spectral, trace_channels

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
#: A meter that takes light of all directions alike: the mean radiance of what leaves.
ALL = Source(EYE, [0.05], 0.1, acceptance=1.0)


def dots(depth, quantum_yield=0.9, index=1.5, scattering=0.0, asymmetry=0.4, name="dots"):
    return Converter(depth, index, quantum_yield, name, 0.2, scattering, asymmetry)


def mean_of(variants, band, blocks, source=ALL, below=1.0, above=1.0, seed=1):
    """Return the mean and standard error of each channel."""
    spectral = build_spectral(build_scenes(variants, below=below, above=above), band, joint=True)
    found = trace_channels(spectral, source, blocks, seed=seed)[:, 0]
    return found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(blocks)


@pytest.mark.parametrize("scattering", [0.0, 4.0])
def test_paths_equal_the_oracle(tmp_path, scattering):
    film = Film(film_mesh(tmp_path, [groove(60.0, chords=6)]), 1.55, offset=0.013)
    variants = []
    for one, two in ((0.7, 0.3), (0.1, 0.3), (0.0, 0.05)):
        green, red = dots(one, 0.95, 1.6, scattering, name="green"), dots(two, 0.9, name="red")
        variants.append([CAVITY, green, Slab(1.49, 2.0), red, Sheet(0.3, 1.49, 0.98), film])
    band = band_of(3, [[0.0, 0.8, 0.2], [0.0, 0.05, 0.95]], (0.95, 0.9), [1.0, 0.2, 0.1])
    expected = compare(variants, band, 40)
    assert (expected[:, 0, [4, 5, 8]].max(axis=0) > 0).all()


def face(cosine, index):
    """Return the reflectance within a film of unpolarised light at its face."""
    sine = index * np.sqrt(1 - cosine**2)
    beyond = sine >= 1
    out = np.sqrt(1 - np.where(beyond, 0.0, sine) ** 2)
    s = (index * cosine - out) / (index * cosine + out)
    p = (cosine - index * out) / (cosine + index * out)
    return np.where(beyond, 1.0, (s * s + p * p) / 2)


def test_what_no_band_takes_again_leaves_within_the_escape_cones():
    # Equal skies of band 0 alone. Of what is emitted 1 - cos θc leaves, half of it on each side.
    index, depth = 1.6, 0.5
    node, weight = leggauss(400)
    cosine = (node + 1) / 2  # outside
    inside = np.sqrt(1 - (1 - cosine**2) / index**2)
    reflected, passed = face(inside, index), np.exp(-depth / inside)
    taken = ((1 - reflected) * (1 - passed) / (1 - reflected * passed)) @ (cosine * weight)
    cone = 1 - np.sqrt(1 - 1 / index**2)
    took, gives = conversion(0.9, WAVELENGTH, np.array([0.0, 0.7, 0.3]))
    expected = gives * took[0] * taken * cone
    variants = [[dots(d, 0.9, index)] for d in (depth, 0.0, 0.0)]
    band = band_of(3, [[0.0, 0.7, 0.3]], (0.9,), [1.0, 0.0, 0.0])
    mean, error = mean_of(variants, band, 200)
    assert (np.abs(mean[4:] - expected[1:]) < 3.5 * error[4:]).all(), (mean[4:], expected[1:])
    # What a meter looks at by itself: the share that passes, in closed form.
    normal = np.exp(-depth)
    r = ((index - 1) / (index + 1)) ** 2
    straight = (1 - r) ** 2 * normal / (1 - (r * normal) ** 2)
    alone, away = mean_of(variants, band, 50, Source(EYE, [0.05], 0.1), above=0.0)
    assert abs(alone[0] - straight) < 3.5 * away[0]
    assert (error[4:] < 0.01 * expected[1:]).all()


def layers(depth, index, source, sky, count=300, angles=48):
    """Return J(z) and what leaves a face, of a slab with isotropic source(z) between equal skies.

    Discrete ordinates: for each cosine the two streams are integrated over the layers, with the
    faces' reflectance, and summed as a geometric series.
    """
    node, weight = leggauss(angles)
    cone = np.sqrt(1 - 1 / index**2)
    # Both sides of the critical angle by themselves.
    mu = np.concatenate([(node + 1) / 2 * cone, cone + (node + 1) / 2 * (1 - cone)])
    w = np.concatenate([weight * cone, weight * (1 - cone)]) / 2
    step = 1.0 / count
    j, leaves = np.zeros(count), 0.0
    for m, share in zip(mu, w, strict=True):
        reflected, t = face(np.array([m]), index)[0], np.exp(-depth * step / m)
        gain = source * (1 - t) / depth if depth > 0 else source * step / m
        up = np.zeros(count + 1)
        for i in range(count):
            up[i + 1] = up[i] * t + gain[i]
        come, whole = (1 - reflected) * sky * index**2, t**count
        # Symmetric about the middle: what starts at a face is what comes to it.
        first = (come + reflected * up[-1]) / (1 - reflected * whole)
        stream = up + first * t ** np.arange(count + 1)
        middle = (stream[1:] + stream[:-1]) / 2
        j += share * (middle + middle[::-1]) / 2
        leaves += share * 2 * m * (1 - reflected) * stream[-1]
    return j, leaves


def test_light_taken_again_is_that_of_discrete_ordinates():
    index, quantum_yield = 1.5, 0.9
    depth = np.array([0.6, 0.25])
    wavelength, photons = np.array([450.0, 540.0]), np.array([0.0, 1.0])
    took, gives = conversion(quantum_yield, wavelength, photons)
    lit, _ = layers(depth[0], index, np.zeros(300), 1.0)
    source = gives[1] * took[0] * depth[0] * lit
    total = source
    for _ in range(60):
        j, leaves = layers(depth[1], index, total, 0.0)
        total = source + gives[1] * took[1] * depth[1] * j
    band = band_of(2, [photons], (quantum_yield,), [1.0, 0.0], wavelength)
    variants = [[dots(d, quantum_yield, index)] for d in depth]
    mean, error = mean_of(variants, band, 200)
    # The ordinates' own error is below 0.2 % (by halving both grids).
    assert abs(mean[3] - leaves) < 3.5 * error[3] + 0.002 * leaves, (mean[3], leaves, error[3])
    assert error[3] < 0.01 * leaves


def test_a_scattering_film_of_yield_one_loses_no_photon(tmp_path):
    source = np.array([1.0, 0.4, 0.2])
    mesh = film_mesh(tmp_path, [groove(60.0, chords=6)])
    variants = [
        [Sheet(0.3, 1.49, 1.0), dots(d, 1.0, 1.6, 8.0), Film(mesh, 1.5)] for d in (0.8, 0.3, 0.0)
    ]
    band = band_of(3, [[0.0, 0.5, 0.5]], (1.0,), source)
    leaves, square = np.zeros(3), np.zeros(3)
    for ways in (variants, [[Film(mesh, 1.5, flipped=True), *one[1::-1]] for one in variants]):
        mean, error = mean_of(ways, band, 64, seed=5)
        leaves += mean[:3] * source + mean[3:]
        square += error[:3] ** 2 * source**2 + error[3:] ** 2
    photons, come = leaves @ WAVELENGTH, 2 * source @ WAVELENGTH
    assert abs(photons - come) < 3.5 * np.sqrt(square @ WAVELENGTH**2), (photons, come)
    # The test sees photons that stay: a film that is smooth and clear keeps some.
    clear = [[one[0], dots(one[1].depth, 1.0, 1.6), one[2]] for one in variants]
    mean, _ = mean_of(clear, band, 64, seed=5)
    assert (mean[:3] * source + mean[3:]) @ WAVELENGTH < 0.48 * come


def test_a_film_that_takes_nothing_is_a_white_furnace():
    lossless = [[dots(0.0, index=1.6, scattering=3.0), dots(0.0)]] * 3
    mean, _ = mean_of(lossless, band_of(3, [[0.0, 0.5, 0.5]] * 2, (1.0, 1.0)), 4)
    np.testing.assert_allclose(mean[:3], 1.0, rtol=1e-12)
    assert not mean[3:].any()


def test_a_film_passes_each_band_both_ways_alike():
    lossy = [[dots(d, 0.0, 1.6, 3.0), Sheet(0.3, 1.49, 0.9)] for d in (0.8, 0.3, 0.1)]
    band = band_of(3, [[0.0, 0.5, 0.5]], (0.0,))
    down, error = mean_of(lossy, band, 100, above=0.0)
    flipped = [list(reversed(one)) for one in lossy]
    up, other = mean_of(flipped, band, 100, above=0.0)
    assert (error[:3] < 0.005 * down[:3]).all()
    assert (np.abs(down - up)[:3] < 3.5 * np.hypot(error, other)[:3]).all()


def test_a_plain_trace_takes_what_a_film_takes():
    from mpfcad.optics.base.recorder import FLOWS
    from mpfcad.optics.engine import trace
    from mpfcad.optics.scene import build_scene

    scene = build_scene([dots(0.4, scattering=2.0)], below=1.0, above=1.0)
    tally = trace(scene, Source(LAMBERTIAN_BELOW, np.zeros(1), 0.0), 8)
    away = tally.radiance[0] + tally.fraction[len(FLOWS)] - 1
    assert abs(away) < 4 * np.hypot(tally.radiance_error[0], tally.fraction_error[len(FLOWS)])
    assert tally.fraction[len(FLOWS)] > 0.3
