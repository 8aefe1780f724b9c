"""One ray's passage through one element of a scene, of whatever kind, with its weight."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.recorder import FLOW_ELEMENTS
from mpfcad.optics.bsdf.passage import bsdf_passage
from mpfcad.optics.cavity.passage import cavity_passage
from mpfcad.optics.element import BSDF, CAVITY, CELL_FILM, LIBRARY_FILM, SHEET, SLAB, TABLE
from mpfcad.optics.film.passage import placed_film_passage
from mpfcad.optics.library.cell_passage import placed_cell_passage
from mpfcad.optics.library.passage import placed_library_passage
from mpfcad.optics.sheet import TRANSMISSION, sheet_passage
from mpfcad.optics.slab import slab_passage


@kernel
def pass_element(scene, e, up, x, y, z, dx, dy, dz, lamp, weight, flow, rng):
    """Follow a ray through element e: (way, x, y, dx, dy, dz, weight, radiance found).

    `way` is 1 when it leaves upward, -1 downward, 0 when it was lost; z and lamp count for a path
    that starts in the cavity.
    """
    kind = scene.kind[e]
    parameter = scene.parameter[e]
    way = 1
    before = weight
    found = 0.0
    if kind == CAVITY:
        x, y, dx, dy, dz, weight, found = cavity_passage(
            scene, x, y, z, dx, dy, dz, lamp, weight, flow, rng
        )
        before = weight
    elif kind == SLAB:
        way, x, y, dx, dy, dz, survival = slab_passage(
            scene.phase, parameter, up, x, y, dx, dy, dz, rng
        )
        weight *= survival
    elif kind == SHEET:
        passed, dx, dy, dz = sheet_passage(parameter, dx, dy, dz, rng)
        weight *= parameter[TRANSMISSION]
        way = 1 if passed == up else -1
    elif kind == BSDF:
        table = int(parameter[TABLE])
        passed, dx, dy, dz, survival = bsdf_passage(scene.bsdf, table, dx, dy, dz, rng)
        weight *= survival
        way = 1 if passed == up else -1
    elif kind == LIBRARY_FILM:
        way, x, y, dx, dy, dz = placed_library_passage(
            scene.library, parameter, up, x, y, dx, dy, dz, rng
        )
    elif kind == CELL_FILM:
        way, x, y, dx, dy, dz = placed_cell_passage(
            scene.cells, parameter, up, x, y, dx, dy, dz, rng
        )
    else:
        way, x, y, dx, dy, dz, survival = placed_film_passage(
            scene.tiles, scene.phase, parameter, up, x, y, dx, dy, dz, rng
        )
        weight *= survival
    flow[FLOW_ELEMENTS + e] += before - weight
    return way, x, y, dx, dy, dz, weight, found
