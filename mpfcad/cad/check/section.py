"""Read the files of a section's body back and compare them with its exact pieces."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import (
    MeshCheck,
    check_closed,
    check_extent,
    read_facets,
    refuse_above,
    select_top,
)
from mpfcad.cad.check.step import StepCheck, check_one_body
from mpfcad.cad.shape.section_mesh import chord_tolerance
from mpfcad.film import PrismFilm, Section
from mpfcad.film.section import ARC

#: Largest relative error of the volume of a mesh.
VOLUME_TOLERANCE = 1e-4


def check_section_stl(
    path: Path, section: Section, angle_tolerance: float, film: PrismFilm | None = None
) -> MeshCheck:
    """Return what the STL file at `path` holds, once it is found to be the section's body.

    With `film`, whose parabolas the section has, the curvature of each groove is recovered.

    Raises
    ------
    ExportError
        when it is not one closed body facing outward, or is off in volume, extent, height, or
        facet normals (by more than `angle_tolerance` [rad]).
    """
    path = Path(path)
    corner, normal = read_facets(path)
    volume = check_closed(path, corner, normal)
    error = volume / section.volume - 1
    refuse_above(path, "relative volume error", abs(error), VOLUME_TOLERANCE)
    # How high chords reach in a convex arc is a matter of their number: heights are checked below.
    top = float(corner[..., 2].max())
    low = (0.0, 0.0, section.underside)
    check_extent(path, corner, low, (section.width, section.length, top))
    facet = select_top(corner)
    left, right = facet[:, :, 0].min(axis=1), facet[:, :, 0].max(axis=1)
    middle = (left + right) / 2
    piece = section.piece_of(middle)
    area = np.cross(facet[:, 1] - facet[:, 0], facet[:, 2] - facet[:, 0])
    size = np.linalg.norm(area, axis=1)
    lean = np.abs(area[:, 1]) / size
    angle = np.arctan2(-area[:, 0], area[:, 2])
    rise = section.height_on(piece, right) - section.height_on(piece, left)
    secant = np.hypot(angle - np.arctan2(rise, right - left), lean)
    at_middle, at_left, at_right = (
        np.hypot(angle - np.arctan(section.slope_on(piece, x)), lean) for x in (middle, left, right)
    )
    ends = np.maximum(at_left, at_right)
    allowed = chord_tolerance(section, angle_tolerance, piece, left, right)
    worst = int(np.argmax(ends / allowed))
    refuse_above(path, "normal error [rad]", float(ends[worst]), float(allowed[worst]) + 1e-9)
    height = float(np.abs(facet[:, :, 2] - section.height(facet[:, :, 0])).max())
    step = 2 * float(np.spacing(np.float32(section.width)))
    limit = step * 2 + 2 * float(np.spacing(np.float32(np.abs(section.z).max())))
    refuse_above(path, "height error [mm]", height, limit)
    return MeshCheck(
        True,
        volume,
        float(error),
        VOLUME_TOLERANCE,
        float(np.sqrt(np.mean(at_middle**2))),
        float(np.sqrt(np.average(secant**2, weights=size))),
        None,
        float(ends[worst]),
        float(allowed[worst]),
        height,
        len(corner),
        None if film is None else _recover_curvature(film, facet, section.kind[piece] != ARC),
        float(secant.max()),
    )


def _recover_curvature(
    film: PrismFilm, facet: NDArray[np.float64], straight: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return C [1/mm] of each groove, (n,), by least squares over facets above its walls.

    On the parabola, tip - z = C/2 (w² - x²), though an arc may stand in the tip's place. A groove
    without such facets counts as empty.
    """
    middle = facet[:, :, 0].mean(axis=1)
    groove = np.clip((middle / film.groove.pitch).astype(int), 0, film.groove_count - 1)
    local = facet[:, :, 0] - film.groove_position[groove][:, None]
    wall = film.base + film.groove.wall_slope * np.abs(local.mean(axis=1))
    above = facet[:, :, 2].mean(axis=1) - wall
    rounding = 4 * film.groove.wall_slope * float(np.spacing(np.float32(film.width)))
    used = straight & ((film.profile == "ideal") | (above > rounding))
    room = film.groove.half_width**2 - local[used] ** 2
    drop = film.thickness - facet[used][:, :, 2]
    place = np.repeat(groove[used], 3)
    count = film.groove_count
    weighted = np.bincount(place, (drop * room).ravel(), count)
    square = np.bincount(place, (room**2).ravel(), count)
    empty = np.full(count, film.groove.curvature_empty)
    return np.divide(2 * weighted, square, out=empty, where=square > 0)


def check_section_step(path: Path, section: Section, body: str) -> StepCheck:
    """Return what a STEP file holds, once it is found to be the section's one solid `body`.

    Raises
    ------
    ExportError
        when it holds another body, or one that is not valid or off in volume or extent.
    """
    low = (0.0, 0.0, section.underside)
    high = (section.width, section.length, section.underside + section.thickness)
    return check_one_body(path, body, section.volume, low, high)
