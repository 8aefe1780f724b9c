"""A window of a film of pieces as one closed mesh, STL: the pieces united by manifold3d."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import refuse_above
from mpfcad.cad.check.mesh_file_check import BodyCheck
from mpfcad.cad.file.library import used_meshes
from mpfcad.cad.file.stl import write_mesh
from mpfcad.cad.shape.mesh import Mesh
from mpfcad.errors import ExportError, InputError
from mpfcad.film import CellLibrary, PieceLibrary

#: Most facets of all pieces in a window, and the largest relative error of its volume.
MOST_FACETS, VOLUME_LIMIT = 4_000_000, 1e-3
#: How near [mm] corners are one, or lie on a piece's side.
_SIDE = 1e-7


def write_window(
    library: PieceLibrary | CellLibrary, path: Path, angle_tolerance: float, name: str
) -> None:
    """Write the pieces as one solid: steps between them are walls, no face lies inside.

    Raises
    ------
    InputError
        when there are too many facets.
    """
    from manifold3d import Manifold, Mesh64, OpType

    held: dict[int, tuple[NDArray[np.float64], NDArray[np.uint64]]] = {}
    facets, (pitch, length) = 0, (library.groove.pitch, library.length)
    for number, _, mesh in used_meshes(library, angle_tolerance):
        facets += len(mesh.triangles) * int((library.chosen == number).sum())
        if facets > MOST_FACETS:
            raise InputError(
                f"{path.name}: a window of {library.size[0]:g} × {library.size[1]:g} mm: over "
                f"{MOST_FACETS / 1e6:g} million facets: expected a smaller cad.width_mm, length_mm"
            )
        vertices = np.asarray(mesh.vertices, float)
        for axis, size in ((0, pitch), (1, length)):
            vertices[np.abs(vertices[:, axis] - size) < _SIDE, axis] = size
        held[number] = vertices, np.asarray(mesh.triangles, np.uint64)
    placed = []
    for (i, k), kind in np.ndenumerate(library.chosen):
        vertices, triangles = held[int(kind)]
        # As STL holds them, so that neighbours touch exactly.
        moved = (vertices + np.array([i * pitch, k * length, 0.0])).astype(np.float32)
        placed.append(Manifold(Mesh64(moved.astype(float), triangles)))
    near = max(_SIDE, 4 * float(np.spacing(np.float32(max(library.size)))))
    united = Manifold.batch_boolean(placed, OpType.Add).simplify(near).to_mesh64()
    # Corners that float32 makes one take their facets of no width with them.
    point = np.asarray(united.vert_properties)[:, :3].astype(np.float32)
    point, index = np.unique(point, axis=0, return_inverse=True)
    facet = index.reshape(-1)[np.asarray(united.tri_verts, np.int64)]
    whole = (facet != np.roll(facet, 1, axis=1)).all(axis=1)
    write_mesh(Mesh(point, facet[whole]), path, name)


def check_window(path: Path, library: PieceLibrary | CellLibrary) -> BodyCheck:
    """Return what the STL holds, once it is found to be one closed solid of the pieces' volume.

    Raises
    ------
    ExportError
        when it is not.
    """
    import trimesh

    path = Path(path)
    # As it is written: trimesh would join corners that lie near each other.
    mesh = trimesh.load(path, file_type="stl", process=False)
    corner = np.asarray(mesh.triangles, float).reshape(-1, 3)
    point, number = np.unique(corner, axis=0, return_inverse=True)
    facet = number.reshape(-1, 3)
    ahead = np.roll(facet, -1, axis=1)
    edge, back = (
        np.sort((a * len(point) + b).ravel()) for a, b in ((facet, ahead), (ahead, facet))
    )
    if not np.array_equal(edge, back) or (np.diff(edge) == 0).any():
        raise ExportError(f"{path.name}: not closed and oriented")
    volumes = np.array([library.piece(n).volume for n in range(len(library.curvature))])
    wanted = float(volumes[library.chosen].sum())
    found = float(mesh.volume)
    refuse_above(path, "volume error", abs(found / wanted - 1), VOLUME_LIMIT)
    size = np.array([*library.size, library.base + library.groove.depth])
    off = float(np.abs(np.asarray(mesh.extents) - size).max())
    refuse_above(path, "extent [mm]", off, 4 * float(np.spacing(np.float32(size.max()))))
    return BodyCheck({"film": found}, {"film": len(mesh.faces)})
