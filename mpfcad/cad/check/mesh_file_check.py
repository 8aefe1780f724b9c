"""Read 3MF and PLY files back with lib3mf and trimesh, and compare them with their film."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import refuse_above
from mpfcad.cad.check.threemf import read_model
from mpfcad.cad.shape.mesh import mesh_contact, mesh_sliver
from mpfcad.errors import ExportError
from mpfcad.film import PrismFilm
from mpfcad.gate import Gate

#: Largest error of a body's volume, as a share of the film's.
VOLUME_TOLERANCE = 1e-4
#: Largest distance [mm] between a corner and the film's surface: PLY holds doubles.
HEIGHT_TOLERANCE = 1e-12
#: Largest error of a normal's slope.
NORMAL_TOLERANCE = 1e-9
_NORMAL = ("nx", "ny", "nz")


@dataclass(frozen=True)
class BodyCheck:
    """What a mesh file was found to hold: volume [mm³] and number of facets by the body's name."""

    volume: dict[str, float]
    triangle_count: dict[str, int]
    #: None: what is not the film is refused when it is read.
    gates: ClassVar[tuple[Gate, ...]] = ()


def check_3mf(path: Path, film: PrismFilm) -> BodyCheck:
    """Return what the 3MF file at `path` holds, once it is found to be `film`.

    Raises
    ------
    ExportError
        when the unit is not mm, a body is missing or not closed, or a volume is off.
    """
    path = Path(path)
    return check_3mf_bodies(path, _body_volumes(film), film.volume)


def check_3mf_bodies(path: Path, expected: dict[str, float], whole: float) -> BodyCheck:
    """Return what a 3MF file holds, once it is found to be closed bodies of these volumes [mm³].

    `whole` is the film's volume [mm³], of which each may be off by `VOLUME_TOLERANCE`.

    Raises
    ------
    ExportError
        when the unit is not mm, a body is missing or not closed, or a volume is off.
    """
    model = read_model(path)
    bodies = _placed_meshes(path, model)
    if set(bodies) != set(expected):
        raise ExportError(f"{path.name}: bodies {sorted(bodies)}: expected {sorted(expected)}")
    volume, count = {}, {}
    for name, mesh in bodies.items():
        if not mesh.IsManifoldAndOriented():
            raise ExportError(f"{path.name}: {name}: not closed and oriented")
        points = np.array([tuple(p.Coordinates) for p in mesh.GetVertices()], np.float64)
        faces = np.array([tuple(t.Indices) for t in mesh.GetTriangleIndices()])
        count[name] = len(faces)
        volume[name] = body_volume(points, faces)
        check_volume(path, name, volume[name], expected[name], whole)
    return BodyCheck(volume, count)


def _placed_meshes(path: Path, model: Any) -> dict[str, Any]:
    """Return the mesh objects that the build's one assembly holds, each where it was drawn."""
    items = model.GetBuildItems()
    bodies = {}
    while items.MoveNext():
        assembly = items.GetCurrent().GetObjectResource()
        for index in range(assembly.GetComponentCount()):
            part = assembly.GetComponent(index)
            place = np.array([list(row) for row in part.GetTransform().Fields])
            if not np.array_equal(place, np.eye(4)[:, :3]):
                raise ExportError(f"{path.name}: component {index} is not in its place")
            bodies[part.GetObjectResource().GetName()] = model.GetMeshObjectByID(
                part.GetObjectResource().GetResourceID()
            )
    return bodies


def _body_volumes(film: PrismFilm) -> dict[str, float]:
    """Return the volume [mm³] that each body should have, by name."""
    if film.profile == "ideal":
        return {"film": film.volume}
    volumes = {"BEF": film.prism_volume}
    return {**volumes, "fill": film.fill_volume} if np.any(mesh_contact(film) > 0) else volumes


