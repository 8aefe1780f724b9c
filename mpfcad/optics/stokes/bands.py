"""Paths of polarised light in bands: one path for all bands, with the state of each meter.

A state changes alike at all bands that share a path, for these differ by what they lose alone.
"""

import numpy as np
from numba import uint64
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import entry, kernel
from mpfcad.optics.base.net import NET
from mpfcad.optics.base.sampling import start_net_path
from mpfcad.optics.cavity.endless import NO_LAMP
from mpfcad.optics.passage import ENDED, next_element, pass_element
from mpfcad.optics.scene import Scene
from mpfcad.optics.source import Source, start_ray
from mpfcad.optics.spectral.again import restart
from mpfcad.optics.spectral.hue import Hue, Tables, begin_hue
from mpfcad.optics.stokes.engine import trace_block
from mpfcad.optics.stokes.state import LIGHT_SHAPE, start_light
from mpfcad.optics.wave import Wave

#: The slot of the one path that is followed.
ONLY = np.uint64(0)


@kernel
def put(wave, up, x, y, z, dx, dy, dz, lamp):
    """Put a ray of weight 1 into the only slot."""
    place = wave.place[ONLY]
    place[0], place[1], place[2], place[3], place[4], place[5] = x, y, z, dx, dy, dz
    wave.weight[ONLY], wave.lamp[ONLY] = 1.0, lamp
    wave.upward[ONLY] = 1 if up else 0


@kernel
def pass_on(scene, e, wave, flow, light, hue):
    """Pass the only ray through element e: (what it meets next or `ENDED`, luminance found)."""
    p = wave.place[ONLY]
    way, p[0], p[1], p[3], p[4], p[5], wave.weight[ONLY], found = pass_element(
        scene, e, wave.upward[ONLY] != 0, p[0], p[1], p[2], p[3], p[4], p[5], wave.lamp[ONLY],
        wave.weight[ONLY], flow, light, None, hue, wave.rng[ONLY],
    )  # fmt: skip
    wave.way[ONLY], wave.lamp[ONLY] = way, NO_LAMP
    wave.passed[0] += 1
    e, seen = _leave(scene, e, wave, flow, hue)
    return e, found + seen


@kernel
def _leave(scene, e, wave, flow, hue):
    way, p = wave.way[ONLY], wave.place[ONLY]
    e, wave.weight[ONLY], seen = next_element(
        scene, e, way, p[0], p[1], wave.weight[ONLY], flow, hue, wave.rng[ONLY]
    )
    wave.upward[ONLY] = 1 if way > 0 else 0
    return e, seen


@kernel
def resume(scene, wave, flow, light, hue):
    """Start the path again in the converter drawn for it: (whether, what it meets, found)."""
    begun, e, seen = False, ENDED, 0.0
    if hue is not None:
        begun = restart(scene, hue, light, ONLY, wave, flow)
        if begun:
            e, seen = _leave(scene, hue.element[ONLY], wave, flow, hue)
    return begun, e, seen


@kernel
def _collect(hue, light, stokes):
    """Move what was found into stokes (rows, channels), as each meter sees it."""
    for channel in range(stokes.shape[1]):
        part = hue.score[0, channel]
        if part != 0.0:
            hue.score[0, channel] = 0.0
            for row in range(stokes.shape[0]):
                stokes[row, channel] += light[row, 0] * part


@entry
def trace_polarised_bands(scene, source, hue, seed, stream, first, wave, light, stokes, radiance,
                          flow):  # fmt: skip
    """Follow paths `first` and on; put the luminance that each collects into radiance (n,).

    stokes (p, 4, channels) or (p, 1, channels) gets the sums over the paths of each point of I, Q,
    U and V. Of `hue` one slot and one point are scratch, as are `wave` and light (5, 4). flow (f,)
    gets the sums of where the weights went.
    """
    points, rows = uint64(len(source.position)), stokes.shape[1]
    hue.at[0], hue.at[1] = 0, 0
    for i in range(len(radiance)):
        path = first + uint64(i)
        point = path % points
        start_net_path(wave.rng[ONLY], seed, stream, path, points)
        e, up, x, y, z, dx, dy, dz, lamp = start_ray(scene, source, point, wave.rng[ONLY])
        put(wave, up, x, y, z, dx, dy, dz, lamp)
        begin_hue(hue, ONLY)
        start_light(light, rows, dx, dy, dz)
        radiance[i] = 0.0
        begun = True
        while begun:
            while e != ENDED:
                e, found = pass_on(scene, e, wave, flow, light, hue)
                radiance[i] += found
                _collect(hue, light, stokes[point])
            begun, e, found = resume(scene, wave, flow, light, hue)
            radiance[i] += found
            _collect(hue, light, stokes[point])


class PolarisedWork:
    """Scratch of a block: luminances (n, p), and the state of the path under way."""

    def __init__(
        self, scenes: tuple[Scene, ...], colour: NDArray[np.float64], tables: Tables | None,
        points: int, rows: int,
    ) -> None:  # fmt: skip
        self.scenes, self.colour = scenes, colour
        self.radiance = np.empty((NET, points))
        self.stokes = np.zeros((points, rows, len(colour)))
        self.hue = None if tables is None else Hue.empty(tables, 1, 1)
        self.wave, self.light = Wave.empty(len(scenes[0].kind)), np.zeros(LIGHT_SHAPE)

    def trace(
        self, source: Source, block: int, seed: int, flow: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Trace a block: luminances into `radiance`; return the channels' sums (p, rows, c)."""
        self.stokes[:] = 0.0
        if self.hue is not None:
            trace_polarised_bands(
                self.scenes[0], source, self.hue, np.uint64(seed), np.uint64(source.kind),
                np.uint64(block * self.radiance.size), self.wave, self.light, self.stokes,
                self.radiance.reshape(-1), flow,
            )  # fmt: skip
            return self.stokes
        self.radiance[:] = 0.0
        found = np.empty((*self.radiance.shape, self.stokes.shape[1]))
        for band, scene in enumerate(self.scenes):
            self.wave.passed[0] += trace_block(scene, source, block, seed, found, flow)
            self.radiance += self.colour[band, 1] * found[:, :, 0]
            self.stokes[:, :, band] = found.sum(axis=0)
        flow /= len(self.scenes)
        return self.stokes
