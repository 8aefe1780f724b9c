"""`repair_mesh`: a film mesh that bounds no solid, repaired into a file of its own."""

import os
from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.export import sha256
from mpfcad.pipeline.progress import Progress


def repair_mesh(path: Path, progress: Progress) -> tuple[Path, dict[str, Any] | None]:
    """Return the file to trace, and what was repaired; a sound mesh is its own, with None.

    The repaired mesh is written beside `path` as NAME-repaired.stl; `path` is never changed.

    Raises
    ------
    InputError
        when the mesh cannot be repaired, or something else has the repaired file's name.
    """
    from mpfcad.optics.solid.closed import find_fault
    from mpfcad.optics.solid.file import read_solid
    from mpfcad.optics.solid.mesh import film_of
    from mpfcad.optics.solid.repair import describe_repair, repair_solid
    from mpfcad.optics.solid.weld import weld

    solid = read_solid(path)
    vertex, facet = solid.vertex, solid.facet
    fault = find_fault(vertex, facet)
    if fault is None:
        progress.note(f"{path}: nothing to repair")
        return path, None
    repair = repair_solid(vertex, facet)
    # As float32 holds it: what is written is what is checked.
    vertex, facet = weld(repair.vertex[repair.facet].astype("<f4"))
    done = describe_repair(repair)
    left = find_fault(vertex, facet)
    if left:
        tried = f" (after {done})" if done else ""
        raise InputError(f"{path}: mesh: cannot be repaired: {left}{tried}")
    film_of(path, vertex, facet)
    out = path.with_name(f"{path.stem}-repaired.stl")
    _write(vertex, facet, out)
    progress.note(f"{path}: {fault.split(': ')[0]}; repaired into {out.name}: {done}")
    changes = {
        "merged_corners": repair.merged_corners,
        "dropped_facets": repair.dropped_facets,
        "turned_facets": repair.turned_facets,
        "filled_holes": repair.filled_holes,
        "united_bodies": repair.united_bodies,
        "volume_change_mm3": repair.volume_change,
    }
    return out, {"file": path.name, "sha256": sha256(path), "fault": fault, **changes}


def _write(vertex: Any, facet: Any, out: Path) -> None:
    """Write a mesh, unless its file is there and the same; never over something else."""
    from mpfcad.cad.file.stl import write_mesh
    from mpfcad.cad.shape.mesh import Mesh

    fresh = out.with_name(f".{out.stem}.{os.getpid()}.stl")
    try:
        write_mesh(Mesh(vertex, facet), fresh, "repaired")
        if out.exists() and out.read_bytes() != fresh.read_bytes():
            raise InputError(
                f"{out}: exists and is another mesh: expected no such file: move it away"
            )
        fresh.replace(out)
    finally:
        fresh.unlink(missing_ok=True)
