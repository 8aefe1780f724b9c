"""`mpfcad mask`: the mask files of a job, nothing else."""

from typing import Annotated

import typer

from mpfcad.cli.option import JobFile, Out, formats


def command(
    job_file: JobFile,
    out: Out = None,
    format: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="LIST",
            help="Of oas, gds, dxf, gbr, svg, tif; default: what the job says.",
        ),
    ] = None,
    plan: Annotated[
        bool, typer.Option("--plan", help="Only say what screen the job needs; make no file.")
    ] = False,
) -> int:
    """Make and check the mask files of a job."""
    from mpfcad.cli.terminal import Terminal, print_gates
    from mpfcad.job import read_job
    from mpfcad.pipeline import MASK_FORMATS, default_out, make_mask, read_mask_plan

    asked = None if format is None else formats(format, MASK_FORMATS)
    job = read_job(job_file)
    chosen = asked or tuple(job.mask.formats)
    if plan:
        from mpfcad.mask.screen.screen import screen_lines

        print("\n".join(screen_lines(read_mask_plan(job, job_file).describe())))
        return 0
    folder = out or default_out(job).with_name(f"{job.name}-mask")
    with Terminal() as terminal:
        screen = make_mask(job, job_file, folder, chosen, terminal)
    print_gates(screen)
    for name in chosen:
        print(folder / f"mask.{name}")
    return 1 if screen["printability"] in ("FAIL", "INCONCLUSIVE") else 0
