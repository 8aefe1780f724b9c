"""Read an STL file back with trimesh and manifold3d, and compare it with the film it should be.

float32 moves each tip by up to one step, and each half groove with it, and lifts resin by less than
a step: a facet is compared with its half groove where its tip and contact point are. How far the
tips are off their places is stated on its own.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import MeshCheck
from mpfcad.cad.check.surface import (
    FacetError,
    FilmSurface,
    Secant,
    check_mesh,
    recover_curvature,
)
from mpfcad.cad.shape.mesh import mesh_contact
from mpfcad.cad.shape.rounding import coarsest_step, round_contact, round_tips
from mpfcad.film import PrismFilm
from mpfcad.units import deg

#: Largest relative error of the volume.
VOLUME_LIMIT = 1e-4
#: Largest rms angle [rad] between facets and surface, where float32 does not forbid it.
NORMAL_RMS_LIMIT = 0.01 * deg


def check_stl(path: Path, film: PrismFilm, angle_tolerance: float) -> MeshCheck:
    """Return what the STL file at `path` holds, measured against `film`; its gates judge.

    Facet normals may be off by `angle_tolerance` [rad].

    Raises
    ------
    ExportError
        when the file is not one closed body facing outward.
    """
    return check_mesh(path, GrooveSurface(film), angle_tolerance)


class GrooveSurface(FilmSurface[PrismFilm]):
    """Grooves as designed, one curvature each."""

    volume_limit = VOLUME_LIMIT

    def compare(self, top: NDArray[np.float64], angle_tolerance: float) -> FacetError:
        """Return how far the facets of the top are off."""
        film, facets = self.film, _Facets(self.film, top)
        curvature = facets.curvature()
        # Resin narrower than a sliver is meshed as none: as much C as the groove has.
        merged = (facets.contact == 0) & (film.profile == "filled")
        drawn = np.where(merged, film.groove.curvature_empty, film.curvature)
        error = float(np.max(np.abs(curvature - drawn)))
        return FacetError(
            height=facets.height_error(),
            height_limit=facets.height_tolerance(),
            normal_rms=float(np.sqrt(np.mean(facets.middle_error() ** 2))),
            normal_rms_limit=max(NORMAL_RMS_LIMIT, facets.rounding()),
            normal=facets.end_error(),
            normal_limit=angle_tolerance,
            curvature=np.where(merged, curvature - drawn + film.curvature, curvature),
            curvature_error=error,
            secant=facets.secant(),
            tip=float(np.abs(facets.moved).max()),
        )


class _Facets:
    """The top facets of a film, each as the straight piece it draws across the film."""

    def __init__(self, film: PrismFilm, top: NDArray[np.float64]) -> None:
        self.film = film
        self.corner = top
        area = np.cross(top[:, 1] - top[:, 0], top[:, 2] - top[:, 0])
        # The angle to the vertical in the x-z plane, and any lean along y on top of it.
        self.angle = np.arctan2(-area[:, 0], area[:, 2])
        self.area = np.linalg.norm(area, axis=1)
        self.lean = np.abs(area[:, 1]) / self.area
        tips = round_tips(film, np.float32)
        self.moved = tips - film.tip_position
        left, right = top[:, :, 0].min(axis=1), top[:, :, 0].max(axis=1)
        middle = (left + right) / 2
        last = film.groove_count - 1
        self.groove = np.clip(np.searchsorted(tips, middle, "right") - 1, 0, last)
        beyond = middle > (tips[self.groove] + tips[self.groove + 1]) / 2
        self.side = np.where(beyond, 1.0, -1.0)
        #: How far each facet's half groove was moved [mm]; from here on, x is without that.
        self.shift = self.moved[self.groove + beyond]
        self.left, self.right = left - self.shift, right - self.shift
        self.middle = middle - self.shift - film.groove_position[self.groove]
        self.step = coarsest_step(film, np.float32)
        self.contact, self.lift = round_contact(film, mesh_contact(film), self.step)

    def _angle_at(self, local: NDArray, wall: NDArray) -> NDArray:
        """Return the surface's angle [rad] at `local` [mm], on the wall or on the parabola."""
        slope = np.where(
            wall,
            self.film.groove.wall_slope * np.sign(local),
            self.film.curvature[self.groove] * local,
        )
        return np.arctan(slope)

    def middle_error(self) -> NDArray[np.float64]:
        """Return the angle [rad] between each facet and the surface at its middle."""
        wall = np.abs(self.middle) > self.contact[self.groove]
        return np.hypot(self.angle - self._angle_at(self.middle, wall), self.lean)

    def secant_error(self) -> NDArray[np.float64]:
        """Return the angle [rad] between each facet and the surface between its two ends."""
        place = self.film.groove_position[self.groove]
        rise = self._height(self.right - place) - self._height(self.left - place)
        return np.hypot(self.angle - np.arctan2(rise, self.right - self.left), self.lean)

    def secant(self) -> Secant:
        """Return the angles to the secants: of all, of the worst groove, and the largest."""
        secant = self.secant_error()
        square = secant**2 * self.area
        by_groove = np.bincount(self.groove, square, self.film.groove_count).astype(float)
        by_groove /= np.bincount(self.groove, self.area, self.film.groove_count)
        rms = float(np.sqrt(square.sum() / self.area.sum()))
        return Secant(rms, float(np.sqrt(by_groove.max())), float(secant.max()))

    def _height(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return z [mm] of each facet's half groove at `local` [mm] from its middle, (t, …).

        A wall without resin goes on beyond the middle: a groove made wider is deeper there.
        """
        film = self.film
        of_groove = (film.curvature, self.contact, self.lift)
        curvature, contact, lift, side = (
            part.reshape(-1, *[1] * (local.ndim - 1))
            for part in (*(part[self.groove] for part in of_groove), self.side)
        )
        drop = (film.groove.half_width - local) * (film.groove.half_width + local)
        wall = film.base + film.groove.wall_slope * side * local
        bare = (np.abs(local) > contact) | (contact == 0)
        return np.where(bare, wall, film.thickness + lift - curvature / 2 * drop)

    def end_error(self) -> float:
        """Return the largest angle [rad] between a facet and the surface at its ends."""
        contact = self.contact[self.groove]
        worst = 0.0
        for x in (self.left, self.right):
            local = x - self.film.groove_position[self.groove]
            # An end within three float32 steps of a kink belongs to the facet's own side of it.
            at_kink = np.abs(np.abs(local) - contact) <= 3 * self.step
            wall = np.where(at_kink, np.abs(self.middle), np.abs(local)) > contact
            at_valley = (contact == 0) & (np.abs(local) <= 2 * self.step)
            local = np.where(at_valley, self.middle * 1e-9, local)
            error = np.hypot(self.angle - self._angle_at(local, wall), self.lean)
            worst = max(worst, float(error.max()))
        return worst

    def rounding(self) -> float:
        """Return the angle [rad] by which float32 may turn a facet from the surface at its middle.

        One step in z over a facet.
        """
        rise = np.spacing(np.float32(self.film.thickness)) / np.median(self.right - self.left)
        return float(rise)

    def _local(self) -> NDArray[np.float64]:
        """Return the corners' x [mm] from the centre of the groove, (t, 3)."""
        place = self.film.groove_position[self.groove] + self.shift
        return self.corner[:, :, 0] - place[:, None]

    def height_error(self) -> float:
        """Return the largest distance [mm] in z between a corner and the surface."""
        return float(np.abs(self.corner[:, :, 2] - self._height(self._local())).max())

    def height_tolerance(self) -> float:
        """Return the distance [mm] in z that float32 forces.

        Two steps of z; and half a step of x down the wall where the last groove is empty, as its
        end is not rounded like other tips.
        """
        beside = self.film.groove.wall_slope * self.step / 2 if self.contact[-1] == 0 else 0.0
        return beside + 2 * float(np.spacing(np.float32(self.film.thickness)))

    def curvature(self) -> NDArray[np.float64]:
        """Return C [1/mm] of each groove by least squares over the corners above its walls.

        On the parabola, top + lift - z = C/2 (w² - x²). Without such corners it counts as empty.
        """
        film = self.film
        local = self._local()
        z = self.corner[:, :, 2]
        room = (film.groove.half_width - local) * (film.groove.half_width + local)
        if film.profile == "ideal":
            used = room > 0.01 * film.groove.half_width**2
        else:
            above = z - film.base - film.groove.wall_slope * np.abs(local)
            used = above > self.height_tolerance() * 2
        room = np.where(used, room, 0.0)
        groove = np.broadcast_to(self.groove[:, None], room.shape)
        top = film.thickness + self.lift[self.groove, None]
        empty = film.groove.curvature_empty
        return recover_curvature(groove, top - z, room, film.groove_count, empty)
