"""The film as files for CAD and for ray tracers, each checked again from the file.

`write_step` draws the prism film (`BEF`) and the resin (`fill`) as exact bodies; `write_stl`,
`write_ply` and `write_3mf` draw closed meshes of facets within an angle of the surface. `check_…`
reads such a file back with another library than wrote it and raises `ExportError` when it is not
the film; `check_agreement` compares STEP and STL with each other. `section_*` do the same for any
cross-section of exact pieces (imperfect films, and moulds with `mould`, `turning` and `dxf`),
`cell_*` for films of cells, `field_*` for grooves whose curvature varies along them; `height` maps
the surface. Lengths are mm, x across the grooves, y along them, z up, one corner at the origin.
OCCT, trimesh, manifold3d and lib3mf are loaded only when used.
"""

from mpfcad.cad.check.agreement import Agreement, check_agreement
from mpfcad.cad.check.grooves import check_stl
from mpfcad.cad.check.mesh_check import MeshCheck
from mpfcad.cad.check.mesh_file_check import BodyCheck, check_3mf, check_ply
from mpfcad.cad.check.step.body import StepCheck, check_step
from mpfcad.cad.file.ply import write_ply
from mpfcad.cad.file.stl import write_stl
from mpfcad.cad.file.threemf import write_3mf
from mpfcad.cad.step.grooves import write_step

__all__ = [
    "Agreement",
    "BodyCheck",
    "MeshCheck",
    "StepCheck",
    "check_3mf",
    "check_agreement",
    "check_ply",
    "check_step",
    "check_stl",
    "write_3mf",
    "write_ply",
    "write_step",
    "write_stl",
]
