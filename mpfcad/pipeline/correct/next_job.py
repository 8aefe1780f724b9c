"""The files of the next map: its job with all that it names, and what changes in the mask."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.written import stack_tables
from mpfcad.confidence import read_covariance
from mpfcad.design.reprint import Reprint
from mpfcad.export import write_text
from mpfcad.export.manifest import kind_of
from mpfcad.film import Process
from mpfcad.job import build_job
from mpfcad.pipeline.correct.resin import PROCESS, calibration_of
from mpfcad.pipeline.plan.plan import Plan, read_plan


def printed_curvature(
    plan: Plan, process: Process
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places [pitch] from a lamp and the curvature that the mask's ratios gave there."""
    assert plan.process is not None
    panel, pitch = plan.panel, plan.stack.period.across
    place = (panel.groove_position - plan.lamp_position) / pitch
    inside = (place >= 0) & (place < 1)
    ratio = plan.process.aperture_ratio_of_curvature(panel.curvature[inside])
    return place[inside], np.asarray(process.curvature(ratio), np.float64)


def write_job(
    folder: Path,
    plan: Plan,
    reprint: Reprint,
    document: dict[str, Any],
    process_file: Path | None,
    stack_file: Path | None,
) -> None:
    """Write map and job; the calibration and the backlight that were used go with them."""
    import tomli_w

    name = f"{plan.job.name[:50]}-corrected"
    position = reprint.position * plan.stack.period.across
    lines = [f"{x:.6f},{c:.6f}" for x, c in zip(position, reprint.curvature, strict=True)]
    write_text(folder / f"{name}.csv", "\n".join(["position_mm,curvature_per_mm", *lines, ""]))
    document = document | {"name": name, "map": {"file": f"{name}.csv", "extent": "pitch"}}
    text = calibration_of(plan, process_file)
    if text is not None:
        write_text(folder / PROCESS, text)
        document["process"] = {**document.get("process", {}), "calibration": PROCESS}
    if stack_file is not None or plan.job.stack.file is not None:
        write_text(folder / "stack.toml", tomli_w.dumps(stack_tables(plan.stack)))
        document["stack"] = {"file": "stack.toml"}
    if stack_file is not None and kind_of(stack_file.parent) == "fit":
        names, matrix = read_covariance(stack_file.parent / "covariance.csv")
        together = {"names": names, "matrix": matrix.tolist()}
        document["confidence"] = {**document.get("confidence", {}), **together}
    job = folder / f"{name}.toml"
    write_text(job, tomli_w.dumps(document))
    read_plan(build_job(document, name), job)


def write_difference(
    folder: Path, plan: Plan, process: Process, resin: Process, reprint: Reprint
) -> None:
    """Write C and aperture ratio of printed mask and next one, and how much wider the next is."""
    assert plan.process is not None
    pitch = plan.stack.period.across
    place, _ = printed_curvature(plan, process)
    inside = (plan.panel.groove_position - plan.lamp_position) / pitch
    designed = plan.panel.curvature[(inside >= 0) & (inside < 1)]
    old = plan.process.aperture_ratio_of_curvature(designed)
    new_curvature = np.interp(place, reprint.position, reprint.curvature)
    new = resin.aperture_ratio_of_curvature(new_curvature)
    head = "position_mm,printed_aperture_ratio,next_aperture_ratio,difference,next_curvature_per_mm"
    lines = [
        f"{x * pitch:.6f},{a:.8f},{b:.8f},{b - a:.8f},{c:.6f}"
        for x, a, b, c in zip(place, old, new, new_curvature, strict=True)
    ]
    write_text(folder / "difference.csv", "\n".join([head, *lines, ""]))
