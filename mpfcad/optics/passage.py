"""One ray's passage through one element of a scene, of whatever kind, with its weight."""

import math

from mpfcad.optics import slab
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.recorder import (
    FLOW_DOWN,
    FLOW_ELEMENTS,
    FLOW_LOST,
    FLOW_RIM,
    FLOW_UP,
)
from mpfcad.optics.base.roulette import roulette
from mpfcad.optics.bsdf.passage import bsdf_passage
from mpfcad.optics.cavity.finite import FAR, LEFT, NEAR, RIGHT
from mpfcad.optics.cavity.passage import cavity_passage
from mpfcad.optics.element import (
    BSDF,
    CAVITY,
    CELL_FILM,
    CONVERTER,
    LIBRARY_FILM,
    MUELLER,
    PLANE,
    SHEET,
    SLAB,
    TABLE,
)
from mpfcad.optics.film import passage as film
from mpfcad.optics.film.passage import placed_film_passage
from mpfcad.optics.library.cell_passage import placed_cell_passage
from mpfcad.optics.library.passage import placed_library_passage
from mpfcad.optics.score.state import PASSED, soak, weigh
from mpfcad.optics.sheet import DEPOLARISATION, TRANSMISSION, sheet_passage
from mpfcad.optics.slab import slab_passage
from mpfcad.optics.spectral.film import converter_passage
from mpfcad.optics.spectral.hue import MATERIAL, RESIN, SURFACE, seen, stain, strike
from mpfcad.optics.stokes.mueller import mueller_passage
from mpfcad.optics.stokes.plane import plane_passage
from mpfcad.optics.stokes.state import depolarise, fade, scatter_light

#: In the place of the next element: there is none, the path has ended.
ENDED = -1


@kernel
def pass_element(scene, e, up, x, y, z, dx, dy, dz, lamp, weight, flow, light, score, hue, rng):
    """Follow a ray through element e: (way, x, y, dx, dy, dz, weight, radiance found).

    `way` is 1 when it leaves upward, -1 downward, 0 when it was lost; z and lamp count for a path
    that starts in the cavity. `light` is the state of polarised light, `score` what its path keeps
    for derivatives, `hue` what it weighs at each band, or None.
    """
    kind = scene.kind[e]
    parameter = scene.parameter[e]
    way = 1
    before = weight
    found = 0.0
    if kind == CAVITY:
        x, y, dx, dy, dz, weight, found = cavity_passage(
            scene, x, y, z, dx, dy, dz, lamp, weight, flow, light, score, hue, rng
        )
        before = weight
    elif kind == SLAB:
        way, x, y, dx, dy, dz, travelled = slab_passage(
            scene.phase, parameter, up, x, y, dx, dy, dz, light, score, rng
        )
        weight *= math.exp(-parameter[slab.ABSORPTION] * travelled)
        stain(hue, e, MATERIAL, travelled)
    elif kind == SHEET:
        kx, ky, kz = dx, dy, dz
        passed, dx, dy, dz = sheet_passage(parameter, dx, dy, dz, score, rng)
        scatter_light(light, passed, kx, ky, kz, dx, dy, dz)
        fade(light, 1.0 - parameter[DEPOLARISATION])
        weight *= parameter[TRANSMISSION]
        weigh(score, PASSED, 1.0 / parameter[TRANSMISSION])
        strike(hue, e, SURFACE)
        way = 1 if passed == up else -1
    elif kind == BSDF:
        table = int(parameter[TABLE])
        passed, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
        depolarise(light)
        weight *= survival
        way = 1 if passed == up else -1
    elif kind == PLANE:
        # A scene that has one is traced with a state.
        if light is not None:
            passed, dz, survival = plane_passage(parameter, dx, dy, dz, light, rng)
            weight *= survival
            way = 1 if passed == up else -1
    elif kind == MUELLER:
        if light is not None:
            weight *= mueller_passage(parameter, dx, dy, dz, light)
            way = 1 if up else -1
    elif kind == CONVERTER:
        way, x, y, dx, dy, dz, weight = converter_passage(
            scene, e, up, x, y, dx, dy, dz, weight, flow, light, hue, rng
        )
        before = weight
    elif kind == LIBRARY_FILM:
        way, x, y, dx, dy, dz = placed_library_passage(
            scene.library, parameter, up, x, y, dx, dy, dz, light, rng
        )
    elif kind == CELL_FILM:
        way, x, y, dx, dy, dz = placed_cell_passage(
            scene.cells, parameter, up, x, y, dx, dy, dz, light, rng
        )
    else:
        way, x, y, dx, dy, dz, travelled, soaked = placed_film_passage(
            scene.tiles, scene.phase, parameter, up, x, y, dx, dy, dz, light, rng
        )
        survival = math.exp(
            -parameter[film.ABSORPTION] * travelled - parameter[film.RESIN_ABSORPTION] * soaked
        )
        weight *= survival
        soak(score, parameter[film.ABSORPTION], survival)
        stain(hue, e, MATERIAL, travelled)
        stain(hue, e, RESIN, soaked)
    flow[FLOW_ELEMENTS + e] += before - weight
    return way, x, y, dx, dy, dz, weight, found


@kernel
def next_element(scene, e, way, x, y, weight, flow, hue, rng):
    """Return what a ray that has left element e meets: (element or `ENDED`, weight, radiance)."""
    if way == 0:
        flow[FLOW_LOST] += weight
        return ENDED, weight, 0.0
    wall = scene.wall
    if not (wall[LEFT] <= x <= wall[RIGHT] and wall[NEAR] <= y <= wall[FAR]):
        flow[FLOW_RIM] += weight
        return ENDED, weight, 0.0
    weight = roulette(weight, flow, rng)
    if weight == 0.0:
        return ENDED, weight, 0.0
    e += way
    if e < 0:
        flow[FLOW_DOWN] += weight
        return ENDED, weight, seen(hue, weight * scene.below)
    if e == len(scene.kind):
        flow[FLOW_UP] += weight
        return ENDED, weight, seen(hue, weight * scene.above)
    return e, weight, 0.0
