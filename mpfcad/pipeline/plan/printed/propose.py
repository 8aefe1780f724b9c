"""The screen as a design variable: mesh, period, solids and angle that print a map, in a table.

Every mesh of the catalogue is tried with every solids fraction. The period is the shortest whose
slots and webs are cells of the mesh with a little to spare. A screen's *margin* is the least of its
figures over their limits: 1 is just printable, and the largest margin is the best screen.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from mpfcad.errors import InputError
from mpfcad.film import Groove, check_printable
from mpfcad.job import Job
from mpfcad.mask.rule import MaskRules
from mpfcad.mask.screen.moire import MoireSetting, worst_contrast
from mpfcad.pipeline.plan.printed.nearest import Asked, refuse_map
from mpfcad.pipeline.plan.printed.paste import dilution
from mpfcad.pipeline.plan.printed.screen import catalogue_of
from mpfcad.pipeline.plan.printed.trial import (
    FIRST_ANGLE,
    SOLIDS,
    Proposal,
    best_row,
    rank,
    trial_process,
    try_screen,
)
from mpfcad.units import deg, um

#: Angles of the mesh to the grooves [°] that are tried; rows of the table.
ANGLES, MOST_ROWS = (FIRST_ANGLE, 7.5, 15.0, 30.0, 37.5), 12


def propose(job: Job, job_file: Path, asked: Asked, groove: Groove) -> list[Proposal]:
    """Return screens for grooves of the asked curvatures, best first, one a mesh.

    Raises
    ------
    InputError
        when a file is wrong; when no mesh prints the map, naming the grooves and the nearest map.
    """
    found: list[Proposal] = []
    meshes = catalogue_of(job, job_file)
    for mesh in meshes:
        best: Proposal | None = None
        for solids in SOLIDS:
            try:
                trial, process = trial_process(job, job_file, mesh, solids, groove)
                check_printable(process, asked.curvature, str(job_file))
                row = best_row(trial, mesh, process, groove, asked.curvature, str(job_file))
            except InputError:
                continue  # `refuse_map` says why, if it is so of all
            if row is not None and (best is None or rank(row) > rank(best)):
                best = row
        if best is not None:
            found.append(best)
    if not found:
        refuse_map(job, job_file, asked, groove, meshes)
    found.sort(key=rank, reverse=True)
    shown = [with_angle(job, row, groove) for row in found[:MOST_ROWS]]
    return sorted(shown, key=rank, reverse=True)


def with_angle(job: Job, row: Proposal, groove: Groove) -> Proposal:
    """Return a screen with the angle of the weakest moiré."""
    rules = MaskRules(
        row.pattern, row.period, job.mask.min_aperture, job.mask.min_web,
        levelling_length=job.mask.levelling_length, mesh=row.mesh,
    )  # fmt: skip
    mean = (row.ratio_min + row.ratio_max) / 2
    worst = []
    for angle in ANGLES:
        setting = MoireSetting(angle * deg, job.mask.pixel, job.mask.viewing_distance)
        worst.append(worst_contrast(rules, setting, groove.pitch, mean))
        if worst[-1] == 0:
            break
    best = int(np.argmin(np.round(worst, 6)))
    return replace(row, angle=ANGLES[best] * deg, moire=worst[best])


def choose_screen(job: Job, job_file: Path, asked: Asked, groove: Groove) -> tuple[Job, str]:
    """Return the job with the best screen in place of `mask.mesh = "auto"`, and why that one.

    Raises
    ------
    InputError
        naming the grooves that no mesh prints, and the nearest map that one does.
    """
    best = propose(job, job_file, asked, groove)[0]
    if best.margin < 1:
        refuse_map(job, job_file, asked, groove, catalogue_of(job, job_file), best)
    chosen = try_screen(job, best.mesh, best.solids_fraction)
    table = chosen.mask.mesh
    assert table is not None
    table = table.model_copy(update={"angle_deg": best.angle / deg})
    table.model_fields_set.add("angle_deg")
    update = {"period_um": round(best.period / um, 6), "mesh": table, "pattern": best.pattern}
    if job.mask.dot_um is not None:
        update["dot_um"] = None
    mask = chosen.mask.model_copy(update=update)
    mask.model_fields_set.update(update)
    reason = "; ".join(text for text in (best.reason(), dilution(job, best)) if text)
    return chosen.model_copy(update={"mask": mask}), reason


def with_screen(job: Job, job_file: Path, asked: Asked, groove: Groove) -> tuple[Job, str | None]:
    """Return a job with a screen chosen where it says `auto`, and why; else the job itself."""
    table = job.mask.mesh
    if table is None or not table.is_auto:
        return job, None
    if not job.is_printed:
        return job.model_copy(update={"mask": job.mask.model_copy(update={"mesh": None})}), None
    return choose_screen(job, job_file, asked, groove)
