"""Scenes of several bands made one: its path loses what the band that loses least would lose."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics import sheet, slab
from mpfcad.optics.cavity import board, endless
from mpfcad.optics.cavity.finite import WALL_REFLECTANCE
from mpfcad.optics.element import CAVITY, CONVERTER, FILM, SHEET, SLAB, Element, Film, LibraryFilm
from mpfcad.optics.film import passage as film
from mpfcad.optics.scene import Scene
from mpfcad.optics.spectral import converter
from mpfcad.optics.spectral.hue import EMITTER, HOLE, MATERIAL, OWN, RESIN, SURFACE, WALL, Tables

#: Columns of absorption [1/mm] by kind and material, and of what is left at a surface.
_SOAK = {
    SLAB: {MATERIAL: slab.ABSORPTION},
    FILM: {MATERIAL: film.ABSORPTION, RESIN: film.RESIN_ABSORPTION},
    CONVERTER: {MATERIAL: converter.DEPTH},
}
_TUBES = {SURFACE: endless.REFLECTANCE, EMITTER: endless.LAMP_REFLECTANCE}
_BOARD = {
    SURFACE: endless.REFLECTANCE, EMITTER: board.LED_REFLECTANCE, HOLE: board.HOLE_REFLECTANCE,
    WALL: board.CUP_REFLECTANCE,
}  # fmt: skip
_STRIKE = {SHEET: {SURFACE: sheet.TRANSMISSION}}


def same_geometry(elements: list[Element], first: list[Element]) -> list[Element]:
    """Return elements with the meshes of equal ones, so that these are built once."""
    return [_with_mesh(one, of) for one, of in zip(elements, first, strict=True)]


def _with_mesh(element: Any, of: Any) -> Any:
    if isinstance(element, LibraryFilm):
        return replace(element, library=of.library)
    if not isinstance(element, Film):
        return element
    resin = element.resin and replace(element.resin, prism=of.resin.prism)
    return replace(element, mesh=of.mesh, resin=resin)


def envelope(
    scenes: Sequence[Scene], source: NDArray[np.float64], luminance: NDArray[np.float64],
    taken: NDArray[np.float64], emitted: NDArray[np.float64], *, forward: bool = False,
) -> tuple[Scene, Tables]:  # fmt: skip
    """Return the one scene of bands that take the same way, and how they differ.

    The other arguments are those of `Tables`.

    Raises
    ------
    TraceError
        when bands differ by more than absorption, reflectance or transmission.
    """
    rows = np.array([one.parameter for one in scenes])
    _show_resin(rows, scenes[0].kind == FILM)
    kind, scene = scenes[0].kind, scenes[0]
    bands, count = len(scenes), len(kind)
    soak, strike = np.zeros((count, 2, bands)), np.ones((count, 4, bands))
    parameter = rows[0].copy()
    free = np.zeros(rows.shape[1:], bool)
    for e, of in enumerate(kind):
        for material, column in _SOAK.get(of, {}).items():
            free[e, column] = True
            parameter[e, column] = rows[:, e, column].min()
            soak[e, material] = rows[:, e, column] - parameter[e, column]
        for what, column in _surfaces(of, scene).items():
            free[e, column] = True
            parameter[e, column], strike[e, what] = _most(rows[:, e, column])
    wall = scene.wall.copy()
    if len(scene.lamp):
        wall[WALL_REFLECTANCE], strike[0, WALL] = _most(
            np.array([one.wall[WALL_REFLECTANCE] for one in scenes])
        )
    if (np.ptp(rows, axis=0)[~free] != 0).any():
        raise TraceError("bands: expected elements that differ by absorption or reflectance alone")
    coloured = (soak != 0).any(axis=(1, 2)) | (strike != 1).any(axis=(1, 2))
    parameter[coloured & (kind == FILM), film.MEASURED] = 1.0
    species = np.full(count, OWN)
    species[kind == CONVERTER] = np.arange(np.count_nonzero(kind == CONVERTER))
    tables = Tables(
        coloured.astype(np.int64),
        soak,
        strike,
        source,
        luminance,
        species,
        taken,
        emitted,
        np.array([forward], np.int64),
    )
    return scene._replace(parameter=parameter, wall=wall), tables


def _show_resin(rows: NDArray[np.float64], is_film: NDArray[np.bool_]) -> None:
    """Have resin be of its own material at all bands, (b, e, columns), where it is at one."""
    shown = rows[:, :, film.RESIN_INDEX] > 0
    partly = shown.any(axis=0) & ~shown.all(axis=0) & is_film
    for e in np.flatnonzero(partly):
        thinnest = rows[shown[:, e], e, film.THINNEST][0]
        for b in np.flatnonzero(~shown[:, e]):
            row = rows[b, e]
            row[film.RESIN_INDEX], row[film.THINNEST] = row[film.INDEX], thinnest
            row[film.RESIN_ABSORPTION] = row[film.ABSORPTION]


def _surfaces(kind: int, scene: Scene) -> dict[int, int]:
    """Return the columns of what is left where light meets an element."""
    if kind == CAVITY:
        return _BOARD if len(scene.led) else _TUBES
    return _STRIKE.get(kind, {})


def _most(values: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Return the largest of some shares, and all of them over it; 1 where all are 0."""
    most = float(values.max())
    return most, values / most if most > 0 else np.ones_like(values)
