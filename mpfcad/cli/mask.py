"""`mpfcad mask`: the mask files of a job, nothing else."""

from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import JobFile, Json, Out, formats


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
    propose: Annotated[
        bool,
        typer.Option("--propose", help="Only list screens that print the job's map, best first."),
    ] = False,
    json: Json = False,
) -> int:
    """Make and check the mask files of a job."""
    from mpfcad.cli.terminal import Terminal, print_gates
    from mpfcad.job import read_job
    from mpfcad.pipeline import MASK_FORMATS, default_out, make_mask, read_mask_plan

    if propose:
        return _propose(job_file, json)
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


def _propose(job_file: Path, json: bool) -> int:
    """Print the screens that print a job's map."""
    import json as json_format

    from mpfcad.job import read_job
    from mpfcad.pipeline import read_proposals

    rows = [row.document() for row in read_proposals(read_job(job_file), job_file)]
    if json:
        print(json_format.dumps({"schema": 1, "proposals": rows}, indent=1, ensure_ascii=False))
        return 0
    print(
        f"{'mesh':<9}{'period':>8}{'angle':>7}{'solids':>8}{'ratio':>16}{'aperture':>10}{'web':>8}"
        f"{'ripple':>9}{'moiré':>9}{'volume':>8}{'wet':>7}{'cost':>6}{'margin':>8}  weakest"
    )
    print(
        f"{'':<9}{'µm':>8}{'°':>7}{'%':>8}{'':>16}{'µm':>10}{'µm':>8}{'1/mm':>9}{'':>9}"
        f"{'cm³/m²':>8}{'cm³/m²':>7}{'':>6}"
    )
    least = min(row["wet_volume_cm3_m2"] for row in rows)
    for row in rows:
        low, high = row["aperture_ratio"]
        mark = "" if row["sourced"] else "*"
        print(
            f"{row['mesh'] + mark:<9}{row['period_um']:>8.0f}{row['mesh_angle_deg']:>7.1f}"
            f"{100 * row['solids_fraction']:>8.0f}{f'{low:.3f} … {high:.3f}':>16}"
            f"{row['smallest_aperture_um']:>10.1f}{row['smallest_web_um']:>8.1f}"
            f"{row['ripple_curvature_per_mm']:>9.2g}{row['moire_contrast']:>9.2g}"
            f"{row['ink_volume_cm3_m2']:>8.1f}{row['wet_volume_cm3_m2']:>7.2f}"
            f"{row['wet_volume_cm3_m2'] / least:>6.2f}{row['margin']:>8.2f}  {row['weakest']}"
        )
    print("margin: least figure over its limit, 1 is just printable; slots; * volume computed")
    print("cost: wet resin laid down, of the least; prices of meshes are not known")
    return 0
