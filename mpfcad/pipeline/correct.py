"""The loop after the print: a measured luminance of an export's print, and the next map's job."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack, read_stack
from mpfcad.backlight.written import stack_tables
from mpfcad.boundary import reason_of
from mpfcad.confidence import read_covariance
from mpfcad.design import Constraint, Grid, Response
from mpfcad.design.reprint import Reprint, Seen, find_reprint
from mpfcad.errors import ExportError, InputError
from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.export.manifest import kind_of
from mpfcad.film import Process, read_process
from mpfcad.job import build_job
from mpfcad.job.design import JOB_TABLES, Design
from mpfcad.job.reader import validate
from mpfcad.measure.observed import (
    ObservedPitch,
    askew_words,
    check_pitch,
    curve_of_image,
    observe_pitch,
    read_curve,
)
from mpfcad.measure.observed.image import is_image, read_image
from mpfcad.pipeline.design.aim import design_constraint, design_goal
from mpfcad.pipeline.design.operators import model_operators
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.judge import Judging
from mpfcad.pipeline.plan.plan import Plan, read_plan
from mpfcad.pipeline.plan.printed.process import read_job_process
from mpfcad.pipeline.plan.restored import restore_plan
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.store import Store

CORRECT_SCHEMA = 1
#: The calibration beside the next job.
PROCESS = "process.toml"
_NODE_STEP, _HARMONICS = 6.0, 4
#: C [1/mm] this near to a limit is at it.
_NEAR = 0.5
#: A stated lamp pitch may be off the backlight's by so much: the scale of a file.
_SAME_PITCH = 0.05


def correct_print(
    export: Path,
    measured: Path,
    judging: Judging,
    out: Path,
    *,
    process_file: Path | None = None,
    stack_file: Path | None = None,
    threads: int | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Write the job of the next map into `out` and return its record.

    `process_file`: a calibration from coupons of this print; the printed curvature is then what it
    makes of the mask's aperture ratios. `stack_file`: the backlight that `mpfcad fit` found with
    this print, in the place of the export's.

    Raises
    ------
    InputError
        when the export has no mask over a lamp pitch, or the measurement cannot be used.
    """
    refuse_foreign(out.resolve(), "correct")
    plan = _plan(export)
    if stack_file is not None:
        plan = replace(plan, stack=_fitted(plan, stack_file))
    if judging.lamp is None:
        raise InputError(
            "--lamp-at-mm: expected a lamp's place in the measurement: a curve alone does not tell "
            "whether lamps are bright or dark in it"
        )
    process = _process(plan, process_file)
    place, printed = _printed(plan, process)
    pitch = plan.stack.period.across
    found = observe_print(measured, judging, pitch, progress)
    progress.stage("estimating the model of the backlight")
    design = _design(plan)
    constraint = design_constraint(design, plan.job, process, export)
    response = _response(plan, constraint, printed, threads, progress)
    limit = plan.job.gates.contrast_pass
    reprint = find_reprint(
        place, printed, _seen(found), response, constraint, design_goal(design), pitch, limit
    )
    record = _record(plan, found, reprint, limit) | {
        "share_at_limits": _share_at_limits(reprint, constraint),
        "curvature_limits_per_mm": [constraint.curvature_min, constraint.curvature_max],
    }
    with export_folder(out, "correct") as folder:
        _write_job(folder, plan, reprint, process_file, stack_file)
        _write_difference(folder, plan, process, reprint)
        write_text(folder / "correct.json", canonical_json(record))
        write_manifest(folder, record["name"], "correct")
    return record


def _plan(export: Path) -> Plan:
    try:
        document = json.loads((export / "verification.json").read_text("utf-8"))
        plan = restore_plan(export, document["job"])
    except (OSError, ValueError, KeyError, TypeError, ExportError) as error:
        raise InputError(
            f"{export}: {reason_of(error)}: expected an export of mpfcad run"
        ) from None
    job = plan.job
    wrong = (
        "film.profile: no print makes it" if plan.process is None
        else "map: varies along the grooves" if plan.printed.varies_along
        else f"map.extent: {job.map.extent}" if job.map.extent != "pitch"
        else None
    )  # fmt: skip
    if wrong:
        raise InputError(
            f"{export}: {wrong}: expected a printed film of grooves and a map over the lamp pitch"
        )
    return plan


