"""Compare the mesh of a film whose curvature varies along its grooves with its closed form."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import (
    MeshCheck,
    angle_to_surface,
    facet_area,
    narrowest_side,
)
from mpfcad.cad.check.surface import FacetError, FilmSurface, check_mesh, recover_curvature
from mpfcad.cad.shape.field_mesh import mesh_contact, mesh_sliver
from mpfcad.film import FieldPiece

#: Largest relative error of the volume of a mesh (5° facets: 3e-4).
VOLUME_LIMIT = 1e-3
#: Facets examined at a time.
BLOCK = 1 << 18


def check_field_stl(path: Path, film: FieldPiece, angle_tolerance: float) -> MeshCheck:
    """Return what the STL file at `path` holds, measured against the film; its gates judge.

    A facet's normal may be off the surface's at one of its corners by `angle_tolerance` [rad] and
    what float32 forces.

    Raises
    ------
    ExportError
        when it is not one closed body facing outward.
    """
    return check_mesh(path, FieldSurface(film), angle_tolerance)


class FieldSurface(FilmSurface[FieldPiece]):
    """Grooves whose curvature varies along them."""

    volume_limit = VOLUME_LIMIT

    def compare(self, top: NDArray[np.float64], angle_tolerance: float) -> FacetError:
        """Return how far the facets of the top are off."""
        film, facet = self.film, top
        step = float(np.spacing(np.float32(film.size[0])))
        blocks = range(0, len(facet), BLOCK)
        found = [_examine(film, facet[k : k + BLOCK], angle_tolerance, step) for k in blocks]
        worst = max(found, key=lambda part: part.angle / part.allowed)
        return FacetError(
            height=max(part.height for part in found),
            height_limit=(1 + film.steepest) * 2 * step,
            normal_rms=float(np.sqrt(sum(part.squares for part in found) / len(facet))),
            normal_rms_limit=None,
            normal=worst.angle,
            normal_limit=worst.allowed,
            curvature=recover_field(film, facet),
        )


class _Found(NamedTuple):
    """What was found of some facets; angle and allowed are of the one nearest to its limit."""

    height: float
    squares: float
    angle: float
    allowed: float


def _examine(
    film: FieldPiece, facet: NDArray[np.float64], angle_tolerance: float, step: float
) -> _Found:
    """Return the largest error of height [mm] and the angles [rad] of facets, (t, 3, 3)."""
    height = float(np.abs(facet[..., 2] - _mesh_height(film, facet)).max())
    area = facet_area(facet)
    middle, corners = _angles(film, facet, area, step)
    allowed = angle_tolerance + step * (1 + film.steepest) / narrowest_side(facet, area)
    worst = int(np.argmax(corners / allowed))
    squares = float(np.sum(middle**2))
    return _Found(height, squares, float(corners[worst]), float(allowed[worst]))


def _mesh_height(film: FieldPiece, place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the height [mm] of the surface that is meshed at places (…, 3): slivers are bare."""
    x, y = place[..., 0], place[..., 1]
    groove, local = film.local(x)
    bare = mesh_contact(film, film.curvature_at(groove, y)) == 0
    wall = film.base + film.groove.wall_slope * np.abs(local)
    return np.where(bare, wall, film.height(x, y))


def _angles(
    film: FieldPiece, facet: NDArray[np.float64], area: NDArray[np.float64], step: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the angle [rad] between each facet and the surface, (t,): at its middle; at a corner.

    A facet is of the parabola or of a wall by its middle; one with its middle within a sliver or
    four float32 steps of the contact line, or beyond one so near to the tip, is of whichever it
    fits better.
    """
    middle = facet.mean(axis=1)
    groove, local = film.local(middle[:, 0])
    contact = film.contact(film.curvature_at(groove, middle[:, 1]))
    room = np.maximum(4 * step, mesh_sliver(film))
    outside = np.abs(local) - contact
    places = np.concatenate([middle[:, None], facet], axis=1)
    centre = film.groove_position[groove]
    curved, wall = (np.empty(places.shape[:2]) for _ in "ab")
    for index in range(places.shape[1]):
        x, y = places[:, index, 0] - centre, places[:, index, 1]
        slope, along = _parabola_slope(film, groove, x, y, middle[:, 1])
        curved[:, index] = angle_to_surface(slope, along, area)
        wall[:, index] = angle_to_surface(film.groove.wall_slope * np.sign(local), 0.0 * x, area)
    either = np.minimum(curved, wall)
    bare = film.groove.half_width - contact > 2 * mesh_sliver(film)
    is_wall = (bare & (outside > room))[:, None] & (film.profile == "filled")
    is_curved = (outside < -room)[:, None] | (film.profile == "ideal")
    off = np.where(is_wall, wall, np.where(is_curved, curved, either))
    return off[:, 0], off[:, 1:].max(axis=1)


def _parabola_slope(
    film: FieldPiece,
    groove: NDArray[np.int64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    middle: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (dz/dx, dz/dy) of the parabola at x from the centre: C x and -C'/2 (w² - x²).

    C' jumps at the nodes: it is that at `middle`, the y of the facet's middle.
    """
    index = np.clip(np.searchsorted(film.along, middle, side="right") - 1, 0, len(film.along) - 2)
    change = film.curvature[groove, index + 1] - film.curvature[groove, index]
    rate = change / np.diff(film.along)[index]
    w = film.groove.half_width
    return film.curvature_at(groove, y) * x, -rate / 2 * (w - x) * (w + x)


def recover_field(film: FieldPiece, facet: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return C [1/mm] from the facets' corners, (n, k), as `FieldPiece.curvature` has it.

    At each station the least-squares C of a groove's corners above its walls, thickness - z =
    C/2 (w² - x²), and linear between; a station without such corners counts as empty.
    """
    point = facet.reshape(-1, 3)
    groove, local = film.local(point[:, 0])
    room = (film.groove.half_width - local) * (film.groove.half_width + local)
    drop = film.thickness - point[:, 2]
    station, number = np.unique(point[:, 1], return_inverse=True)
    used = room > film.groove.half_width**2 / 16
    if film.profile == "filled":
        wall = film.base + film.groove.wall_slope * np.abs(local)
        used &= point[:, 2] - wall > 4 * film.groove.wall_slope * np.spacing(
            np.float32(film.size[0])
        )
    place = groove[used] * len(station) + number[used]
    size = film.groove_count * len(station)
    empty = film.groove.curvature_empty
    found = recover_curvature(place, drop[used], room[used], size, empty)
    found = found.reshape(film.groove_count, -1)
    return np.stack([np.interp(film.along, station, row) for row in found])


def curvature_difference(film: FieldPiece, found: NDArray[np.float64]) -> float:
    """Return the largest |C of the map - C in the mesh| [1/mm]; slivers are meshed as empty."""
    merged = mesh_contact(film, film.curvature) == 0
    wanted = np.where(merged, film.groove.curvature_empty, film.curvature)
    return float(np.abs(wanted - found).max())
