"""The loop after the print: a measured luminance of an export's print, and the next map's job."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack, read_stack
from mpfcad.boundary import reason_of
from mpfcad.design import Constraint, Correction, Grid, Response
from mpfcad.design.reprint import Reprint, find_reprint
from mpfcad.errors import ExportError, InputError
from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.job.design import JOB_TABLES, Design
from mpfcad.job.reader import validate
from mpfcad.measure.observed import ObservedPitch
from mpfcad.pipeline.correct.measured import observe_print, seen_of
from mpfcad.pipeline.correct.next_job import printed_curvature, write_difference, write_job
from mpfcad.pipeline.correct.resin import LADDER, Resin, find_resin, printed_process, refuse_table
from mpfcad.pipeline.design.aim import design_goal
from mpfcad.pipeline.design.operators import model_operators
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.judge import Judging
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.restored import restore_plan
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.store import Store

CORRECT_SCHEMA = 1
_NODE_STEP = 6.0
#: C [1/mm] this near to a limit is at it.
_NEAR = 0.5
#: Contrasts of maps that differ by less are as good.
_AS_GOOD = 0.0005
#: Cosines this far off the model's, together, are of another film or backlight: widths of data
#: sheets and of an uncalibrated print move them by less than 0.06.
_FAR = 0.25


def correct_print(
    export: Path,
    measured: Path,
    judging: Judging,
    out: Path,
    *,
    process_file: Path | None = None,
    stack_file: Path | None = None,
    solids: float | Literal["auto"] | None = None,
    threads: int | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Write the job of the next map into `out` and return its record.

    `process_file`: a calibration from coupons of this print; the printed curvature is then what it
    makes of the mask's aperture ratios. `stack_file`: the backlight that `mpfcad fit` found with
    this print, in the place of the export's. `solids`: of the resin of the next print; "auto": the
    nearest of `LADDER` that serves, else the best; None: that of this print.

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
    process = printed_process(plan, process_file)
    refuse_table(process, solids)
    place, printed = printed_curvature(plan, process)
    pitch = plan.stack.period.across
    found = observe_print(measured, judging, pitch, progress)
    design = _design(plan)
    resins = _resins(plan, design, process_file, export, solids)
    progress.stage("estimating the model of the backlight")
    response = _response(plan, resins, printed, threads, progress)
    limit = plan.job.gates.contrast_pass
    reprints = [
        find_reprint(
            place, printed, seen_of(found), response, resin.constraint, design_goal(design),
            pitch, limit,
        )
        for resin in resins
    ]  # fmt: skip
    refuse_far(measured, reprints[0].correction)
    number = _chosen(reprints, limit)
    resin, reprint = resins[number], reprints[number]
    record = _record(plan, found, reprint, limit) | {
        "share_at_limits": _share_at_limits(reprint, resin.constraint),
        "curvature_limits_per_mm": [resin.constraint.curvature_min, resin.constraint.curvature_max],
        "solids_fraction": {
            "printed": plan.job.process.solids_fraction,
            "next": resin.solids_for(plan),
        },
    }
    with export_folder(out, "correct") as folder:
        write_job(folder, plan, reprint, resin.document, process_file, stack_file)
        write_difference(folder, plan, process, resin.process, reprint)
        write_text(folder / "correct.json", canonical_json(record))
        write_manifest(folder, record["name"], "correct")
    return record


def refuse_far(measured: Path, correction: Correction) -> None:
    """Refuse a measurement that is none of the print in its backlight.

    Raises
    ------
    InputError
        when its cosines are far off the model's.
    """
    off = float(np.linalg.norm(correction.relative))
    if off > _FAR:
        raise InputError(
            f"{measured}: luminance varies over the pitch by {off:.0%} of its mean otherwise than "
            f"this print's in its backlight by the model: expected {_FAR:.0%} at most: a "
            "measurement of this print"
        )


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


def _design(plan: Plan) -> Design:
    """Return a design with the tables of the export's job."""
    given = plan.job.given()
    tables = {key: given[key] for key in JOB_TABLES if key in given}
    name = f"{plan.job.name[:50]}-corrected"
    return validate(Design, {"schema": 1, "name": name, **tables}, "job")


def _resins(
    plan: Plan, design: Design, file: Path | None, where: Path,
    solids: float | Literal["auto"] | None,
) -> list[Resin]:  # fmt: skip
    """Return what the next map may be printed with, the print's own resin first when none is asked.

    Raises
    ------
    InputError
        when what is asked prints nothing, or none of those to choose from does.
    """
    if solids != "auto":
        return [find_resin(plan, design, file, where, solids)]
    own, found = plan.job.process.solids_fraction, []
    for share in (1.0, *sorted(LADDER, key=lambda share: abs(np.log(share)))):
        if own * share > 1:
            continue
        try:
            found.append(find_resin(plan, design, file, where, own * share))
        except InputError as error:
            refused = error
    if not found:
        raise refused
    return found


def _response(
    plan: Plan, resins: list[Resin], printed: NDArray[np.float64], threads: int | None,
    progress: Progress,
) -> Response:  # fmt: skip
    low = min(float(printed.min()), *(resin.constraint.curvature_min for resin in resins))
    high = max(float(printed.max()), *(resin.constraint.curvature_max for resin in resins))
    node = np.linspace(low, high, max(4, int(np.ceil((high - low) / _NODE_STEP)) + 1))
    film = plan.job.film
    return Response(
        model_operators(
            Store.open(progress.note), plan.stack, film.groove, film.base, film.profile, node,
            grid=Grid(), seed=plan.job.seed, threads=threads or available_threads(),
            progress=progress.stage,
        )
    )  # fmt: skip


def _chosen(reprints: list[Reprint], limit: float) -> int:
    """Return the number of the first map that is surely within the limit, else of the best one.

    The first is that of the print's own resin, the next those of resin nearest to it: what was
    measured tells most of maps like the printed one.
    """
    for number, reprint in enumerate(reprints):
        if reprint.contrast[2] <= limit:
            return number
    best = min(reprint.contrast[0] for reprint in reprints) + _AS_GOOD
    return next(i for i, reprint in enumerate(reprints) if reprint.contrast[0] <= best)


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
