"""`mpfcad mask`: the mask files of a job, nothing else."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mpfcad.cli.option import Json, Out, formats

if TYPE_CHECKING:
    from mpfcad.pipeline import MaskPlan


def command(
    job_file: Annotated[
        Path,
        typer.Argument(metavar="JOB.toml|EXPORT", help="The job, or an export to make it from."),
    ],
    out: Out = None,
    format: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="LIST",
            help="Formats: oas, gds, dxf, gbr, svg, tif [default: the job's].",
        ),
    ] = None,
    plan: Annotated[
        bool, typer.Option("--plan", help="State the screen that the job needs; make no file.")
    ] = False,
    propose: Annotated[
        bool,
        typer.Option(
            "--propose", help="List screens that print the job's map, best first; make no file."
        ),
    ] = False,
    compare: Annotated[
        Path | None,
        typer.Option(
            "--compare",
            metavar="FILE",
            help="Compare with a maker's file, groove by groove; make no file.",
        ),
    ] = None,
    mesh: Annotated[
        str | None, typer.Option("--mesh", help="Mesh of the screen, in place of the job's.")
    ] = None,
    mesh_angle_deg: Annotated[
        float | None,
        typer.Option(
            "--mesh-angle-deg", help="Angle of the threads to the grooves, in place of the job's."
        ),
    ] = None,
    emulsion_um: Annotated[
        float | None,
        typer.Option("--emulsion-um", help="Emulsion over mesh, in place of the job's."),
    ] = None,
    pattern: Annotated[
        str | None, typer.Option("--pattern", help="Pattern, in place of the job's.")
    ] = None,
    period_um: Annotated[
        float | None, typer.Option("--period-um", help="Period, in place of the job's.")
    ] = None,
    solids: Annotated[
        float | None,
        typer.Option("--solids", help="Solids fraction of the resin, in place of the job's."),
    ] = None,
    polarity: Annotated[
        str | None, typer.Option("--polarity", help="open or closed, in place of the job's.")
    ] = None,
    mirror: Annotated[
        bool | None,
        typer.Option(
            "--mirror/--no-mirror", help="Seen from the film's side or not, in place of the job's."
        ),
    ] = None,
    revision: Annotated[
        str | None, typer.Option("--revision", help="Revision, in place of the job's.")
    ] = None,
    json: Json = False,
) -> int:
    """Make and check the mask files of a job, or make them again from an export."""
    from mpfcad.cli.terminal import Terminal, print_gates
    from mpfcad.pipeline import MASK_FORMATS, default_out, make_planned_mask

    asked = None if format is None else formats(format, MASK_FORMATS)
    changes = {
        name: value
        for name, value in (
            ("mesh.name", mesh), ("mesh.angle_deg", mesh_angle_deg),
            ("mesh.emulsion_um", emulsion_um), ("pattern", pattern), ("period_um", period_um),
            ("process.solids_fraction", solids),
            ("polarity", polarity), ("mirror", mirror), ("revision", revision),
        )
        if value is not None
    }  # fmt: skip
    if propose:
        from mpfcad.cli.make.proposal import print_proposals

        return print_proposals(job_file, json)
    planned = _read(job_file, changes)
    chosen = asked or tuple(planned.job.mask.formats)
    folder = out or default_out(planned.job).with_name(f"{planned.job.name}-mask")
    if plan:
        from mpfcad.mask.screen.screen import screen_lines

        planned.refuse_formats(chosen, str(job_file), folder)
        print("\n".join([*screen_lines(planned.describe()), *planned.needs(chosen)]))
        return 0
    if compare is not None:
        return _compare(compare, planned)
    with Terminal() as terminal:
        screen = make_planned_mask(planned, job_file, folder, chosen, terminal)
    print_gates(screen)
    if screen["printability"] == "FAIL" and job_file.is_file():
        print(f"screens that print this map: mpfcad mask {job_file} --propose")
    for one in planned.masks:
        for name in (*(f"{one.stem}.{suffix}" for suffix in chosen), one.order_file):
            print(folder / name)
    outcomes = {gate["outcome"] for gate in screen["gates"]}
    return 1 if outcomes & {"FAIL", "INCONCLUSIVE"} else 0


def _read(path: Path, changes: dict[str, Any]) -> "MaskPlan":
    """Return the mask of a job, or of an export, with changes."""
    from mpfcad.job import read_job
    from mpfcad.pipeline import changed_job, read_mask_plan, restore_mask_plan

    if path.is_dir():
        return restore_mask_plan(path, changes)
    return read_mask_plan(changed_job(read_job(path), changes, str(path)), path)


def _compare(file: Path, planned: "MaskPlan") -> int:
    """Print how a maker's file differs; 1 when it does."""
    from mpfcad.boundary.apart import apart
    from mpfcad.errors import ExportError, InputError
    from mpfcad.mask.check.compare import RETURNED, compare_mask, comparison_lines

    if file.suffix.removeprefix(".") not in RETURNED or not file.is_file():
        raise InputError(f"--compare: {file}: expected a file .{', .'.join(RETURNED)}")
    try:
        # In a process of its own: what a maker sends back may make a reader in C++ crash.
        found = apart(
            file, "a mask file", compare_mask, file, planned.mask, planned.phototool(),
            libraries=("klayout.db",),
        )  # fmt: skip
    except ExportError as error:
        raise InputError(str(error)) from None
    print("\n".join(comparison_lines(found)))
    return 0 if found.is_same else 1
