"""Elements lowered to rows of `Scene.parameter`: each value by the name of its column.

The columns are named beside the kernel that reads them, and no order of fields counts: a field
added to an element, or moved in it, changes nothing until it gets a column here.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics import sheet, slab
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.cavity import board, endless
from mpfcad.optics.cavity.board import Board, Cup
from mpfcad.optics.element import (
    BSDF,
    CAVITY,
    CELL_FILM,
    CONVERTER,
    FILM,
    LIBRARY_FILM,
    MUELLER,
    PLANE,
    SHEET,
    SLAB,
    TABLE,
    BsdfSheet,
    Cavity,
    Element,
    Film,
    LibraryFilm,
    Sheet,
    Slab,
)
from mpfcad.optics.film import passage as film
from mpfcad.optics.library.top import CellTops
from mpfcad.optics.spectral import converter
from mpfcad.optics.spectral.converter import Converter
from mpfcad.optics.stokes import mueller, plane
from mpfcad.optics.stokes.mueller import MuellerLayer
from mpfcad.optics.stokes.plane import PlaneLayer

#: Columns of a row: as many as the kind with most of them needs.
COLUMNS = 19


class Rows:
    """What elements share, each once: `number` gives the row of an entry."""

    def __init__(self) -> None:
        self.entries: list = []
        self._row: dict[object, int] = {}

    def number(self, key: object, entry: object) -> float:
        """Return the row of an entry, which is added where its key is new."""
        if key not in self._row:
            self._row[key] = len(self.entries)
            self.entries.append(entry)
        return float(self._row[key])


class Shared:
    """The tiles, libraries, cells, phase functions and BSDF tables of a scene's elements."""

    def __init__(self) -> None:
        self.tiles, self.phases, self.bsdfs = Rows(), Rows(), Rows()
        self.libraries, self.cells = Rows(), Rows()

    def bsdf_row(self, table: BsdfTable | None, blend: float) -> float:
        """Return the row of a table, or -1 where there is none."""
        return -1.0 if table is None else self.bsdfs.number((id(table), blend), (table, blend))

    def phase_row(self, phase: NDArray[np.float64] | None) -> float:
        """Return the row of a phase function, or -1 where there is none."""
        return -1.0 if phase is None else self.phases.number(id(phase), phase)


def lower_element(element: Element, shared: Shared) -> tuple[int, NDArray[np.float64]]:
    """Return an element's kind and its row, (COLUMNS,) float64.

    Raises
    ------
    TraceError
        when it is of no known kind.
    """
    for known, (kind, columns_of) in _LOWERED.items():
        if isinstance(element, known):
            row = np.zeros(COLUMNS)
            for column, value in columns_of(element, shared).items():
                row[column] = float(value)
            if isinstance(element, LibraryFilm) and isinstance(element.library, CellTops):
                kind = CELL_FILM
            return kind, row
    names = ", ".join(known.__name__ for known in _LOWERED)
    raise TraceError(f"element {type(element).__name__}: expected one of {names}")


