"""Films that are on disk already: any mesh traced, an export verified."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.api.progress import watched
from mpfcad.api.result import Run, Trace

if TYPE_CHECKING:
    from mpfcad.pipeline import Progress


def trace(
    mesh: str | Path | None,
    stack: str = "thesis-32in-mpf",
    *,
    thickness_mm: float | None = None,
    offset_mm: float = 0.0,
    seed: int = 1,
    effort: str = "standard",
    threads: int | None = None,
    repair: bool = False,
    progress: "bool | Progress" = False,
) -> Trace:
    """Trace any closed film mesh in a backlight; figures only, no verdict.

    Parameters
    ----------
    mesh
        the film's file; None for a stack with a BSDF table in the film's place
    stack
        preset or stack file
    thickness_mm
        reflector to plate [mm] (None: the stack's own)
    offset_mm
        left edge of the mesh from a lamp's axis [mm]
    seed, effort, threads
        of the trace; figures do not depend on `threads`
    repair
        whether a mesh that is no solid is repaired into a file beside it

    Raises
    ------
    InputError
        when the mesh is no closed film, or the stack is wrong.
    """
    from mpfcad.pipeline import trace_mesh

    path = None if mesh is None else Path(mesh)
    with watched(progress) as told:
        found = trace_mesh(
            path,
            os.fspath(stack),
            thickness_mm,
            offset_mm,
            seed,
            effort,
            threads,
            told,
            None,
            repair,
        )
    return Trace(found)


def verify(
    folder: str | Path, *, threads: int | None = None, progress: "bool | Progress" = False
) -> Run:
    """Hash every file of an export, recompute every figure, compare bit for bit; return the run.

    Raises
    ------
    InputError
        when the folder is no export.
    ExportError
        naming the file that was changed, or the figure that differs.
    """
    from mpfcad.pipeline import verify_export

    with watched(progress) as told:
        return Run(verify_export(Path(folder), threads=threads, progress=told), Path(folder))
