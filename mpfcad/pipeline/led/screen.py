"""Whether a screen prints the films of a design: the best mesh and solids, and its margin."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import check_printable
from mpfcad.job import Job, build_job
from mpfcad.job.led_design import LedDesign
from mpfcad.mask.fabric import Mesh
from mpfcad.pipeline.plan.printed.propose import with_angle
from mpfcad.pipeline.plan.printed.screen import catalogue_of, screen_mesh, with_own_catalogue
from mpfcad.pipeline.plan.printed.trial import Proposal, best_row, rank, trial_process
from mpfcad.units import um

#: Solids fractions that are tried: resin diluted up to fifty times.
SOLIDS = (
    0.02, 0.025, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.125, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.65,
    0.8, 1.0,
)  # fmt: skip
#: Curvatures between the least and the most of the films at which a screen is asked.
_ASKED = 33


def find_screen(
    design: LedDesign, design_file: Path, tables: dict[str, Any], used: NDArray[np.float64]
) -> Proposal | None:
    """Return the best screen for films of the curvatures `used` [1/mm]; None where none is.

    `tables` is the document of the design's job. The design's own mesh is asked alone, or else
    all of the catalogue; its own solids fraction, or else, with limits in `[constraint]` or without
    a mesh, those of `SOLIDS` within them. A margin below 1 says that it does not print them.
    """
    job = with_own_catalogue(build_job(tables, str(design_file)), design_file)
    table, groove = job.mask.mesh, job.film.groove
    named = table is not None and not table.is_auto
    meshes: Sequence[Mesh] = catalogue_of(job, design_file)
    if table is not None and named:
        meshes = [screen_mesh(table, str(design_file))]
    asked = np.linspace(float(used.min()), float(used.max()), _ASKED)
    best: Proposal | None = None
    for mesh in meshes:
        for solids in _solids(design, job, named):
            try:
                trial, process = trial_process(job, design_file, mesh, solids, groove)
                check_printable(process, asked, str(design_file))
                row = best_row(trial, mesh, process, groove, asked, str(design_file))
            except InputError:
                continue  # such a screen does not hold these films
            if row is not None and (best is None or rank(row) > rank(best)):
                best = row
    return None if best is None else with_angle(job, best, groove)


def _solids(design: LedDesign, job: Job, named: bool) -> list[float]:
    limit = design.constraint
    stated = limit.solids_fraction_min is not None or limit.solids_fraction_max is not None
    if named and not stated:
        return [job.process.solids_fraction]
    low, high = limit.solids_fraction_min or 0.0, limit.solids_fraction_max or 1.0
    return [low, high] if low == high else [s for s in SOLIDS if low <= s <= high] or [low, high]


def printed_tables(
    design: LedDesign, tables: dict[str, Any], best: Proposal | None
) -> dict[str, Any]:
    """Return a job's document with the screen, where the design leaves its solids open."""
    limit = design.constraint
    if best is None or (limit.solids_fraction_min is None and limit.solids_fraction_max is None):
        return tables
    mask = {**tables.get("mask", {}), "period_um": round(best.period / um, 6)}
    own = mask.get("mesh", {"name": "auto"})
    if own == "auto" or own.get("name") == "auto":
        own = {"name": best.mesh.name}
    mask |= {"mesh": own, "pattern": best.pattern}
    process = {**tables.get("process", {}), "solids_fraction": best.solids_fraction}
    return {**tables, "mask": mask, "process": process}


def describe_screen(design: LedDesign, best: Proposal | None) -> dict[str, Any]:
    """Return whether a screen prints the films, and which, in outside names."""
    if not design.is_printed:
        return {"prints": False, "words": "no print makes such a film: it is for a mould"}
    if best is None:
        return {"prints": False, "words": "no mesh and solids fraction holds these fills"}
    prints = best.margin >= 1
    words = "a screen prints these films" if prints else "no screen prints these films safely"
    return {"prints": prints, "words": f"{words}: {best.reason()}", "best": best.document()}
