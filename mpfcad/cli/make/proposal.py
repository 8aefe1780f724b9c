"""The table of `mpfcad mask --propose`, and what of its first row goes into the job."""

from pathlib import Path
from typing import Any

_HEAD = (
    f"{'mesh':<14}{'pattern':<8}{'period':>8}{'angle':>7}{'solids':>8}{'ratio':>16}"
    f"{'aperture':>10}{'web':>8}{'ripple':>9}{'moiré':>9}{'volume':>8}{'wet':>7}{'cost':>6}"
    f"{'margin':>8}  weakest"
)
_UNITS = (
    f"{'':<22}{'µm':>8}{'°':>7}{'%':>8}{'':>16}{'µm':>10}{'µm':>8}{'1/mm':>9}{'':>9}"
    f"{'cm³/m²':>8}{'cm³/m²':>7}{'':>6}"
)


def print_proposals(job_file: Path, json: bool) -> int:
    """Print the screens that print a job's map."""
    import json as json_format

    from mpfcad.job import read_job
    from mpfcad.pipeline import read_proposals
    from mpfcad.pipeline.plan.printed.paste import command_line, dilution, job_lines

    job = read_job(job_file)
    found = read_proposals(job, job_file)
    rows = [
        {
            **row.document(),
            "job_lines": job_lines(job, row),
            "command": command_line(job, str(job_file), row),
        }
        for row in found
    ]
    if json:
        print(json_format.dumps({"schema": 1, "proposals": rows}, indent=1, ensure_ascii=False))
        return 0
    print(_HEAD)
    print(_UNITS)
    least = min(row["wet_volume_cm3_m2"] for row in rows)
    for row in rows:
        _print_row(row, least)
    print("margin: least figure over its limit, 1 is just printable, 3 counts as enough")
    print("order: margin; of the same, sourced volumes before computed ones (*); then cost")
    print("cost: wet resin laid down, of the least; prices of meshes are not known")
    if any(dilution(job, row) for row in found):
        own = job.process.solids_fraction
        print(f"solids: what the resin has to be diluted to; the job's has {own:.0%}")
    print("\nThe first of them, instead of these keys in the job:\n")
    print("\n".join(rows[0]["job_lines"]))
    if rows[0]["command"]:
        print(f"\nor its mask at once:\n\n{rows[0]['command']}")
    return 0


def _print_row(row: dict[str, Any], least: float) -> None:
    low, high = row["aperture_ratio"]
    mark = "" if row["sourced"] else "*"
    print(
        f"{row['mesh'] + mark:<14}{row['pattern']:<8}{row['period_um']:>8.0f}"
        f"{row['mesh_angle_deg']:>7.1f}"
        f"{100 * row['solids_fraction']:>8.0f}{f'{low:.3f} … {high:.3f}':>16}"
        f"{row['smallest_aperture_um']:>10.1f}{row['smallest_web_um']:>8.1f}"
        f"{row['ripple_curvature_per_mm']:>9.2g}{row['moire_contrast']:>9.2g}"
        f"{row['ink_volume_cm3_m2']:>8.1f}{row['wet_volume_cm3_m2']:>7.2f}"
        f"{row['wet_volume_cm3_m2'] / least:>6.2f}{row['margin']:>8.2f}  {row['weakest']}"
    )
