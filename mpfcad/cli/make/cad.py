"""`mpfcad cad`: the CAD files of a job, nothing else."""

from typing import Annotated

import typer

from mpfcad.cli.option import JobFile, Out, formats


def command(
    job_file: JobFile,
    out: Out = None,
    format: Annotated[
        str,
        typer.Option(
            "--format", metavar="LIST", help="Formats: step, stl, 3mf, ply, csv, tif, dat."
        ),
    ] = ("step,stl"),
) -> int:
    """Make and check the CAD files of a job."""
    from mpfcad.cli.terminal import Terminal
    from mpfcad.job import read_job
    from mpfcad.pipeline import CAD_FORMATS, default_out, make_cad

    chosen = formats(format, CAD_FORMATS)
    job = read_job(job_file)
    folder = out or default_out(job).with_name(f"{job.name}-cad")
    with Terminal() as terminal:
        names = make_cad(job, job_file, folder, chosen, terminal)
    for name in names:
        print(folder / name)
    return 0
