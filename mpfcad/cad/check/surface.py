"""An STL file against the surface that it should be, whatever kind of film has it.

A kind of film states its `Surface`: size, volume, and how far facets are off. Everything else is
the same for all: one closed body, its extent, heights, normals, and C recovered by least squares.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import (
    MeshCheck,
    check_closed,
    extent_error,
    read_facets,
    select_top,
)
from mpfcad.gate import Gate, yes_no
from mpfcad.units import deg, um

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class Secant:
    """Angles [rad] between facets and the secants of the surface between their two ends.

    `rms` is over the area, `groove` that of the groove where it is largest (None where there are
    no grooves as designed), `largest` that of any facet.
    """

    rms: float
    groove: float | None
    largest: float


@dataclass(frozen=True, eq=False)
class FacetError:
    """How far the facets of a mesh's top are from a surface; lengths in mm, angles in rad.

    Attributes
    ----------
    height, height_limit
        largest distance in z of a corner from the surface at its place, and what float32 forces
    normal_rms, normal_rms_limit
        angle to the surface at the facets' middles, and what it may be; None: no limit
    normal, normal_limit
        angle to the surface at a facet's ends, of the facet that comes nearest to its limit
    curvature
        C [1/mm] recovered; None of a measured surface
    curvature_error
        largest error [1/mm] of C where the surface states it
    secant
        None where the surface bends in both directions
    tip
        largest distance of a tip from its place
    """

    height: float
    height_limit: float
    normal_rms: float
    normal_rms_limit: float | None
    normal: float
    normal_limit: float
    curvature: NDArray[np.float64] | None
    curvature_error: float | None = None
    secant: Secant | None = None
    tip: float = 0.0


class Surface(Protocol):
    """The surface of one kind of film, as its mesh should be."""

    #: Volume [mm³] of the body, and the largest relative error that a mesh may have.
    volume: float
    volume_limit: float

    def extent(self, top: float) -> tuple[Corner, Corner]:
        """Return the corners of the bounding box [mm]; `top` is the mesh's own greatest z."""

    def compare(self, top: NDArray[np.float64], angle_tolerance: float) -> FacetError:
        """Return how far the facets of the top, (t, 3, 3) float64 [mm], are off."""


class FilmBody(Protocol):
    """A film with one corner at the origin; lengths in mm."""

    @property
    def volume(self) -> float:
        """Volume [mm³]."""

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y."""

    @property
    def thickness(self) -> float:
        """Extent from the underside to the tips."""


Film = TypeVar("Film", bound=FilmBody)


class FilmSurface(Generic[Film]):
    """What the surfaces of films share: how a film is held, its volume and its extent."""

    def __init__(self, film: Film) -> None:
        self.film, self.volume = film, film.volume

    def extent(self, top: float) -> tuple[Corner, Corner]:
        """Return the corners of the bounding box [mm]; tips are sharp, so `top` says nothing."""
        return (0.0, 0.0, 0.0), (*self.film.size, self.film.thickness)


#: Largest error [1/mm] of a curvature recovered from the facets.
CURVATURE_LIMIT = 0.01


def check_mesh(path: Path, surface: Surface, angle_tolerance: float) -> MeshCheck:
    """Return what the STL file at `path` holds, measured against `surface`; its gates judge.

    Raises
    ------
    ExportError
        when the file is not one closed body facing outward, so that there is nothing to measure.
    """
    path = Path(path)
    corner, normal = read_facets(path)
    volume = check_closed(path, corner, normal)
    off = extent_error(corner, *surface.extent(float(corner[..., 2].max())))
    found = surface.compare(select_top(corner), angle_tolerance)
    volume_error = volume / surface.volume - 1
    secant = found.secant
    return MeshCheck(
        watertight=True,
        volume=volume,
        volume_error=volume_error,
        normal_error_rms=found.normal_rms,
        secant_error_rms=None if secant is None else secant.rms,
        secant_error_groove=None if secant is None else secant.groove,
        secant_error_max=None if secant is None else secant.largest,
        normal_error_max=found.normal,
        height_error_max=found.height,
        tip_error_max=found.tip,
        triangle_count=len(corner),
        curvature=found.curvature,
        gates=_gates(path.name, surface, abs(volume_error), off, found),
    )


def _gates(
    name: str, surface: Surface, volume_error: float, extent: float, found: FacetError
) -> tuple[Gate, ...]:
    """Return the gates of a mesh file `name`; every limit of one stands here or in the surface."""

    def at_most(figure: str, value: float | None, limit: float | None) -> list[Gate]:
        if value is None or limit is None:
            return []
        return [Gate(f"mesh_{figure}", float(value), float(limit), detail=name)]

    rms_limit = found.normal_rms_limit
    return (
        yes_no("mesh_watertight", True),
        *at_most("volume_error", volume_error, surface.volume_limit),
        *at_most("extent_error_um", extent / um, 0.0),
        *at_most("normal_error_deg", found.normal / deg, found.normal_limit / deg),
        *at_most("normal_error_deg_rms", found.normal_rms / deg, rms_limit and rms_limit / deg),
        *at_most("height_error_um", found.height / um, found.height_limit / um),
        *at_most("curvature_error_per_mm", found.curvature_error, CURVATURE_LIMIT),
    )


def recover_curvature(
    place: NDArray[np.int64],
    drop: NDArray[np.float64],
    room: NDArray[np.float64],
    count: int,
    empty: float,
) -> NDArray[np.float64]:
    """Return the least-squares C [1/mm] of each of `count` places, (count,) float64.

    On the parabola through the tips, drop = C/2 · room.

    Parameters
    ----------
    place
        (k,) int64, which place each corner above the walls belongs to
    drop
        (k,) float64 [mm], how far it lies below the tips
    room
        (k,) float64 [mm²], w² - x² at its distance x from the valley
    empty
        C [1/mm] of a place without such corners
    """
    above = np.bincount(place.ravel(), (drop * room).ravel(), count)
    below = np.bincount(place.ravel(), (room**2).ravel(), count)
    return np.divide(2 * above, below, out=np.full(count, empty), where=below > 0)
