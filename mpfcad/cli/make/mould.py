"""`mpfcad mould`: the mould of a job's film for the diamond turner."""

from typing import Annotated

import typer

from mpfcad.cli.option import JobFile, Out


def command(
    job_file: JobFile,
    out: Out = None,
    shrinkage: Annotated[
        float,
        typer.Option(
            "--shrinkage", min=0, max=0.2, help="Shrinkage: film = mould x (1 - shrinkage)."
        ),
    ] = 0.0,
    backing_mm: Annotated[
        float, typer.Option("--backing-mm", min=0.05, max=500, help="Metal behind the valleys.")
    ] = 5.0,
    tool_radius_um: Annotated[
        float,
        typer.Option("--tool-radius-um", min=0, max=1000, help="Nose radius; 0 is sharp."),
    ] = 0.0,
) -> int:
    """Make the negative of a job's film: STEP, STL, turning table, DXF."""
    from mpfcad.cli.terminal import Terminal
    from mpfcad.job import read_job
    from mpfcad.pipeline import MouldSetting, default_out, make_mould
    from mpfcad.units import mm, um

    job = read_job(job_file)
    folder = out or default_out(job).with_name(f"{job.name}-mould")
    setting = MouldSetting(shrinkage, backing_mm * mm, tool_radius_um * um)
    with Terminal() as terminal:
        record = make_mould(job, job_file, folder, setting, terminal)
    for name in (
        "mould.step",
        "mould.stl",
        "profile.csv",
        "tool-loss.csv",
        "mould.dxf",
        "film.dxf",
    ):
        print(folder / name)
    for warning in record["warnings"]:
        print(f"warning: {warning}")
    return 0
