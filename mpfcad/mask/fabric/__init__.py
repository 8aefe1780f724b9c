"""The screen's woven fabric: what a mesh is, the catalogue, and the names of the trade."""

from mpfcad.mask.fabric.catalogue import (
    coarsest_mesh,
    find_mesh,
    read_catalogue,
    shipped_catalogue,
)
from mpfcad.mask.fabric.mesh import Mesh, build_mesh

__all__ = [
    "Mesh",
    "build_mesh",
    "coarsest_mesh",
    "find_mesh",
    "read_catalogue",
    "shipped_catalogue",
]
