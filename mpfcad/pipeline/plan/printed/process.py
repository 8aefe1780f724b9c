"""From the job's `[process]` and its mesh to the printing process."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from mpfcad.errors import InputError
from mpfcad.film import PRIOR_RELEASE, Groove, Process, prior_belief, read_process
from mpfcad.film.process.model import NORMAL_95
from mpfcad.film.process.posterior import RELEASE_DEVIATION
from mpfcad.job import Job
from mpfcad.mask.fabric import Mesh, shipped_catalogue
from mpfcad.pipeline.plan.printed.screen import screen_mesh
from mpfcad.units import um

PRIOR_CAVEATS = (
    "not calibrated: the tone curve is that of a published half-tone print on paper",
    "print the step wedge, measure it, and run mpfcad calibrate",
)
LINEAR_CAVEAT = "theoretical volume of the mesh and a straight line: print and measure"


def read_job_process(
    job: Job, calibration: Path | None, groove: Groove, where: str
) -> Process | None:
    """Return the printing process; None for an `ideal` film, which no print can make, or for cells.

    A calibration counts first; else, through a mesh, its volume, release and the published tone
    curve; else the built-in pair.

    Raises
    ------
    InputError
        when calibration, model or mesh is wrong, or more resin leaves the screen than it holds.
    """
    if not job.is_printed:
        return None
    table = job.mask.mesh
    mesh = None if table is None else screen_mesh(table, where)
    model = job.process.model or ("thesis" if mesh is None else "prior")
    if calibration is not None or model == "thesis":
        _refuse_release(job, calibration, where)
        process = _calibrated(job, calibration, mesh, groove, where)
    elif mesh is None:
        raise InputError(
            f"{where}: process.model: {model}: expected a [mask.mesh] to print through"
        )
    else:
        process = _by_volume(job, mesh, model, groove)
    if mesh is not None:
        _refuse_impossible(process, mesh, job.process.solids_fraction, where)
    _refuse_width(job, process, where)
    return process


def with_reason(process: Process | None, reason: str | None) -> Process | None:
    """Return a process with the reason why its screen was chosen among its caveats."""
    if process is None or reason is None:
        return process
    return replace(process, caveats=(*process.caveats, f"chosen by the program: {reason}"))


def _refuse_width(job: Job, process: Process, where: str) -> None:
    """Refuse a second width of the resin beside the process's own."""
    stated = None if job.confidence is None else job.confidence.resin_percent
    if stated is not None and process.fill_deviation(0.5) is not None:
        raise InputError(
            f"{where}: confidence.resin_percent: {stated:g}: expected to be left out: the process "
            f"states how well it sets the resin"
        )


def _refuse_release(job: Job, calibration: Path | None, where: str) -> None:
    release = None if job.mask.mesh is None else job.mask.mesh.release
    if release is not None:
        name = "process.calibration" if calibration is not None else "process.model = thesis"
        raise InputError(
            f"{where}: mask.mesh.release: {release:g}: expected to be left out "
            f"when {name} is given: each states the transfer factor"
        )


def _calibrated(
    job: Job, calibration: Path | None, mesh: Mesh | None, groove: Groove, where: str
) -> Process:
    """Return a calibration, for the job's mesh and solids where it was made with others."""
    process = read_process(calibration, groove)
    solids, made_with = job.process.solids_fraction, process.screen
    factor = solids / made_with.get("solids_fraction", 1.0)
    width, caveats = 0.0, process.caveats
    if mesh is not None and "volume_cm3_m2" in made_with:
        volume = mesh.volume / um
        if abs(volume / made_with["volume_cm3_m2"] - 1) > 1e-6:
            factor *= volume / made_with["volume_cm3_m2"]
            width = mesh.volume_width / NORMAL_95
            caveats = (*caveats, f"calibrated through {made_with['mesh']}, scaled by ink volume")
    if factor == 1.0:
        return process
    if process.belief is not None:
        belief = process.belief.scaled(factor, width)
        return Process.build_tone(
            groove, belief, process.source, caveats, solids_fraction=solids, screen=made_with
        )
    if process.kind == "table":
        raise InputError(
            f"{where}: process.solids_fraction: {solids:g}: expected 1 with a table: its rows are "
            f"those of the resin that was printed"
        )
    scaled = Process.build(
        groove, "volume", [1.0], [process.transfer_factor * factor], process.source, caveats,
        full=solids,
    )  # fmt: skip
    return replace(scaled, screen=made_with)


