"""What an export keeps of its job, and the plan that is made of it again."""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.backlight.stored import describe_stack, restore_stack
from mpfcad.errors import ExportError
from mpfcad.film import Process
from mpfcad.job import Job, build_job
from mpfcad.pipeline.plan.cell_map import restore_cell_film_map
from mpfcad.pipeline.plan.field import FIELD_FILE, read_field_film
from mpfcad.pipeline.plan.panel_map import FieldMap, GrooveMap, PanelMap
from mpfcad.pipeline.plan.plan import CURVATURE_FILE, Plan, build_plan
from mpfcad.pipeline.plan.printed.process import read_job_process
from mpfcad.pipeline.plan.size import groove_count


def restore_plan(folder: Path, document: dict[str, Any]) -> Plan:
    """Return the plan of an export from its own files alone.

    Parameters
    ----------
    folder
        the export
    document
        `job` of its verification.json

    Raises
    ------
    ExportError
        when this version of mpfcad reads the stored job otherwise than it was meant.
    """
    where = str(folder / "verification.json")
    job = build_job(document["given"], where)
    if job.document() != document["resolved"]:
        raise ExportError(f"{where}: job: its defaults differ in this version of mpfcad")
    groove = job.film.groove
    text = document["calibration"]
    process = restore_process(job, text, where)
    stack = restore_stack(document["stack"])
    measured = None if document["measured_mm"] is None else np.array(document["measured_mm"])
    panel_map: PanelMap
    if stack.period.along > 0 and (job.film.cell == "groove" or job.has_cells):
        panel_map = restore_cell_film_map(job, folder, stack)
    elif (folder / FIELD_FILE).is_file():
        count = groove_count(stack.panel_width, groove.pitch)
        panel_map = FieldMap(read_field_film(job, folder / FIELD_FILE, str(folder), count, stack))
    else:
        panel_map = GrooveMap(read_curvature(folder))
    plan = build_plan(job, stack, process, panel_map, measured, str(folder))
    return replace(plan, calibration=text)


def stored_job(plan: Plan) -> dict[str, Any]:
    """Return what `restore_plan` needs besides an export's own files."""
    return describe_job(plan.job, plan.stack, plan.calibration, plan.measured)


def describe_job(
    job: Job,
    stack: Stack,
    calibration: str | None,
    measured: NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """Return a job with all that it names: its calibration's text, mean groove and backlight."""
    return {
        "resolved": job.document(),
        "given": job.given(),
        "calibration": calibration,
        "measured_mm": None if measured is None else measured.tolist(),
        "stack": describe_stack(stack),
    }


def restore_process(job: Job, text: str | None, where: str) -> Process | None:
    """Return the process of a job whose calibration is kept as text."""
    if text is None:
        return read_job_process(job, None, job.film.groove, where)
    with tempfile.TemporaryDirectory() as temporary:
        file = Path(temporary) / "calibration.toml"
        file.write_bytes(text.encode())
        return read_job_process(job, file, job.film.groove, where)


def read_curvature(folder: Path) -> NDArray[np.float64]:
    """Return the curvature [1/mm] of every groove from an export's curvature.csv."""
    path = folder / CURVATURE_FILE
    return np.loadtxt(path, delimiter=",", skiprows=1, usecols=2, ndmin=1)
