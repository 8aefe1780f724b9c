"""`mpfcad run`: the whole job, from the curvature map to the verdict."""

from typing import Annotated

import typer

from mpfcad.cli.option import JobFile, Junit, Out, Threads, TraceEffort


def command(
    job_file: JobFile,
    out: Out = None,
    effort: TraceEffort = None,
    threads: Threads = None,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Print report.pdf (A4), by a Chromium that is installed.")
    ] = False,
    junit: Junit = None,
    confidence: Annotated[
        bool,
        typer.Option(
            "--confidence",
            help="State how likely the verdict holds, with every input's uncertainty.",
        ),
    ] = False,
) -> int:
    """Make mask, CAD files, ray trace and report of a job."""
    from mpfcad.cli.terminal import Terminal, print_verdict
    from mpfcad.job import read_job
    from mpfcad.pipeline import default_out, run_job
    from mpfcad.record import exit_code, write_junit

    job = read_job(job_file)
    if confidence and job.confidence is None:
        job = job.model_copy(update={"confidence": job.confidence_table})
    folder = out or default_out(job)
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