def _by_volume(job: Job, mesh: Mesh, model: str, groove: Groove) -> Process:
    """Return what a mesh prints: its volume, the share of it that leaves, the tone curve."""
    stated = job.mask.mesh.release if job.mask.mesh else None
    release, solids = PRIOR_RELEASE if stated is None else stated, job.process.solids_fraction
    factor = solids * mesh.transfer_factor(groove, release)
    deviation = float(
        np.hypot(mesh.volume_width / NORMAL_95, RELEASE_DEVIATION if stated is None else 0.0)
    )
    source = (
        f"mesh {mesh.name}: {release:.0%} of {mesh.volume / um:.4g} cm³/m²"
        f"{'' if stated is not None else ' (release assumed)'}, solids {solids:.0%}, over "
        f"{groove.area / groove.pitch / um:.4g} cm³/m² of a full groove; {mesh.source}"
    )
    screen = {
        "mesh": mesh.name,
        "volume_cm3_m2": mesh.volume / um,
        "solids_fraction": solids,
    }
    computed = () if mesh.is_sourced else (_computed_caveat(mesh),)
    if model == "linear":
        caveats = (LINEAR_CAVEAT, *computed)
        process = Process.build(groove, "volume", [1.0], [factor], source, caveats, full=solids)
        return replace(process, log_deviation=deviation, screen=screen)
    return Process.build_tone(
        groove,
        prior_belief(factor, deviation),
        f"{source}; tone curve: Sefar, half-tone printing process line",
        (*PRIOR_CAVEATS, *computed),
        solids_fraction=solids,
        screen=screen,
    )


def _computed_caveat(mesh: Mesh) -> str:
    """Return what is not a weaver's figure of a mesh, and what that makes of its volume."""
    return (
        f"mesh {mesh.name}: {mesh.computed} computed from its name, no weaver's figures: ink "
        f"volume ± {mesh.volume_width:.0%}; a weaver's own go into mask.mesh"
    )


def implied_release(
    process: Process, mesh: Mesh, solids_fraction: float
) -> tuple[float, float | None] | None:
    """Return the share of the mesh's volume that leaves it, and the deviation of its logarithm.

    None for a table, which says nothing of a full area.
    """
    factor = process.transfer_factor
    if factor is None:
        return None
    deviation = process.log_deviation
    if process.belief is not None:
        deviation = float(process.belief.deviation[0])
    return mesh.release(process.groove, factor / solids_fraction), deviation


def _refuse_impossible(process: Process, mesh: Mesh, solids: float, where: str) -> None:
    """Refuse a process by which surely more resin leaves the screen than it holds."""
    found = implied_release(process, mesh, solids)
    if found is None:
        return
    release, deviation = found
    if release * np.exp(-NORMAL_95 * (deviation or 0.0)) <= 1 + 1e-9:
        return
    needed = release * mesh.volume
    enough = [m for m in shipped_catalogue() if m.volume >= needed]
    hint = f" ({enough[-1].name} would do)" if enough else ""
    raise InputError(
        f"{where}: mask.mesh: {mesh.name}: the process lays down {release:.0%} of the mesh's "
        f"{mesh.volume / um:.4g} cm³/m²: expected at most 100 %: a mesh of {needed / um:.4g} "
        f"cm³/m² or more{hint}, or leave the calibration out"
    )
