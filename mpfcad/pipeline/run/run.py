"""`run_job`: plan -> files -> examined from the files -> verdict; and the single steps alone."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mpfcad.export import canonical_json, export_folder, write_manifest, write_text
from mpfcad.gate import demand
from mpfcad.job import Job
from mpfcad.mask import Mask
from mpfcad.measure import Checkpoints
from mpfcad.pipeline.confidence.asked import refuse_unlikely
from mpfcad.pipeline.confidence.covariance import with_covariance
from mpfcad.pipeline.effort import TRACE_SETTINGS
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.need import refuse_memory, run_need
from mpfcad.pipeline.plan.plan import Plan, read_plan
from mpfcad.pipeline.plan.printed.order import (
    ORDER,
    job_order,
    named,
    phototool,
    refuse_mask_formats,
    write_job_order,
)
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.run.make import (
    check_cad,
    check_masks,
    left_out,
    mask_names,
    plan_mask,
    refuse_formats,
    write_cad,
    write_curvature,
    write_mask_pictures,
    write_masks,
    write_tiles,
)
from mpfcad.pipeline.run.mask_plan import MaskPlan, read_mask_plan
from mpfcad.pipeline.run.stack_mesh import write_stack_meshes
from mpfcad.store import Store

VERIFICATION = "verification.json"
REPORT, PRINTED = "report.html", "report.pdf"
SCREEN = "screen.json"


def default_out(job: Job) -> Path:
    """Return where a job's results go unless told otherwise."""
    return Path("exports") / job.name


def run_job(
    job: Job,
    job_file: Path,
    out: Path,
    *,
    effort: str | None = None,
    threads: int | None = None,
    progress: Progress = SILENT,
    pdf: bool = False,
) -> dict[str, Any]:
    """Make, check and trace a job into the folder `out`; return its verification.json.

    With `pdf` the report is printed too.

    Raises
    ------
    InputError
        when the job or a file it names is wrong, or no browser can print; `out` is then as it was.
    """
    browser = _browser() if pdf else None
    effort = effort or job.trace.effort
    progress.stage(f"reading {job_file}")
    plan = read_plan(with_covariance(job, job_file), job_file)
    for table in plan.stack.tables.values():
        progress.note(table.table.summary())
    for note in left_out(plan):
        progress.note(note)
    job = plan.job
    refuse_memory(run_need(plan, effort), str(job_file))
    masks = checked_masks(plan, job_file, out)
    # The traces are kept until the export is on the disk: a full disk at the report loses none.
    with (
        Checkpoints(Store.open(progress.note)) as checkpoints,
        export_folder(out, "run") as folder,
    ):
        write_curvature(plan, folder)
        for film, mask in zip(plan.films, masks, strict=True):
            if mask is not None and film.process is not None:
                tool = phototool(film.job, mask, film.process)
                write_masks(mask, tool, folder, mask_names(film, job.mask.formats), progress)
        write_cad(plan, folder, kind_of(plan.drawn, job.cad).run_formats, progress)
        write_stack_meshes(plan, folder, progress)
        return _examine_and_report(
            folder, plan, masks, job_file, effort, threads, checkpoints, progress, browser
        )


def checked_masks(plan: Plan, job_file: Path, out: Path) -> list[Mask | None]:
    """Return the mask of each film of a plan, None where none is printed, before work begins.

    Raises
    ------
    InputError
        that begins with the job's file, when the piece cannot be traced, a format cannot hold a
        mask, the disk of the folder `out` not its picture, or the confidence that is asked for is
        not found.
    """
    job, where = plan.job, str(job_file)
    refuse_unlikely(where, plan)
    kind_of(plan.drawn, job.cad).refuse_trace(plan.printed, plan.stack, where)
    masks = [plan_mask(film) for film in plan.films]
    for mask in masks:
        if mask is not None:
            refuse_mask_formats(job, mask, job.mask.formats, where, out)
    return masks


def _browser() -> str:
    from mpfcad.report.browser import find_browser

    return find_browser()


