"""The film as files for CAD and for ray tracers, each checked again from the file.

`write_step` draws the prism film (`BEF`) and the resin (`fill`) as exact bodies; `write_stl` draws
both together as one closed mesh of facets within an angle of the surface. `check_step` and
`check_stl` read such a file back with other code than wrote it and raise `ExportError` when it is
not the film. Lengths are mm, x across the grooves, y along them, z up, one corner at the origin.
OCCT, trimesh and manifold3d are loaded only when used.
"""

from mpfcad.cad.step import write_step
from mpfcad.cad.step_check import StepCheck, check_step
from mpfcad.cad.stl import write_stl
from mpfcad.cad.stl_check import MeshCheck, check_stl

__all__ = ["MeshCheck", "StepCheck", "check_step", "check_stl", "write_step", "write_stl"]