def _fitted(plan: Plan, file: Path) -> Stack:
    """Return the stack of a file in the place of the plan's, with what the job states of the film.

    Raises
    ------
    InputError
        when its lamps stand otherwise.
    """
    job = plan.job
    own = job.resin.document() if job.resin else {}
    if job.film.refractive_index is not None:
        own["film_index"] = job.film.refractive_index
    stack = read_stack(file, overrides=own)
    if stack.period != plan.stack.period:
        raise InputError(
            f"{file}: lamp pitch {stack.period.across:g} mm: expected the export's "
            f"{plan.stack.period.across:g} mm"
        )
    return stack


def _process(plan: Plan, file: Path | None) -> Process:
    """Return the process as printed: of the coupons, if there are any, as the next job reads them.

    Raises
    ------
    InputError
        when the calibration does not fit the job's screen.
    """
    process = plan.process
    if file is not None:
        job = build_job(_calibrated(plan, file), plan.job.name)
        process = read_job_process(job, file, plan.job.film.groove, str(file))
    assert process is not None
    return process


def _calibrated(plan: Plan, file: Path) -> dict[str, Any]:
    """Return the printed job with a calibration, without what a calibration says itself."""
    process = read_process(file, plan.job.film.groove)
    document = dict(plan.job.given())
    table = {**document.get("process", {}), "calibration": PROCESS}
    table.pop("model", None)
    if process.kind == "table":
        # Its rows are of the resin that was printed, however thin that was.
        table.pop("solids_fraction", None)
    document["process"] = table
    if "mesh" in document.get("mask", {}) and isinstance(document["mask"]["mesh"], dict):
        mesh = {k: v for k, v in document["mask"]["mesh"].items() if k != "release"}
        document["mask"] = {**document["mask"], "mesh": mesh}
    if process.fill_deviation(0.5) is not None and "confidence" in document:
        own = {k: v for k, v in document["confidence"].items() if k != "resin_percent"}
        document["confidence"] = own
    return document


def _printed(plan: Plan, process: Process) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places [pitch] from a lamp and the curvature that the mask's ratios gave there."""
    assert plan.process is not None
    panel, pitch = plan.panel, plan.stack.period.across
    place = (panel.groove_position - plan.lamp_position) / pitch
    inside = (place >= 0) & (place < 1)
    ratio = plan.process.aperture_ratio_of_curvature(panel.curvature[inside])
    return place[inside], np.asarray(process.curvature(ratio), np.float64)


def observe_print(
    measured: Path, judging: Judging, pitch: float, progress: Progress = SILENT
) -> ObservedPitch:
    """Return what was measured of a print over the lamp pitch [mm] of its backlight.

    Raises
    ------
    InputError
        when the file cannot be read, or bears another period.
    """
    if not measured.is_file():
        raise InputError(f"{measured}: no such file: expected a luminance curve or image")
    if is_image(measured):
        if judging.photo is None:
            raise InputError(f"{measured}: an image: expected --pixel-mm, the side of a pixel")
        image = read_image(measured, judging.photo)
        curve = curve_of_image(image)
        words = askew_words(measured, image, curve)
        if words:
            progress.note(f"{measured}: {words}")
    else:
        curve = read_curve(measured, judging.unit)
    own = judging.pitch or pitch
    if abs(own / pitch - 1) > _SAME_PITCH:
        raise InputError(
            f"--pitch-mm: {own:g}: expected the lamp pitch of the print's backlight, {pitch:g} mm, "
            f"within {_SAME_PITCH:.0%}"
        )
    whose = "--pitch-mm" if judging.pitch else "the lamp pitch in mm of the print's backlight,"
    words = check_pitch(
        str(measured), curve.position, curve.luminance, own, whose, "a curve of that backlight"
    )
    if words:
        progress.note(f"{measured}: {words}")
    return observe_pitch(curve, own, judging.lamp, judging.seed)


def _seen(found: ObservedPitch) -> Seen:
    """Return the cosines of a measurement; its sines are the film's misplacement, not the map's."""
    fit = found.fit
    mean = float(fit.coefficient[0])
    cosines = slice(1, 2 * _HARMONICS, 2)
    return Seen(mean, fit.coefficient[cosines] / mean, fit.covariance[cosines, cosines] / mean**2)


