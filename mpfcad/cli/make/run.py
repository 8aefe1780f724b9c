"""`mpfcad run`: the whole job, from the curvature map to the verdict."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mpfcad.cli.option import Confidence, JobFile, Junit, Out, Threads, TraceEffort

if TYPE_CHECKING:
    from mpfcad.job import Job


def command(
    job_file: JobFile,
    out: Out = None,
    effort: TraceEffort = None,
    threads: Threads = None,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Print report.pdf (A4), by a Chromium that is installed.")
    ] = False,
    junit: Junit = None,
    plan: Annotated[
        bool,
        typer.Option("--plan", help="State only what memory and time it takes; make no file."),
    ] = False,
    confidence: Confidence = False,
) -> int:
    """Make mask, CAD files, ray trace and report of a job."""
    from mpfcad.cli.terminal import Terminal, print_verdict
    from mpfcad.job import read_job
    from mpfcad.pipeline import default_out, run_job
    from mpfcad.record import check_junit, exit_code, write_junit

    job = read_job(job_file)
    if confidence and job.confidence is None:
        job = job.model_copy(update={"confidence": job.confidence_table})
    folder = out or default_out(job)
    check_junit(junit)
    if plan:
        return _say_plan(job, job_file, folder, effort.value if effort else job.trace.effort)
    with Terminal() as terminal:
        verification = run_job(
            job,
            job_file,
            folder,
            effort=effort.value if effort else None,
            threads=threads,
            progress=terminal,
            pdf=pdf,
        )
    if junit is not None:
        write_junit(junit, verification)
    print_verdict(verification, folder)
    return exit_code(verification["verdict"])


def _say_plan(job: "Job", job_file: Path, folder: Path, effort: str) -> int:
    """Print what a run takes at most, on this machine; what it refuses is refused here too."""
    from mpfcad.cli.terminal import Terminal
    from mpfcad.pipeline import (
        available_memory,
        checked_masks,
        read_plan,
        run_need,
        with_covariance,
    )
    from mpfcad.pipeline.speed import trace_speed

    plan = read_plan(with_covariance(job, job_file), job_file)
    checked_masks(plan, job_file, folder)
    need = run_need(plan, effort)
    with Terminal() as terminal:
        terminal.stage("measuring how fast this machine traces")
        _, rate = trace_speed()
    print(f"film      {need.grooves} grooves, up to {need.triangles} triangles")
    print(f"memory    up to {need.memory_gb:.1f} GB of {available_memory():.1f} GB available")
    print(f"CAD       about {need.file_minutes:.1f} min on one core")
    print(
        f"traces    up to {need.paths / 1e6:g} million paths ({effort}): "
        f"{need.trace_minutes(rate):.1f} min at {rate:.2f} million a second"
    )
    return 0
