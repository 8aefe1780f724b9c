"""Meshes that a stack needs besides the film's: its other films, and the prisms under the resin."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from mpfcad.backlight import PRISM_FILE, stack_file
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import Progress


def write_stack_meshes(plan: Plan, folder: Path, progress: Progress) -> None:
    """Copy the other films' meshes into the export, and write the film without resin if needed."""
    from mpfcad.cad import write_stl

    for name, path in plan.stack.files().items():
        progress.stage(f"copying {path.name}")
        shutil.copyfile(path, folder / stack_file(name))
    if not plan.stack.needs_prism:
        return
    progress.stage(f"writing {PRISM_FILE}")
    count, groove = plan.piece.groove_count, plan.piece.groove
    empty = replace(plan.piece, curvature=np.full(count, groove.curvature_empty))
    write_stl(empty, folder / PRISM_FILE, plan.job.cad.angle_tolerance, name="prisms")
