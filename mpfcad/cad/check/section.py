"""Read the files of a section's body back and compare them with its exact pieces."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import MeshCheck, facet_area
from mpfcad.cad.check.step.body import StepCheck, check_one_body
from mpfcad.cad.check.surface import (
    Corner,
    FacetError,
    Secant,
    check_mesh,
    recover_curvature,
)
from mpfcad.cad.shape.mesh import mesh_contact
from mpfcad.cad.shape.section_mesh import chord_tolerance
from mpfcad.film import PrismFilm, Section
from mpfcad.film.section import ARC

#: Largest relative error of the volume of a mesh.
VOLUME_LIMIT = 1e-4


def check_section_stl(
    path: Path, section: Section, angle_tolerance: float, film: PrismFilm | None = None
) -> MeshCheck:
    """Return what the STL file at `path` holds, measured against the section's body.

    With `film`, whose parabolas the section has, the curvature of each groove is recovered. Facet
    normals may be off by `angle_tolerance` [rad].

    Raises
    ------
    ExportError
        when it is not one closed body facing outward.
    """
    return check_mesh(path, SectionSurface(section, film), angle_tolerance)


class SectionSurface:
    """The outline of a section, with the parabolas of a film where it has any."""

    volume_limit = VOLUME_LIMIT

    def __init__(self, section: Section, film: PrismFilm | None) -> None:
        self.section, self.film, self.volume = section, film, section.volume

    def extent(self, top: float) -> tuple[Corner, Corner]:
        """Return the corners of the bounding box [mm].

        How high chords reach in a convex arc is a matter of their number: that is in the heights.
        """
        section = self.section
        return (0.0, 0.0, section.underside), (section.width, section.length, top)

    def compare(self, top: NDArray[np.float64], angle_tolerance: float) -> FacetError:
        """Return how far the facets of the top are off."""
        section, facet = self.section, top
        left, right = facet[:, :, 0].min(axis=1), facet[:, :, 0].max(axis=1)
        middle = (left + right) / 2
        piece = section.piece_of(middle)
        area = facet_area(facet)
        size = np.linalg.norm(area, axis=1)
        lean = np.abs(area[:, 1]) / size
        angle = np.arctan2(-area[:, 0], area[:, 2])
        rise = section.height_on(piece, right) - section.height_on(piece, left)
        secant = np.hypot(angle - np.arctan2(rise, right - left), lean)
        at_middle, at_left, at_right = (
            np.hypot(angle - np.arctan(section.slope_on(piece, x)), lean)
            for x in (middle, left, right)
        )
        ends = np.maximum(at_left, at_right)
        allowed = chord_tolerance(section, angle_tolerance, piece, left, right) + 1e-9
        worst = int(np.argmax(ends / allowed))
        step = 2 * float(np.spacing(np.float32(section.width)))
        curvature = None
        if self.film is not None:
            curvature = _recover(self.film, facet, section.kind[piece] != ARC)
        return FacetError(
            height=float(np.abs(facet[:, :, 2] - section.height(facet[:, :, 0])).max()),
            height_limit=step * 2 + 2 * float(np.spacing(np.float32(np.abs(section.z).max()))),
            normal_rms=float(np.sqrt(np.mean(at_middle**2))),
            normal_rms_limit=None,
            normal=float(ends[worst]),
            normal_limit=float(allowed[worst]),
            curvature=curvature,
            secant=Secant(
                float(np.sqrt(np.average(secant**2, weights=size))), None, float(secant.max())
            ),
        )


def _recover(
    film: PrismFilm, facet: NDArray[np.float64], straight: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return C [1/mm] of each groove, (n,), over facets above its walls.

    On the parabola, tip - z = C/2 (w² - x²), though an arc may stand in the tip's place. A groove
    without such facets has resin narrower than a sliver, or only on a valley's arc: as much C as
    the film has there.
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
    found = recover_curvature(place, drop, room, film.groove_count, np.nan)
    left_out = (mesh_contact(film) == 0) & (film.profile == "filled")
    unseen = np.where(left_out, film.curvature, film.groove.curvature_empty)
    return np.where(np.isnan(found), unseen, found)


def check_section_step(path: Path, section: Section, body: str) -> StepCheck:
    """Return what a STEP file holds, once it is found to be the section's one solid `body`.

    Raises
    ------
    ExportError
        when it holds another body, or one that is not valid or off in volume or extent.
    """
    low = (0.0, 0.0, section.underside)
    high = (section.width, section.length, section.underside + section.thickness)
    return check_one_body(path, body, section.volume, low, high, repair=False)
