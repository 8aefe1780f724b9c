"""Read the files of a film of cells back and compare them with its closed form."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpfcad.cad.step_check import check_solids, enclosed_volume, read_bodies
from mpfcad.cad.stl_check import check_closed, read_facets, refuse_above
from mpfcad.errors import ExportError
from mpfcad.film import CellFilm

#: Largest relative error of the volume of a mesh (dishes at 5°: 6e-4 by their chords), of a solid.
VOLUME_TOLERANCE, SOLID_VOLUME_TOLERANCE = 1e-3, 1e-6


@dataclass(frozen=True)
class CellMeshCheck:
    """What an STL file of a film of cells was found to hold.

    Attributes
    ----------
    volume_error
        relative error of the enclosed volume
    normal_error_max
        largest angle [rad] between a facet and the surface at the facet's middle
    height_error_max
        largest distance [mm] in z between a corner and the surface
    triangle_count
        number of facets
    """

    volume_error: float
    normal_error_max: float
    height_error_max: float
    triangle_count: int


def check_cell_stl(path: Path, film: CellFilm, angle_tolerance: float) -> CellMeshCheck:
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
    size = np.array([*film.size, film.thickness], np.float32)
    low, high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    if np.any(low != 0) or np.any(high != size):
        raise ExportError(f"{path.name}: extent {low} to {high} mm: must be {size} mm from 0")
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    top = area[:, 2] > 0
    corner, area = corner[top], area[top]
    step = float(np.spacing(size.max()))
    steepest = film.groove.wall_slope + film.curvature * film.groove.half_width
    height = np.abs(corner[..., 2] - film.height(corner[..., 0], corner[..., 1])).max()
    refuse_above(path, "height error [mm]", float(height), (1 + steepest) * 2 * step)
    middle = corner.mean(axis=1)
    slope = film.slope(middle[:, 0], middle[:, 1])
    surface = np.stack([-slope[0], -slope[1], np.ones(len(middle))], axis=1)
    cosine = np.sum(surface * area, axis=1)
    sine = np.linalg.norm(np.cross(surface, area), axis=1)
    angle = np.arctan2(sine, cosine)
    # Rounding turns a facet by a step over its narrowest side.
    edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    narrow = np.linalg.norm(area, axis=1) / edge.max(axis=1)
    beyond = float(np.max(angle - 2 * step * (1 + steepest) / narrow))
    refuse_above(path, "normal error beyond rounding [rad]", beyond, angle_tolerance)
    return CellMeshCheck(float(error), float(angle.max()), float(height), len(top))


def check_cell_step(path: Path, film: CellFilm) -> float:
    """Return the volume [mm³] of the one solid `film` in a STEP file, once it is the film's.

    Raises
    ------
    ExportError
        when it holds another body, or one that is not valid or off in volume.
    """
    path = Path(path)
    shapes = read_bodies(path)
    if set(shapes) != {"film"}:
        raise ExportError(f"{path.name}: bodies {sorted(shapes)}: must be film")
    check_solids(path, "film", shapes["film"], 1)
    volume = enclosed_volume(shapes["film"])
    refuse_above(
        path, "relative volume error", abs(volume / film.volume - 1), SOLID_VOLUME_TOLERANCE
    )
    return volume
