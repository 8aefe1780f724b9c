"""Read the files of a film of cells back and compare them with its closed form."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.mesh_check import (
    MeshCheck,
    check_closed,
    check_extent,
    read_facets,
    refuse_above,
    select_top,
)
from mpfcad.cad.step_check import StepCheck, check_one_body
from mpfcad.film import CellFilm

#: Largest relative error of the volume of a mesh (dishes at 5°: 6e-4 by their chords), of a solid.
VOLUME_TOLERANCE, SOLID_VOLUME_TOLERANCE = 1e-3, 1e-9


def check_cell_stl(path: Path, film: CellFilm, angle_tolerance: float) -> MeshCheck:
    """Return what the STL file at `path` holds, once it is found to be the film.

    Raises
    ------
    ExportError
        when it is not one closed body facing outward, or is off in volume, extent, height, or
        facet normals (by more than `angle_tolerance` [rad] and what float32 forces).
    """
    path = Path(path)
    corner, normal = read_facets(path)
    error = check_closed(path, corner, normal) / film.volume - 1
    refuse_above(path, "relative volume error", abs(error), VOLUME_TOLERANCE)
    check_extent(path, corner, (0, 0, 0), (*film.size, film.thickness))
    facet = select_top(corner)
    area = np.cross(facet[:, 1] - facet[:, 0], facet[:, 2] - facet[:, 0])
    step = float(np.spacing(np.float32(max(film.size))))
    steepest = film.groove.wall_slope + film.curvature * film.groove.half_width
    height = float(np.abs(facet[..., 2] - film.height(facet[..., 0], facet[..., 1])).max())
    refuse_above(path, "height error [mm]", height, (1 + steepest) * 2 * step)
    angle = _angles(film, facet.mean(axis=1), area)
    # Rounding turns a facet by a step over its narrowest side.
    edge = np.linalg.norm(facet - np.roll(facet, 1, axis=1), axis=2)
    narrow = np.linalg.norm(area, axis=1) / edge.max(axis=1)
    allowed = angle_tolerance + 2 * step * (1 + steepest) / narrow
    worst = int(np.argmax(angle / allowed))
    refuse_above(path, "normal error [rad]", float(angle[worst]), float(allowed[worst]))
    return MeshCheck(
        True,
        float(error),
        VOLUME_TOLERANCE,
        float(np.sqrt(np.mean(angle**2))),
        None,
        None,
        float(angle[worst]),
        float(allowed[worst]),
        height,
        len(corner),
        _recover_curvature(film, facet, step),
    )


def _angles(
    film: CellFilm, middle: NDArray[np.float64], area: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the angle [rad] between each facet and the surface at its middle, (t,)."""
    slope = film.slope(middle[:, 0], middle[:, 1])
    surface = np.stack([-slope[0], -slope[1], np.ones(len(middle))], axis=1)
    sine = np.linalg.norm(np.cross(surface, area), axis=1)
    return np.arctan2(sine, np.sum(surface * area, axis=1))


def _recover_curvature(
    film: CellFilm, facet: NDArray[np.float64], step: float
) -> NDArray[np.float64]:
    """Return the cells' one C [1/mm], (1,), by least squares over the facets above bare walls.

    On a curved face tip - z = C/2 (w² - t²) with t the distance from the nearer valley; of a dish
    it is the sum of both directions.
    """
    w = film.groove.half_width
    local = np.abs(film.local(facet[..., 0], facet[..., 1]))
    if film.shape == "paraboloid":
        room = np.sum(w**2 - local**2, axis=0)
    else:
        room = w**2 - np.min(local, axis=0) ** 2
    if film.profile == "filled":
        wall = film.base + film.groove.wall_slope * np.min(local, axis=0).mean(axis=1)
        used = facet[..., 2].mean(axis=1) - wall > 4 * film.groove.wall_slope * step
        room, facet = room[used], facet[used]
    if not room.any():
        return np.array([film.groove.curvature_empty])
    drop = film.thickness - facet[..., 2]
    return np.array([2 * np.sum(drop * room) / np.sum(room**2)])


def check_cell_step(path: Path, film: CellFilm) -> StepCheck:
    """Return what a STEP file holds, once it is found to be the film as one solid `film`.

    Raises
    ------
    ExportError
        when it holds another body, or one that is not valid or off in volume or extent.
    """
    high = (*film.size, film.thickness)
    return check_one_body(path, "film", film.volume, (0, 0, 0), high, SOLID_VOLUME_TOLERANCE)
