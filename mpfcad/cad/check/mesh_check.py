"""Read any STL file: facets, that they bound one closed body, and what they hold."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError
from mpfcad.gate import Gate


@dataclass(frozen=True, eq=False)
class MeshCheck:
    """What an STL file was found to hold.

    Attributes
    ----------
    watertight
        every edge is shared by exactly two facets of opposite sense, and they bound one body
    volume
        enclosed [mm³]
    volume_error
        its relative error
    normal_error_rms
        rms angle [rad] between a facet and the film's surface at the facet's middle, where the
        tangent of a parabola is parallel to its chord: the error of rounding alone
    normal_error_max
        angle [rad] between a facet and the film's surface at the facet's two ends, of the facet
        that comes nearest to its limit
    height_error_max
        largest distance [mm] in z between a corner and the film's surface at its x
    triangle_count
        number of facets
    curvature
        (n,) float64 [1/mm], C of each groove by least squares over its corners above the walls (of
        cells: one value; of grooves that change along: (n, k) at k places); None of a measured
        surface
    gates
        each figure against its limit
    secant_error_rms
        rms angle [rad], over the area, between a facet and the secant of the film's surface between
        its two ends; None where the surface bends in both directions
    secant_error_groove
        the same of the groove where it is largest; None of measured surfaces and of cells
    secant_error_max
        the largest of the angles that `secant_error_rms` is of; None where that is
    tip_error_max
        largest distance [mm] of a tip from its place, with its half grooves beside it; 0 where
        corners are compared in place
    """

    watertight: bool
    volume: float
    volume_error: float
    normal_error_rms: float
    normal_error_max: float
    height_error_max: float
    triangle_count: int
    curvature: NDArray[np.float64] | None
    gates: tuple[Gate, ...]
    secant_error_rms: float | None = None
    secant_error_groove: float | None = None
    secant_error_max: float | None = None
    tip_error_max: float = 0.0


def refuse_above(path: Path, what: str, value: float, limit: float) -> None:
    """Raise ExportError unless `value` is at most `limit`."""
    # Written so that NaN fails.
    if not value <= limit:
        raise ExportError(f"{path.name}: {what}: {value:.3g}: expected at most {limit:.3g}")


def read_facets(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners (t, 3, 3) and the stored normals (t, 3) of the facets."""
    from trimesh.exchange.stl import load_stl_binary

    try:
        with path.open("rb") as file:
            read = load_stl_binary(file)
    except Exception as error:
        raise ExportError(f"{path.name}: not a binary STL file: {error}") from error
    corner = np.asarray(read["vertices"], np.float64)[np.asarray(read["faces"])]
    if len(corner) == 0 or not np.isfinite(corner).all():
        raise ExportError(f"{path.name}: no facets, or coordinates that are not finite")
    return corner, np.asarray(read["face_normals"], np.float64)


def check_closed(path: Path, corner: NDArray, normal: NDArray) -> float:
    """Return the volume [mm³], once the facets bound one closed body and face outward."""
    import manifold3d
    import trimesh

    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(area, axis=1)
    if not np.all(size > 0):
        raise ExportError(f"{path.name}: facet {int(np.argmin(size))} has no area")
    misfit = np.linalg.norm(area / size[:, None] - normal, axis=1)
    refuse_above(path, "stored normal against the corners", float(misfit.max()), 1e-5)

    points, faces = join_corners(corner)
    mesh = trimesh.Trimesh(points, faces, process=False)
    if not (mesh.is_watertight and mesh.is_winding_consistent):
        raise ExportError(f"{path.name}: not one closed surface: some edges have no pair")
    if mesh.volume <= 0:
        raise ExportError(f"{path.name}: the facets face inward")
    body = manifold3d.Manifold(
        manifold3d.Mesh64(np.ascontiguousarray(points), faces.astype(np.uint64))
    )
    if body.status() != manifold3d.Error.NoError or body.genus() != 0:
        raise ExportError(f"{path.name}: not one simple solid: {body.status()}")
    if len(body.decompose()) != 1:
        raise ExportError(f"{path.name}: more than one body")
    refuse_above(
        path, "trimesh against manifold3d volume", abs(body.volume() / mesh.volume - 1), 1e-6
    )
    return float(mesh.volume)


def join_corners(corner: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the distinct corners (v, 3) and the facets (t, 3) as indices of them.

    Only corners of the same bits are one; the three float32 are packed, two at a time, into keys.
    """
    points = np.ascontiguousarray(corner.reshape(-1, 3))
    bits = (points + 0.0).astype(np.float32).view(np.uint32).astype(np.uint64)
    half = np.uint64(32)
    _, key = np.unique(bits[:, 0] << half | bits[:, 2], return_inverse=True)
    key = key.astype(np.uint64) << half | bits[:, 1]
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    return points[first], index.reshape(-1, 3)


def extent_error(
    corner: NDArray[np.float64],
    low: tuple[float, float, float],
    high: tuple[float, float, float],
) -> float:
    """Return how far [mm] facets are from reaching from `low` to `high` [mm], both in float32."""
    found = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    wanted = np.array(low, np.float32), np.array(high, np.float32)
    return max(float(np.abs(a - b).max()) for a, b in zip(found, wanted, strict=True))


def select_top(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the facets, (s, 3, 3), that are neither in the underside nor in the four sides."""
    low, high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    flat = np.zeros(len(corner), bool)
    for axis, level in ((0, low[0]), (0, high[0]), (1, low[1]), (1, high[1]), (2, low[2])):
        flat |= np.all(corner[:, :, axis] == level, axis=1)
    return corner[~flat]


def facet_area(facet: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return twice the area of facets (t, 3, 3) as vectors along their normals, (t, 3) [mm²]."""
    return np.cross(facet[:, 1] - facet[:, 0], facet[:, 2] - facet[:, 0])


def narrowest_side(facet: NDArray[np.float64], area: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the least height [mm] of facets of these areas: rounding turns a facet over it."""
    edge = np.linalg.norm(facet - np.roll(facet, 1, axis=1), axis=2)
    return np.linalg.norm(area, axis=1) / edge.max(axis=1)


def angle_to_surface(
    across: NDArray[np.float64], along: NDArray[np.float64], area: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the angle [rad] between facets and a surface of the slopes dz/dx, dz/dy, (t,)."""
    surface = np.stack([-across, -along, np.ones(len(area))], axis=1)
    sine = np.linalg.norm(np.cross(surface, area), axis=1)
    return np.arctan2(sine, np.sum(surface * area, axis=1))