def check_ply(path: Path, film: PrismFilm) -> BodyCheck:
    """Return what the PLY file at `path` holds, once it is found to be `film`.

    Raises
    ------
    ExportError
        when it is not closed, off in volume, or its corners or normals are not the film's.
    """
    path = Path(path)
    merged, points, normals, count = read_closed_ply(path, film.volume, film.volume)
    top = normals[:, 2] > 0
    _check_corners(path, film, points[top], normals[top])
    return BodyCheck({"film": merged}, {"film": count})


def read_closed_ply(
    path: Path, expected: float, whole: float
) -> tuple[float, NDArray[np.float64], NDArray[np.float64], int]:
    """Return volume [mm³], corners (v, 3) [mm], normals (v, 3) and the number of facets of a PLY.

    Raises
    ------
    ExportError
        when it is not one closed surface of the expected volume [mm³] with unit normals.
    """
    import trimesh

    try:
        read = trimesh.load_mesh(path, process=False)
    except Exception as error:
        raise ExportError(f"{path.name}: trimesh cannot read this file: {error}") from error
    # trimesh makes normals of its own; those of the file are among its raw columns.
    column = read.metadata["_ply_raw"]["vertex"]["data"]
    points, normals = (
        np.stack([column[name] for name in names], 1) for names in (("x", "y", "z"), _NORMAL)
    )
    _, first, index = np.unique(points, axis=0, return_index=True, return_inverse=True)
    merged = trimesh.Trimesh(points[first], index.ravel()[read.faces], process=False)
    if not (merged.is_watertight and merged.is_winding_consistent):
        raise ExportError(f"{path.name}: not one closed surface")
    check_volume(path, "film", merged.volume, expected, whole)
    length = float(np.abs(np.linalg.norm(normals, axis=1) - 1).max())
    refuse_above(path, "length of a normal", length, 1e-12)
    return float(merged.volume), points, normals, len(read.faces)


def _check_corners(path: Path, film: PrismFilm, points: NDArray, normals: NDArray) -> None:
    """Refuse corners off the surface, and normals that are not the surface's."""
    off = float(np.abs(points[:, 2] - film.height(points[:, 0])).max())
    limit = HEIGHT_TOLERANCE + merged_height(film)
    refuse_above(path, "height error [mm]", off, limit)
    # Either neighbour's slope, for a corner on a kink.
    best = np.full(len(points), np.inf)
    for groove in (-1e-9, 1e-9):
        index = np.clip(
            ((points[:, 0] + groove) / film.groove.pitch).astype(int), 0, film.groove_count - 1
        )
        local = points[:, 0] - film.groove_position[index]
        slopes = [film.curvature[index] * local]
        slopes += [sign * film.groove.wall_slope * np.ones_like(local) for sign in (-1, 1)]
        for slope in slopes:
            best = np.minimum(best, np.abs(normals[:, 0] / normals[:, 2] + slope))
    refuse_above(path, "slope of a normal", float(best.max()), NORMAL_TOLERANCE)


def merged_height(film: PrismFilm) -> float:
    """Return how far [mm] merging parts narrower than a sliver moves the surface."""
    contact = film.groove.contact_position(film.curvature)
    merged = (contact != mesh_contact(film)) & (film.profile == "filled")
    return mesh_sliver(film) * film.groove.wall_slope if merged.any() else 0.0


def body_volume(points: NDArray[np.float64], faces: NDArray[np.int64]) -> float:
    """Return the volume [mm³] that facets (t, 3) of corners (v, 3) [mm] bound."""
    a, b, c = np.moveaxis((points - points.mean(axis=0))[faces], 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6)


def check_volume(path: Path, name: str, found: float, wanted: float, whole: float) -> None:
    """Refuse a body whose volume [mm³] is off by more than `VOLUME_TOLERANCE` of `whole`.

    Raises
    ------
    ExportError
        naming the body and both volumes.
    """
    error = abs(found - wanted) / whole
    if not error <= VOLUME_TOLERANCE:
        raise ExportError(f"{path.name}: {name}: volume {found:.6g} mm³: expected {wanted:.6g} mm³")
