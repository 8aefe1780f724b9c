"""Read 3MF and PLY files of a cross-section's body back, and compare them with the section."""

from pathlib import Path

import numpy as np

from mpfcad.cad.check.mesh_check import refuse_above
from mpfcad.cad.check.mesh_file_check import BodyCheck, check_3mf_bodies, read_closed_ply
from mpfcad.film import Section

#: Of a corner from the surface [mm]: float32 in z, and a step in x at the steepest wall.
HEIGHT_STEPS = 4


def check_section_3mf(path: Path, section: Section) -> BodyCheck:
    """Return what the 3MF file at `path` holds, once it is found to be the section's body.

    Raises
    ------
    ExportError
        when the unit is not mm, the body is not closed, or its volume is off.
    """
    return check_3mf_bodies(Path(path), {"film": section.volume}, section.volume)


def check_section_ply(path: Path, section: Section) -> BodyCheck:
    """Return what the PLY file at `path` holds, once it is found to be the section's body.

    Raises
    ------
    ExportError
        when it is not closed, off in volume, or its corners are not on the surface.
    """
    path = Path(path)
    volume, points, normals, count = read_closed_ply(path, section.volume, section.volume)
    top = normals[:, 2] > 0
    x, z = points[top, 0] * section.width / points[:, 0].max(), points[top, 2]
    piece = section.piece_of(x)
    # At a kink the corner may lie on the piece to its left.
    near = [np.clip(piece + k, 0, section.piece_count - 1) for k in (-1, 0, 1)]
    off = np.min([np.abs(section.height_on(p, x) - z) for p in near], axis=0)
    step = float(np.spacing(np.float32(max(section.width, points[:, 2].max()))))
    refuse_above(path, "height error [mm]", float(off.max()), HEIGHT_STEPS * step)
    return BodyCheck({"film": volume}, {"film": count})
