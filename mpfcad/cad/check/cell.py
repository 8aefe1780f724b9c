"""Compare the mesh of a film of cells with its closed form."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import (
    MeshCheck,
    angle_to_surface,
    facet_area,
    narrowest_side,
    refuse_above,
)
from mpfcad.cad.check.surface import FacetError, FilmSurface, check_mesh, recover_curvature
from mpfcad.cad.step.outline import drawn_sliver
from mpfcad.film import CellFilm

#: Largest relative error of the volume of a mesh (dishes at 5°: 6e-4 by their chords).
VOLUME_LIMIT = 1e-3


def check_cell_stl(path: Path, film: CellFilm, angle_tolerance: float) -> MeshCheck:
    """Return what the STL file at `path` holds, measured against the film; its gates judge.

    Facet normals may be off by `angle_tolerance` [rad] and what float32 forces.

    Raises
    ------
    ExportError
        when it is not one closed body facing outward.
    """
    return check_mesh(path, CellSurface(film), angle_tolerance)


def check_cell(
    path: Path, name: str, top: NDArray[np.float64], cell: CellFilm, volume: float
) -> tuple[float, float]:
    """Return C [1/mm] along x and y of a cell of a library by its top's corners (k, 3) [mm].

    Halfway along a side between two tips the height is tip - C w²/2.

    Raises
    ------
    ExportError
        when volume or surface is not that of the closed form.
    """
    refuse_above(path, f"{name}: volume error", abs(volume / cell.volume - 1), VOLUME_LIMIT)
    w = cell.groove.half_width
    step = float(np.spacing(np.float32(max(cell.thickness, cell.groove.pitch))))
    steepest = cell.groove.wall_slope + max(cell.both) * w
    off = float(np.abs(top[:, 2] - cell.height(top[:, 0], top[:, 1])).max())
    room = 4 * (1 + steepest) * step + cell.groove.wall_slope * drawn_sliver(max(cell.size))
    refuse_above(path, f"{name}: height error [mm]", off, room)
    found = [
        2 * (cell.thickness - top[np.argmin(np.hypot(top[:, 0] - x, top[:, 1] - y)), 2]) / w**2
        for x, y in ((w, 0.0), (0.0, w))
    ]
    limit = 2 * room / w**2
    error = float(np.abs(np.array(found) - cell.both).max())
    refuse_above(path, f"{name}: curvature error [1/mm]", error, limit)
    return float(found[0]), float(found[1])


class CellSurface(FilmSurface[CellFilm]):
    """Equal cells in both directions."""

    volume_limit = VOLUME_LIMIT

    def compare(self, top: NDArray[np.float64], angle_tolerance: float) -> FacetError:
        """Return how far the facets of the top are off."""
        film, facet = self.film, top
        area = facet_area(facet)
        step = float(np.spacing(np.float32(max(film.size))))
        steepest = film.groove.wall_slope + film.curvature * film.groove.half_width
        middle = facet.mean(axis=1)
        slope = film.slope(middle[:, 0], middle[:, 1])
        angle = angle_to_surface(slope[0], slope[1], area)
        allowed = angle_tolerance + 2 * step * (1 + steepest) / narrowest_side(facet, area)
        worst = int(np.argmax(angle / allowed))
        return FacetError(
            height=float(np.abs(facet[..., 2] - film.height(facet[..., 0], facet[..., 1])).max()),
            height_limit=(1 + steepest) * 2 * step,
            normal_rms=float(np.sqrt(np.mean(angle**2))),
            normal_rms_limit=None,
            normal=float(angle[worst]),
            normal_limit=float(allowed[worst]),
            curvature=_recover_curvature(film, facet, step),
        )


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
    drop = film.thickness - facet[..., 2]
    one = np.zeros(room.shape, np.int64)
    return recover_curvature(one, drop, room, 1, film.groove.curvature_empty)
