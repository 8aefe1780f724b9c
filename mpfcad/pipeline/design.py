"""`run_design`: a design's map, its job and the page of its iterations; every trace is kept."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.design import Iteration
from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.job.design import Design
from mpfcad.pipeline.design_work import DesignWork
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.record import versions

RECORD, PAGE = "design.json", "design.html"


def default_design_out(design: Design) -> Path:
    """Return where a design's job goes unless told otherwise."""
    return Path("exports") / f"{design.name}-design"


def run_design(
    design: Design,
    design_file: Path,
    out: Path,
    *,
    threads: int | None = None,
    progress: Progress = SILENT,
) -> Path:
    """Search a map, write job, map and page into the folder `out`, and return the job's path.

    Traces that are done are kept in a file beside `out` and not repeated; the bytes are the same
    as without an interruption.

    Raises
    ------
    InputError
        when the design or a file it names is wrong; `out` is then as it was.
    """
    design_file, out = Path(design_file), Path(out)
    refuse_foreign(out.resolve(), "design")
    work = DesignWork(design, design_file, out, threads or available_threads(), progress)
    done = work.search()
    record = describe_design(work, done)
    with export_folder(out, "design") as folder:
        best = np.array(work.best(done).rows)
        work.write_job(folder, best, os.path.relpath(design_file.parent, out))
        write_text(folder / RECORD, canonical_json(record))
        from mpfcad.report import write_design_page

        write_design_page(folder / PAGE, record)
        write_manifest(folder, design.name, "design")
    return out / f"{design.name}.toml"


def describe_design(work: DesignWork, done: list[Iteration]) -> dict[str, Any]:
    """Return everything that was found, in outside names."""
    constraint = work.constraint
    return {
        "schema": 1,
        "name": work.design.name,
        "design": work.design.document(),
        "stack": {"title": work.stack.title, "inputs": work.stack.inputs()},
        "constraint": {
            "curvature_min_per_mm": constraint.curvature_min,
            "curvature_max_per_mm": constraint.curvature_max,
            "change_max_per_mm2": constraint.change_max,
        },
        "lamp_pitch_mm": work.pitch,
        "model": work.model,
        "reach": work.reach,
        "iterations": [describe_iteration(one) for one in done],
        "chosen": done.index(work.best(done)),
        "paths": sum(one.traced.paths for one in done),
        "versions": versions(),
    }


def describe_iteration(one: Iteration) -> dict[str, Any]:
    """Return a traced map in outside names."""
    traced = one.traced
    predicted = None
    if one.predicted_contrast is not None:
        predicted = {
            "lamp_mura_contrast": one.predicted_contrast,
            "mean_luminance_cd_m2": one.predicted_mean,
        }
    half = 1.959963984540054 * traced.mean_error
    return {
        "label": one.label,
        "series_per_mm": list(one.series),
        "curvature_per_mm": list(one.rows),
        "predicted": predicted,
        "lamp_mura_contrast": {
            "value": traced.contrast,
            "ci95": [traced.contrast_low, traced.contrast_high],
        },
        "mean_luminance_cd_m2": {
            "value": traced.mean,
            "ci95": [traced.mean - half, traced.mean + half],
        },
        "fit_coefficient_cd_m2": list(traced.coefficient),
        "paths": traced.paths,
    }
