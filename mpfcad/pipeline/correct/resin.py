"""What prints the next map: the process as coupons show it, and how dilute the resin is.

A process that prints more resin than was assumed leaves less of the range of C to the next map: the
smallest aperture that a screen holds gives too much. Thinner resin gives it back. So where C lies
at its limits, other shares of solids may be asked for.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpfcad.design import Constraint
from mpfcad.errors import InputError
from mpfcad.film import Process, read_process
from mpfcad.job import Job, build_job
from mpfcad.job.design import Design
from mpfcad.pipeline.design.aim import design_constraint
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.restored import restore_process

#: The calibration beside the next job.
PROCESS = "process.toml"
#: Solids fractions that are tried, over that of the print.
LADDER = (1.4, 1.2, 0.85, 0.7, 0.6, 0.5, 0.4, 0.3)


@dataclass(frozen=True, eq=False)
class Resin:
    """A process that the next map may be printed with.

    Attributes
    ----------
    document
        the next job but for its map
    process
        what it prints
    constraint
        what of it a design may use
    """

    document: dict[str, Any]
    process: Process
    constraint: Constraint

    def solids_for(self, plan: Plan) -> float:
        """Return the share of solids of the next print: of a table that of the resin printed."""
        if self.process.kind == "table":
            return plan.job.process.solids_fraction
        return float(self.document.get("process", {}).get("solids_fraction", 1.0))


def calibration_of(plan: Plan, file: Path | None) -> str | None:
    """Return the text of the calibration that holds for the print."""
    return plan.calibration if file is None else file.read_text("utf-8")


def printed_process(plan: Plan, file: Path | None) -> Process:
    """Return the process as printed: of the coupons, if there are any, as the next job reads them.

    Raises
    ------
    InputError
        when the calibration does not fit the job's screen.
    """
    if file is None:
        assert plan.process is not None
        return plan.process
    return _process(build_job(_document(plan, file), plan.job.name), plan, file)


def refuse_table(process: Process, solids: object) -> None:
    """Refuse other resin with a calibration that does not say what it gives.

    Raises
    ------
    InputError
        for a table.
    """
    if solids is not None and process.kind == "table":
        raise InputError(
            f"--solids: {solids}: expected to be left out with a table: its rows are of the resin "
            "that was printed"
        )


def find_resin(
    plan: Plan, design: Design, file: Path | None, where: Path, solids: float | None = None
) -> Resin:
    """Return the process for a share of solids, or for that of the print.

    Raises
    ------
    InputError
        when nothing can be printed.
    """
    document = _document(plan, file)
    if solids is not None:
        table = {**document.get("process", {}), "solids_fraction": solids}
        document = {**document, "process": table}
    job = build_job(document, plan.job.name)
    process = _process(job, plan, file)
    return Resin(document, process, design_constraint(design, job, process, where))


def _process(job: Job, plan: Plan, file: Path | None) -> Process:
    process = restore_process(job, calibration_of(plan, file), str(file or plan.job.name))
    assert process is not None
    return process


def _document(plan: Plan, file: Path | None) -> dict[str, Any]:
    """Return the printed job, with a calibration without what a calibration says itself."""
    document = dict(plan.job.given())
    if file is None:
        return document
    process = read_process(file, plan.job.film.groove)
    table = {**document.get("process", {}), "calibration": PROCESS}
    table.pop("model", None)
    if process.kind == "table":
        # Its rows are of the resin that was printed, however thin that was.
        table.pop("solids_fraction", None)
    document["process"] = table
    if "mesh" in document.get("mask", {}) and isinstance(document["mask"]["mesh"], dict):
        mesh = {k: v for k, v in document["mask"]["mesh"].items() if k != "release"}
        document["mask"] = {**document["mask"], "mesh": mesh}
    if process.fill_deviation(0.5) is not None and "confidence" in document:
        own = {k: v for k, v in document["confidence"].items() if k != "resin_percent"}
        document["confidence"] = own
    return document