def _design(plan: Plan) -> Design:
    """Return a design with the tables of the export's job."""
    given = plan.job.given()
    tables = {key: given[key] for key in JOB_TABLES if key in given}
    name = f"{plan.job.name[:50]}-corrected"
    return validate(Design, {"schema": 1, "name": name, **tables}, "job")


def _response(
    plan: Plan, constraint: Constraint, printed: NDArray[np.float64], threads: int | None,
    progress: Progress,
) -> Response:  # fmt: skip
    low = min(constraint.curvature_min, float(printed.min()))
    high = max(constraint.curvature_max, float(printed.max()))
    node = np.linspace(low, high, max(4, int(np.ceil((high - low) / _NODE_STEP)) + 1))
    film = plan.job.film
    return Response(
        model_operators(
            Store.open(progress.note), plan.stack, film.groove, film.base, film.profile, node,
            grid=Grid(), seed=plan.job.seed, threads=threads or available_threads(),
            progress=progress.stage,
        )
    )  # fmt: skip


def _share_at_limits(reprint: Reprint, constraint: Constraint) -> float:
    """Return over which share of the pitch C lies at the least or the largest that is printed."""
    low, high = constraint.curvature_min + _NEAR, constraint.curvature_max - _NEAR
    return float(np.mean((reprint.curvature < low) | (reprint.curvature > high)))


def _record(plan: Plan, found: ObservedPitch, reprint: Reprint, limit: float) -> dict[str, Any]:
    value, low, high = reprint.contrast
    return {
        "schema": CORRECT_SCHEMA,
        "name": f"{plan.job.name[:50]}-corrected",
        "printed": plan.job.name,
        "measured_lamp_mura_contrast": {
            "value": found.contrast.value, "ci95": [found.contrast.low, found.contrast.high],
        },
        "predicted_lamp_mura_contrast": {"value": value, "ci95": [low, high]},
        "contrast_limit": limit,
        "confidence": reprint.confidence,
        "model_contrast_of_printed_map": reprint.before,
        "correction": {
            "luminance_ratio": reprint.correction.scale,
            "harmonics_over_mean": reprint.correction.relative.tolist(),
        },
    }  # fmt: skip


def _write_job(
    folder: Path,
    plan: Plan,
    reprint: Reprint,
    process_file: Path | None,
    stack_file: Path | None,
) -> None:
    """Write map and job; the calibration and the backlight that were used go with them."""
    import tomli_w

    name = f"{plan.job.name[:50]}-corrected"
    position = reprint.position * plan.stack.period.across
    lines = [f"{x:.6f},{c:.6f}" for x, c in zip(position, reprint.curvature, strict=True)]
    write_text(folder / f"{name}.csv", "\n".join(["position_mm,curvature_per_mm", *lines, ""]))
    document = dict(plan.job.given()) if process_file is None else _calibrated(plan, process_file)
    document |= {"name": name, "map": {"file": f"{name}.csv", "extent": "pitch"}}
    text = plan.calibration if process_file is None else process_file.read_text("utf-8")
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


def _write_difference(folder: Path, plan: Plan, process: Process, reprint: Reprint) -> None:
    """Write C and aperture ratio of printed mask and next one, and how much wider the next is."""
    assert plan.process is not None
    pitch = plan.stack.period.across
    place, _ = _printed(plan, process)
    inside = (plan.panel.groove_position - plan.lamp_position) / pitch
    designed = plan.panel.curvature[(inside >= 0) & (inside < 1)]
    old = plan.process.aperture_ratio_of_curvature(designed)
    new_curvature = np.interp(place, reprint.position, reprint.curvature)
    new = process.aperture_ratio_of_curvature(new_curvature)
    head = "position_mm,printed_aperture_ratio,next_aperture_ratio,difference,next_curvature_per_mm"
    lines = [
        f"{x * pitch:.6f},{a:.8f},{b:.8f},{b - a:.8f},{c:.6f}"
        for x, a, b, c in zip(place, old, new, new_curvature, strict=True)
    ]
    write_text(folder / "difference.csv", "\n".join([head, *lines, ""]))
