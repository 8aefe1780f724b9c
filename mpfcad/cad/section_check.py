"""Read the files of a section's body back and compare them with its exact pieces."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpfcad.cad.section_mesh import chord_tolerance
from mpfcad.cad.step_check import bounding_box, check_solids, enclosed_volume, read_bodies
from mpfcad.cad.stl_check import check_closed, read_facets, refuse_above
from mpfcad.errors import ExportError
from mpfcad.film import Section

#: Largest relative error of the volume of a mesh, and of a solid.
VOLUME_TOLERANCE, SOLID_VOLUME_TOLERANCE = 1e-4, 2e-9
#: Largest error [mm] of a solid's extents.
EXTENT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class SectionMeshCheck:
    """What an STL file of a section's body was found to hold.

    Attributes
    ----------
    volume_error
        relative error of the enclosed volume
    normal_error_rms
        rms angle [rad] between a facet and the surface's secant between the facet's ends: rounding
    normal_error_max
        largest angle [rad] between a facet and the surface at the facet's two ends
    height_error_max
        largest distance [mm] in z between a corner and the surface
    triangle_count
        number of facets
    """

    volume_error: float
    normal_error_rms: float
    normal_error_max: float
    height_error_max: float
    triangle_count: int


def check_section_stl(path: Path, section: Section, angle_tolerance: float) -> SectionMeshCheck:
    """Return what the STL file at `path` holds, once it is found to be the section's body.

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
    extent = corner.max(axis=(0, 1))[:2], corner.min(axis=(0, 1))
    size = np.array([section.width, section.length], np.float32)
    low = np.array([0, 0, section.underside], np.float32)
    if np.any(extent[0] != size) or np.any(extent[1] != low):
        raise ExportError(f"{path.name}: extent {extent} mm: must be {size} mm from {low}")
    top = corner[_is_top(corner, size, low[2])]
    left, right = top[:, :, 0].min(axis=1), top[:, :, 0].max(axis=1)
    step = 2 * float(np.spacing(np.float32(section.width)))
    piece = section.piece_of((left + right) / 2)
    area = np.cross(top[:, 1] - top[:, 0], top[:, 2] - top[:, 0])
    lean = np.abs(area[:, 1]) / np.linalg.norm(area, axis=1)
    angle = np.arctan2(-area[:, 0], area[:, 2])
    rise = section.height_on(piece, right) - section.height_on(piece, left)
    secant = np.hypot(angle - np.arctan2(rise, right - left), lean)
    ends = np.maximum(
        *[np.hypot(angle - np.arctan(section.slope_on(piece, x)), lean) for x in (left, right)]
    )
    allowed = chord_tolerance(section, angle_tolerance, piece, left, right)
    beyond = float(np.max(ends - allowed))
    refuse_above(path, "normal error beyond the tolerance [rad]", beyond, 1e-9)
    height = np.abs(top[:, :, 2] - section.height(top[:, :, 0])).max()
    limit = step * 2 + 2 * float(np.spacing(np.float32(np.abs(section.z).max())))
    refuse_above(path, "height error [mm]", float(height), limit)
    rms = float(np.sqrt(np.mean(secant**2)))
    return SectionMeshCheck(float(error), rms, float(ends.max()), float(height), len(corner))


def check_section_step(path: Path, section: Section, body: str) -> float:
    """Return the volume [mm³] of the one solid `body` in a STEP file, once it is the section's.

    Raises
    ------
    ExportError
        when it holds another body, or one that is not valid or off in volume or extent.
    """
    path = Path(path)
    shapes = read_bodies(path)
    if set(shapes) != {body}:
        raise ExportError(f"{path.name}: bodies {sorted(shapes)}: must be {body}")
    check_solids(path, body, shapes[body], 1)
    volume = enclosed_volume(shapes[body])
    error = abs(volume / section.volume - 1)
    refuse_above(path, "relative volume error", error, SOLID_VOLUME_TOLERANCE)
    low, high = bounding_box(shapes)
    top = section.underside + section.thickness
    off = max(
        np.abs(low - (0, 0, section.underside)).max(),
        np.abs(high - (section.width, section.length, top)).max(),
    )
    refuse_above(path, "extent error [mm]", float(off), EXTENT_TOLERANCE)
    return volume


def _is_top(corner: np.ndarray, size: np.ndarray, underside: float) -> np.ndarray:
    side = np.all(corner[:, :, 2] == underside, axis=1)
    for axis in (0, 1):
        for level in (0.0, size[axis]):
            side |= np.all(corner[:, :, axis] == level, axis=1)
    return ~side
