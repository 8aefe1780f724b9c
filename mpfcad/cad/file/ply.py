"""Write the film as a binary PLY file in mm: float64 coordinates and the surface's normals."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.shape.mesh import build_cross_section, build_mesh, mesh_contact
from mpfcad.cad.shape.section_mesh import build_outline, build_section_mesh
from mpfcad.film import PrismFilm, Section
from mpfcad.film.section import LINE

_FACE = np.dtype([("count", "u1"), ("corner", "<i4", 3)])


def write_ply(film: PrismFilm, path: Path, angle_tolerance: float, *, name: str = "film") -> None:
    """Write the film, prism and resin as one body, with facets within `angle_tolerance` [rad].

    A corner's normal is that of the surface, exact on a parabola; corners on a kink are written
    once for each side of it. Same film, same bytes.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    """
    _store(*_with_normals(film, angle_tolerance), Path(path), name)


def write_section_ply(
    section: Section, path: Path, angle_tolerance: float, *, name: str = "film"
) -> None:
    """Write the body of a cross-section, its corners as an STL has them, with normals as above.

    Raises
    ------
    InputError
        when float32 cannot hold so fine a mesh.
    """
    mesh = build_section_mesh(section, angle_tolerance)
    _, _, owner = build_outline(section, angle_tolerance)
    corner = mesh.vertices[mesh.triangles].astype(float)
    flat = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    normal = np.repeat(flat[:, None], 3, axis=1)
    # The first triangles are the top's, two a chord.
    piece = np.repeat(owner, 2)
    curved = np.flatnonzero(section.kind[piece] != LINE)
    on = np.repeat(piece[curved, None], 3, axis=1)
    stretch = section.width / float(mesh.vertices[:, 0].max())
    slope = section.slope_on(on, corner[curved, :, 0] * stretch)
    tilt = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=2)
    normal[curved] = tilt / np.linalg.norm(tilt, axis=2, keepdims=True)
    # Facets of one piece share corners; so do those of each of the other strips, and of the caps.
    face = np.arange(len(corner)) // 2 + section.piece_count
    face[curved] = piece[curved]
    caps = np.abs(flat[:, 1]) > 0.5
    face[caps] = len(corner) + section.piece_count + (flat[caps, 1] > 0)
    key = mesh.triangles * (face.max() + 1) + face[:, None]
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    vertex = np.concatenate([corner.reshape(-1, 3), normal.reshape(-1, 3) + 0.0], axis=1)[first]
    _store(vertex, index.reshape(-1, 3), Path(path), name)


def _store(
    vertex: NDArray[np.float64], triangles: NDArray[np.int64], path: Path, name: str
) -> None:
    """Write corners x, y, z, nx, ny, nz, (v, 6), and triangles (t, 3)."""
    label = name.encode("ascii", "replace").decode()
    columns = "".join(f"property double {column}\n" for column in ("x", "y", "z", "nx", "ny", "nz"))
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment mpfcad, unit mm, {label}\n"
        f"element vertex {len(vertex)}\n{columns}element face {len(triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), _FACE)
    faces["count"] = 3
    faces["corner"] = triangles
    part = path.with_name("." + path.name + ".part")
    try:
        with part.open("wb") as file:
            file.write(header.encode())
            vertex.astype("<f8").tofile(file)
            faces.tofile(file)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _with_normals(
    film: PrismFilm, angle_tolerance: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the corners x, y, z, nx, ny, nz, (v, 6), and the triangles (t, 3)."""
    mesh = build_mesh(film, angle_tolerance, np.float64)
    section = build_cross_section(film, angle_tolerance, np.float64)
    corner = mesh.vertices[mesh.triangles]
    flat = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    normal = np.repeat(flat[:, None], 3, axis=1)

    # The first triangles are the top's, two a piece of the polyline; then sides, underside, caps.
    top = 2 * (len(section.x) - 1)
    piece = np.arange(len(corner)) // 2
    groove = np.repeat(np.arange(film.groove_count), np.diff(section.tip))[piece[:top]]
    local = corner[:top, :, 0] - film.groove_position[groove][:, None]
    middle = np.abs(local.min(axis=1) + local.max(axis=1)) / 2
    curved = np.flatnonzero(middle < mesh_contact(film)[groove])
    slope = film.curvature[groove[curved]][:, None] * local[curved]
    tilt = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=2)
    normal[curved] = tilt / np.linalg.norm(tilt, axis=2, keepdims=True)

    # Facets of one smooth face share corners: those of a parabola, a straight strip, a cap.
    face = piece + film.groove_count
    face[curved] = groove[curved]
    caps = np.abs(flat[:, 1]) > 0.5
    face[caps] = len(corner) + film.groove_count + (flat[caps, 1] > 0)
    key = mesh.triangles * (face.max() + 1) + face[:, None]
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    vertex = np.concatenate([corner.reshape(-1, 3), normal.reshape(-1, 3) + 0.0], axis=1)[first]
    return vertex, index.reshape(-1, 3)