def _examine_and_report(
    folder: Path,
    plan: Plan,
    masks: list[Mask | None],
    job_file: Path,
    effort: str,
    threads: int | None,
    checkpoints: Checkpoints,
    progress: Progress,
    browser: str | None,
) -> dict[str, Any]:
    from mpfcad.pipeline.run.examine import examine, write_pictures
    from mpfcad.pipeline.run.provenance import build_provenance
    from mpfcad.pipeline.run.record import build_record, gather_evidence
    from mpfcad.report import write_report

    setting = TRACE_SETTINGS[effort]
    findings = examine(folder, plan, masks, setting, threads, checkpoints, progress)
    write_pictures(plan, masks, findings, folder)
    provenance = build_provenance(plan, job_file, effort)
    record = build_record(folder, plan, findings, setting, provenance)
    write_text(folder / VERIFICATION, canonical_json(record))
    write_run_order(folder, plan, masks, record, progress)
    progress.stage("writing report.html")
    write_report(folder / REPORT, record, gather_evidence(folder, plan, masks[0], findings))
    if browser is not None:
        from mpfcad.report.browser import write_pdf

        progress.stage(f"printing {PRINTED}")
        write_pdf(folder / REPORT, folder / PRINTED, browser)
    write_manifest(folder, plan.job.name, "run")
    return record


def write_run_order(
    folder: Path,
    plan: Plan,
    masks: Sequence[Mask | None],
    record: dict[str, Any],
    progress: Progress,
    source: Path | None = None,
) -> None:
    """Write order.pdf and coupons.csv of a film that is printed through a mesh, into `folder`."""
    for film, mask in zip(plan.films, masks, strict=True):
        if mask is None or film.process is None or mask.rules.mesh is None:
            continue
        progress.stage(f"writing {named(ORDER, film.suffix)}")
        order, formats = job_order(film.job, mask, film.process), plan.job.mask.formats
        write_job_order(folder, order, record["printability"], formats, source, film.suffix)


def make_mask(
    job: Job,
    job_file: Path,
    out: Path,
    formats: tuple[str, ...] | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Make and check only the mask files of a job; `formats` None: those the job names.

    Returns screen.json: what the screen is, the gates of mask and screen, `printability`.

    Raises
    ------
    InputError
        when the job is wrong or no print can make its film.
    ExportError
        when a file does not read back as a mask.
    """
    progress.stage(f"reading {job_file}")
    return make_planned_mask(read_mask_plan(job, job_file), job_file, out, formats, progress)


def make_planned_mask(
    plan: MaskPlan,
    source: Path,
    out: Path,
    formats: tuple[str, ...] | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Make and check the mask files of a plan, from the job or export `source`, as `make_mask`."""
    job = plan.job
    formats = formats or tuple(job.mask.formats)
    plan.refuse_formats(formats, str(source), out)
    with export_folder(out, "mask") as folder:
        found = []
        for one in plan.masks:
            one.write_curvature(folder)
            tool = phototool(one.job, one.mask, one.process)
            names = [f"{one.stem}.{suffix}" for suffix in formats]
            write_masks(one.mask, tool, folder, names, progress)
            found.append(check_masks(one.mask, tool, folder, names, progress))
            write_mask_pictures(folder, found[-1], one.mask, stem=one.stem)
        progress.stage("writing screen.json")
        screen = plan.judge_all(found)
        write_text(folder / SCREEN, canonical_json(screen))
        for one in plan.masks:
            progress.stage(f"writing {one.order_file}")
            one.write_order(folder, screen, formats)
        write_manifest(folder, job.name, "mask")
        return screen


def make_cad(
    job: Job, job_file: Path, out: Path, formats: tuple[str, ...], progress: Progress = SILENT
) -> list[str]:
    """Make and check only the CAD files of a job; return their names.

    Raises
    ------
    InputError
        when the job is wrong.
    ExportError
        when a file does not read back as what it should hold.
    """
    progress.stage(f"reading {job_file}")
    plan = read_plan(job, job_file)
    refuse_formats(plan, formats, str(job_file))
    tiled = job.cad.stl == "tiles" and "stl" in formats
    whole = tuple(suffix for suffix in formats if not (tiled and suffix == "stl"))
    names = [film.file("film", suffix) for film in plan.films for suffix in whole]
    for note in left_out(plan):
        progress.note(note)
    with export_folder(out, "cad") as folder:
        write_curvature(plan, folder)
        write_cad(plan, folder, whole, progress)
        for check in check_cad(plan, folder, whole, progress):
            demand(check.gates)
        names += write_tiles(plan, folder, progress) if tiled else []
        write_manifest(folder, job.name, "cad")
    return names