def quadrant(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle [rad], exact at right angles."""
    cosine, sine = math.cos(angle), math.sin(angle)
    if abs(cosine) < 1e-15 or abs(sine) < 1e-15:
        return float(round(cosine)), float(round(sine))
    return cosine, sine


def _cavity_columns(cavity: Cavity, shared: Shared) -> Mapping[int, float]:
    return {
        endless.HEIGHT: cavity.height,
        endless.LAMP_PITCH: cavity.lamp_pitch,
        endless.LAMP_POSITION: cavity.lamp_position,
        endless.LAMP_HEIGHT: cavity.lamp_height,
        endless.LAMP_RADIUS: cavity.lamp_radius,
        endless.LAMP_LUMINANCE: cavity.lamp_luminance,
        endless.LAMP_REFLECTANCE: cavity.lamp_reflectance,
        endless.REFLECTANCE: cavity.reflectance,
        endless.SPECULAR_FRACTION: cavity.specular_fraction,
        endless.BRDF: shared.bsdf_row(cavity.brdf, cavity.blend),
    }


def _board_columns(placed: Board, shared: Shared) -> Mapping[int, float]:
    return {
        endless.HEIGHT: placed.height,
        endless.REFLECTANCE: placed.reflectance,
        endless.SPECULAR_FRACTION: placed.specular_fraction,
        endless.BRDF: shared.bsdf_row(placed.brdf, placed.blend),
        board.PERIOD_ACROSS: placed.period[0],
        board.PERIOD_ALONG: placed.period[1],
        board.LED_WIDTH: placed.led_size[0],
        board.LED_LENGTH: placed.led_size[1],
        board.LED_HEIGHT: placed.led_height,
        board.LED_REFLECTANCE: placed.led_reflectance,
        board.LED_FLUX: placed.led_flux,
        board.HOLE_RADIUS: placed.hole_radius,
        board.HOLE_REFLECTANCE: placed.hole_reflectance,
        **_cup_columns(placed.cup),
    }


def _cup_columns(cup: Cup | None) -> Mapping[int, float]:
    if cup is None:
        return {}
    return {
        board.CUP_HEIGHT: cup.height,
        board.CUP_RADIUS: cup.radius,
        board.CUP_RIM: cup.rim_radius,
        board.CUP_REFLECTANCE: cup.reflectance,
        board.CUP_SPECULAR_FRACTION: cup.specular_fraction,
        board.CUP_SQUARE: cup.square,
    }


def _slab_columns(plate: Slab, shared: Shared) -> Mapping[int, float]:
    cosine, sine = quadrant(plate.axis)
    return {
        slab.DELAY: plate.delay,
        slab.AXIS_X: -sine,
        slab.AXIS_Y: cosine,
        slab.INDEX: plate.index,
        slab.THICKNESS: plate.thickness,
        slab.SCATTERING: plate.scattering,
        slab.ABSORPTION: plate.absorption,
        slab.ASYMMETRY: plate.asymmetry,
        slab.BONDED: plate.bonded,
        slab.PHASE: shared.phase_row(plate.phase),
        slab.INDEX_BELOW: plate.index_below,
    }


def _sheet_columns(thin: Sheet, shared: Shared) -> Mapping[int, float]:
    across = thin.sigma if thin.sigma_across is None else thin.sigma_across
    # A round lobe has no axis.
    cosine, sine = (1.0, 0.0) if across == thin.sigma else quadrant(thin.axis)
    return {
        sheet.SIGMA: thin.sigma,
        sheet.INDEX: thin.index,
        sheet.TRANSMISSION: thin.transmission,
        sheet.ACROSS: across,
        sheet.COSINE: cosine,
        sheet.SINE: sine,
        sheet.WIDE: thin.wide_sigma,
        sheet.SHARE: thin.wide_share,
        sheet.DEPOLARISATION: thin.depolarisation,
    }


def _film_columns(placed: Film, shared: Shared) -> Mapping[int, float]:
    cosine, sine = quadrant(placed.rotation)
    mesh, way = placed.mesh, placed.accelerator
    columns = {
        film.INDEX: placed.index,
        film.INDEX_BELOW: placed.index_below,
        film.OFFSET: placed.offset,
        film.COSINE: cosine,
        film.SINE: sine,
        film.FLIPPED: placed.flipped,
        film.TILE: shared.tiles.number((id(mesh), way), (mesh, way)),
        film.ABSORPTION: placed.absorption,
        film.ROUGHNESS: placed.roughness,
    }
    resin = placed.resin
    if resin is not None:
        columns |= {
            film.SCATTERING: resin.scattering,
            film.ASYMMETRY: resin.asymmetry,
            film.PHASE: shared.phase_row(resin.phase),
            film.PRISM: shared.tiles.number((id(resin.prism), "chain"), (resin.prism, "chain")),
        }
        if placed.shows_prism:
            index, absorption = resin.index, resin.absorption
            columns |= {
                film.RESIN_INDEX: placed.index if index is None else index,
                film.RESIN_ABSORPTION: placed.absorption if absorption is None else absorption,
                film.THINNEST: resin.thinnest,
            }
    return columns


def _library_columns(placed: LibraryFilm, shared: Shared) -> Mapping[int, float]:
    cosine, sine = quadrant(placed.rotation)
    held = placed.library
    rows = shared.cells if isinstance(held, CellTops) else shared.libraries
    return {
        film.INDEX: placed.index,
        film.INDEX_BELOW: placed.index_below,
        film.OFFSET: placed.offset,
        film.COSINE: cosine,
        film.SINE: sine,
        film.TILE: rows.number(id(held), held),
    }


def _bsdf_columns(thin: BsdfSheet, shared: Shared) -> Mapping[int, float]:
    return {TABLE: shared.bsdf_row(thin.table, thin.blend)}


def _plane_columns(layer: PlaneLayer, shared: Shared) -> Mapping[int, float]:
    cosine, sine = quadrant(layer.axis)
    return {
        plane.COSINE: cosine,
        plane.SINE: sine,
        plane.PASS_ALONG: layer.transmittance[0],
        plane.PASS_ACROSS: layer.transmittance[1],
        plane.BACK_ALONG: layer.reflectance[0],
        plane.BACK_ACROSS: layer.reflectance[1],
        plane.RETARDATION: layer.retardation,
    }


def _converter_columns(thin: Converter, shared: Shared) -> Mapping[int, float]:
    return {
        converter.INDEX: thin.index,
        converter.DEPTH: thin.depth,
        converter.THICKNESS: thin.thickness,
        converter.SCATTERING: thin.scattering,
        converter.ASYMMETRY: thin.asymmetry,
    }


def _mueller_columns(layer: MuellerLayer, shared: Shared) -> Mapping[int, float]:
    cosine, sine = quadrant(layer.axis)
    entries = {mueller.MATRIX + at: m for at, m in enumerate(layer.matrix.ravel())}
    return {mueller.COSINE: cosine, mueller.SINE: sine, **entries}


_LOWERED: Mapping[type, tuple[int, Callable[..., Mapping[int, float]]]] = {
    Cavity: (CAVITY, _cavity_columns),
    Board: (CAVITY, _board_columns),
    Slab: (SLAB, _slab_columns),
    Sheet: (SHEET, _sheet_columns),
    Film: (FILM, _film_columns),
    LibraryFilm: (LIBRARY_FILM, _library_columns),
    BsdfSheet: (BSDF, _bsdf_columns),
    PlaneLayer: (PLANE, _plane_columns),
    MuellerLayer: (MUELLER, _mueller_columns),
    Converter: (CONVERTER, _converter_columns),
}
