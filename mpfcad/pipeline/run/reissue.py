"""A mask made again from an export, with another mesh, mirroring, polarity or format."""

import json
from pathlib import Path
from typing import Any

from mpfcad.backlight.stored import restore_stack
from mpfcad.boundary import reason_of
from mpfcad.errors import ExportError, InputError
from mpfcad.job import Job, build_job
from mpfcad.pipeline.plan.field import FIELD_FILE, read_field_film
from mpfcad.pipeline.plan.plan import CURVATURE_FILE
from mpfcad.pipeline.plan.restored import restore_plan, restore_process
from mpfcad.pipeline.plan.size import groove_count
from mpfcad.pipeline.run.make import refuse_unprintable
from mpfcad.pipeline.run.mask_plan import MaskPlan, field_mask_plan, mask_plan_of

#: Where an export holds its job, by the command that made it.
JOB_FILES = ("verification.json", "screen.json")
MESH_FIELDS = ("name", "emulsion_um", "angle_deg", "release")


def changed_job(job: Job, changes: dict[str, Any], where: str) -> Job:
    """Return a job with changes of its `[mask]`; those of the mesh as `mesh.name` and the like.

    Raises
    ------
    InputError
        when a change makes no job.
    """
    if not changes:
        return job
    return build_job(_changed(job.given(), changes), where)


def _changed(given: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    mask = dict(given.get("mask", {}))
    mesh = dict(mask.get("mesh") or {})
    process = dict(given.get("process", {}))
    for name, value in changes.items():
        if name == "mesh.name":
            kept = {k: v for k, v in mesh.items() if k in MESH_FIELDS}
            mesh = {**kept, "name": value}
        elif name.startswith("mesh."):
            mesh[name.removeprefix("mesh.")] = value
        elif name.startswith("process."):
            process[name.removeprefix("process.")] = value
        else:
            mask[name] = value
    mask = {**mask, **({"mesh": mesh} if mesh else {})}
    return {**given, "mask": mask, **({"process": process} if process else {})}


def restore_mask_plan(folder: Path, changes: dict[str, Any]) -> MaskPlan:
    """Return the mask plan of an export, with changes as in `changed_job`.

    Raises
    ------
    InputError
        when the folder holds no job, or a change makes no mask.
    """
    document = _job_document(folder)
    given = _changed(document["given"], changes)
    job = build_job(given, str(folder))
    if job.mask.mesh is not None and job.mask.mesh.is_auto:
        raise InputError(f"{folder}: --mesh: auto: expected a name; choose one with --propose")
    if (folder / FIELD_FILE).is_file() and not _is_cell(document):
        return _restore_field(folder, job, document)
    try:
        plan = restore_plan(folder, {**document, "given": given, "resolved": job.document()})
    except ExportError as error:
        raise InputError(str(error)) from None
    found = mask_plan_of(plan)
    if found is None:
        raise InputError(f"{folder}: holds no mask: expected the export of a printed film")
    return found


def _is_cell(document: dict[str, Any]) -> bool:
    """Return whether LEDs light the stack of a stored job: its map is over a cell of them."""
    return restore_stack(document["stack"]).period.along > 0


def _restore_field(folder: Path, job: Job, document: dict[str, Any]) -> MaskPlan:
    """Return the mask of a map that varies along the grooves too."""
    refuse_unprintable(job, str(folder))
    stack, text = restore_stack(document["stack"]), document["calibration"]
    count = groove_count(stack.panel_width, job.film.groove.pitch)
    film = read_field_film(job, folder / FIELD_FILE, str(folder), count, stack)
    process = restore_process(job, text, str(folder))
    return field_mask_plan(job, film, stack, process, text, str(folder))


def _job_document(folder: Path) -> dict[str, Any]:
    for name in JOB_FILES:
        file = folder / name
        if not file.is_file():
            continue
        try:
            document = json.loads(file.read_text("utf-8")).get("job")
        except (OSError, ValueError) as error:
            raise InputError(
                f"{file}: cannot be read: {reason_of(error)}: expected the record of an export"
            ) from None
        if isinstance(document, dict) and "stack" in document:
            held = [folder / CURVATURE_FILE, folder / FIELD_FILE]
            if not any(path.is_file() for path in held):
                raise InputError(f"{folder}: {CURVATURE_FILE}: missing: expected a whole export")
            return document
        raise InputError(f"{file}: job: missing: expected an export of this version")
    raise InputError(
        f"{folder}: no {' or '.join(JOB_FILES)}: expected a job, or an export of `mpfcad run` or "
        f"`mpfcad mask`"
    )
