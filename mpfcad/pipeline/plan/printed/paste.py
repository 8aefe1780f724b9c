"""A proposed screen as lines to paste into the job, and as a command."""

from mpfcad.job import Job
from mpfcad.mask.fabric import shipped_catalogue
from mpfcad.pipeline.plan.printed.trial import Proposal
from mpfcad.units import deg, um


def job_lines(job: Job, row: Proposal) -> list[str]:
    """Return the `[process]` and `[mask]` lines of a proposal, for a job."""
    mesh = {"name": f'"{row.mesh.name}"', "angle_deg": f"{row.angle / deg:g}"}
    table = job.mask.mesh
    given = {} if table is None else table.model_dump(exclude_unset=True)
    if "catalogue" in given:
        mesh["catalogue"] = f'"{given["catalogue"]}"'
    mesh |= {name: f"{given[name]:g}" for name in ("emulsion_um", "release") if name in given}
    inline = ", ".join(f"{name} = {value}" for name, value in mesh.items())
    model = ['model = "prior"'] if job.process.model == "thesis" else []
    return [
        "[process]",
        *model,
        f"solids_fraction = {row.solids_fraction:g}",
        "[mask]",
        f'pattern = "{row.pattern}"',
        f"period_um = {row.period / um:g}",
        f"mesh = {{ {inline} }}",
    ]


def command_line(job: Job, job_file: str, row: Proposal) -> str | None:
    """Return the command that makes the mask of a proposal; None where the job has to say it."""
    if job.process.model == "thesis" or row.mesh.coated(0.0) not in shipped_catalogue():
        return None
    options = {
        "mesh": f"'{row.mesh.name}'" if " " in row.mesh.name else row.mesh.name,
        "mesh-angle-deg": f"{row.angle / deg:g}",
        "pattern": row.pattern,
        "period-um": f"{row.period / um:g}",
        "solids": f"{row.solids_fraction:g}",
    }
    words = " ".join(f"--{name} {value}" for name, value in options.items())
    return f"mpfcad mask {job_file} {words}"


def dilution(job: Job, row: Proposal) -> str:
    """Return what a proposal changes of the resin, as text; empty: nothing."""
    own = job.process.solids_fraction
    if abs(row.solids_fraction - own) < 1e-9:
        return ""
    return f"resin of {row.solids_fraction:.0%} solids, the job's has {own:.0%}"
