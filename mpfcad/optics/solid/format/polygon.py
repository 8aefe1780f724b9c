"""OBJ and PLY, read by trimesh."""

import io
from pathlib import Path

import numpy as np

from mpfcad.errors import InputError
from mpfcad.optics.solid.format.body import Body, MeshFile


def read_polygons(path: Path, data: bytes, form: str) -> MeshFile:
    """Return the body of an OBJ or PLY file; their coordinates have no unit and are taken as mm.

    Raises
    ------
    InputError
        when trimesh cannot read it, or it holds no facets.
    """
    import trimesh

    try:
        mesh = trimesh.load_mesh(io.BytesIO(data), file_type=form, process=False)
        corner = np.asarray(mesh.triangles, float)
    # Whatever a reader of other people's files raises, the file is what is wrong.
    except Exception as error:
        reason = f": {str(error).splitlines()[0][:120]}" if isinstance(error, ValueError) else ""
        raise InputError(
            f"{path}: not a readable {form.upper()}{reason}: expected vertices, and facets of them"
        ) from None
    if corner.ndim != 3 or len(corner) < 4:
        raise InputError(f"{path}: mesh: {len(corner)} facets: expected 4 or more")
    return MeshFile(f"{form.upper()}, taken as mm", (Body(form, corner),))
