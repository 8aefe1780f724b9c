"""Single paths in bands, of the engine and of the oracle, for tests to compare."""

import numpy as np
from oracle.bands import BandTracer
from oracle.polarised import PolarisedPhilox
from oracle.ray import Philox

from mpfcad.optics.scene import build_scenes
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.spectral.engine import Band, build_spectral, trace_bands
from mpfcad.optics.spectral.hue import Hue
from mpfcad.optics.stokes.bands import trace_polarised_bands
from mpfcad.optics.stokes.state import LIGHT_SHAPE, ROWS
from mpfcad.optics.wave import SLOTS, Wave

WAVELENGTH = np.array([450.0, 540.0, 630.0])


def band_of(count, photons=None, quantum_yield=(), source=None, wavelength=WAVELENGTH):
    """Return bands whose channels have a luminance of 1 over their number each."""
    photons = np.zeros((0, count)) if photons is None else np.array(photons)
    channels = count * (1 + len(photons))
    source = np.ones(count) if source is None else np.array(source)
    colour = np.ones((channels, 3)) / count
    return Band(source, colour, wavelength[:count], photons, np.array(quantum_yield))


def compare(variants, band, count, below=0.0, polarised=False, strays=2):
    """Compare paths channel by channel; return the oracle's, (paths, 1 or 4, channels)."""
    scenes = build_scenes(variants, below=below, polarised=polarised)
    spectral = build_spectral(scenes, band, joint=True)
    source = Source(EYE, [0.1], 0.05, acceptance=0.5, along=0.3, spot_along=0.01)
    oracle = BandTracer(variants, band.source, band.wavelength, band.photons, below=below)
    number = PolarisedPhilox if polarised else Philox
    expected = np.array([
        oracle.channels(0.1, 0.05, 0.5, number(1, EYE, path, 1), y=0.3, spot_along=0.01)
        for path in range(count)
    ])  # fmt: skip
    one = _polarised if polarised else _plain
    found = np.array([one(spectral, source, np.uint64(path)) for path in range(count)])
    away = np.abs(found - expected).max(axis=(1, 2)) / expected.max()
    assert np.mean(away > 1e-9) <= strays / count, np.flatnonzero(away > 1e-9)
    assert (expected[:, 0, : len(band.source)].max(axis=0) > 0).all()
    return expected


def _plain(spectral, source, path):
    hue, flow = Hue.empty(spectral.tables, SLOTS, 1), np.zeros(spectral.flows)
    wave = Wave.empty(len(spectral.scenes[0].kind))
    start = np.uint64(1), np.uint64(EYE), path
    trace_bands(spectral.scenes[0], source, hue, *start, wave, np.empty(1), flow)
    return hue.score.copy()


def _polarised(spectral, source, path):
    hue, flow = Hue.empty(spectral.tables, 1, 1), np.zeros(spectral.flows)
    wave, light = Wave.empty(len(spectral.scenes[0].kind)), np.zeros(LIGHT_SHAPE)
    stokes = np.zeros((1, ROWS, hue.score.shape[1]))
    start = np.uint64(1), np.uint64(EYE), path
    scene = spectral.scenes[0]
    trace_polarised_bands(scene, source, hue, *start, wave, light, stokes, np.empty(1), flow)
    return stokes[0]
