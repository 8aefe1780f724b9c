"""Write the film as a binary STL file in mm."""

from pathlib import Path

import numpy as np

from mpfcad.cad.shape.mesh import Mesh, build_mesh
from mpfcad.film import PrismFilm

#: One facet of a binary STL file, 50 bytes.
FACET = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])

#: Facets made at a time: they stay in the processor's cache.
CHUNK = 16_384


def write_stl(film: PrismFilm, path: Path, angle_tolerance: float, *, name: str = "film") -> None:
    """Write the film, prism and resin as one body, with facets within `angle_tolerance` [rad].

    The 80-byte header names the film and the unit. Same film, same bytes.

    Raises
    ------
    InputError
        when the film cannot be drawn, or float32 cannot hold so fine a mesh.
    """
    write_mesh(build_mesh(film, angle_tolerance), path, name)


def write_mesh(mesh: Mesh, path: Path, name: str) -> None:
    """Write a closed mesh in mm; the 80-byte header names it and the unit."""
    path = Path(path)
    facets = _facets(mesh)
    label = name.encode("ascii", "replace")[:40].decode()
    header = f"mpfcad binary STL, unit mm, {label}".encode().ljust(80)
    part = path.with_name("." + path.name + ".part")
    try:
        with part.open("wb") as file:
            file.write(header)
            file.write(np.uint32(len(facets)).astype("<u4").tobytes())
            facets.tofile(file)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _facets(mesh: Mesh) -> np.ndarray:
    """Return the mesh as (t,) facets, normals taken from the rounded corners."""
    facets = np.zeros(len(mesh.triangles), FACET)
    for first in range(0, len(facets), CHUNK):
        part = slice(first, first + CHUNK)
        corner = mesh.vertices[mesh.triangles[part]]
        facets["corner"][part] = corner
        a, b, c = np.moveaxis(facets["corner"][part].astype(np.float64), (1, 2), (0, 1))
        (px, py, pz), (qx, qy, qz) = b - a, c - a
        normal = np.stack([py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx], axis=1)
        # "+ 0.0" turns -0 into 0; a facet without area has no normal, which is written as 0.
        size = np.sqrt(np.einsum("ij,ij->i", normal, normal))
        size[size == 0] = 1.0
        facets["normal"][part] = normal / size[:, None] + 0.0
    return facets
