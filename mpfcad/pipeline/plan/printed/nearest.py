"""The refusal of a map that no mesh prints: which grooves, and the nearest map that is printed."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import Groove, groove_ranges
from mpfcad.job import Job
from mpfcad.mask.fabric import Mesh
from mpfcad.pipeline.plan.printed.trial import SOLIDS, Proposal, best_row, trial_process

#: Ranges that are tried, nearest first, for one that some period holds.
MOST_TRIED = 60
#: Share of the printable ratios at either end that is left out, for rounding.
SPARE_RATIO = 0.02


@dataclass(frozen=True, eq=False)
class Asked:
    """What a screen has to print.

    Attributes
    ----------
    curvature
        (n,) float64 [1/mm]
    field
        of the job that it comes from
    is_grooves
        whether it is one a groove, so that grooves can be named
    """

    curvature: NDArray[np.float64]
    field: str = "map"
    is_grooves: bool = True


def refuse_map(
    job: Job,
    job_file: Path,
    asked: Asked,
    groove: Groove,
    meshes: Sequence[Mesh],
    best: Proposal | None = None,
) -> NoReturn:
    """Refuse a map that no mesh prints; `best` is the screen that comes nearest to it, if any does.

    Raises
    ------
    InputError
        always: naming the grooves, and the range of curvature of the nearest map that is printed.
    """
    curvature = asked.curvature
    is_wet = groove.takes_resin(curvature)
    wet = curvature[is_wet]
    empty = f"{groove.curvature_empty:g}"
    where = f"{job_file}: {asked.field}"
    if not wet.size:
        raise InputError(
            f"{where}: no groove takes resin: expected a curvature_per_mm below {empty}"
        )
    found = _nearest(job, job_file, wet, groove, meshes)
    text = f"curvature_per_mm {wet.min():.6g} … {wet.max():.6g}: no mesh of the catalogue prints it"
    if best is not None:
        text += f" ({best.mesh.name} comes nearest, margin {best.margin:.2f} by {best.weakest})"
    if found is None:
        raise InputError(
            f"{where}: {text}: expected another process, or phototool only: no mask.mesh"
        )
    low, high, mesh, solids = found
    bad = np.flatnonzero(is_wet & ((curvature < low) | (curvature > high)))
    grooves = f"{groove_ranges(bad)}: " if asked.is_grooves and bad.size else ""
    raise InputError(
        f"{where}: {grooves}{text}: expected {low:.4g} … {high:.4g} or {empty} (no resin), the "
        f"nearest map it prints (mesh {mesh.name}, solids {solids:.0%})"
    )


def _nearest(
    job: Job, job_file: Path, wet: NDArray[np.float64], groove: Groove, meshes: Sequence[Mesh]
) -> tuple[float, float, Mesh, float] | None:
    """Return the range of curvature [1/mm] nearest to a map's that a screen prints, and which."""
    ranges: list[tuple[float, float, int, float, float, Mesh]] = []
    for mesh in meshes:
        for solids in SOLIDS:
            try:
                _, process = trial_process(job, job_file, mesh, solids, groove)
            except InputError:
                continue
            most = min(job.gates.ratio_max, process.aperture_ratio_max)
            ratio = (most * (1 - SPARE_RATIO), job.gates.ratio_min * (1 + SPARE_RATIO))
            low, high = (float(process.curvature(r)) for r in ratio)
            if low < high:
                change = max(low - wet.min(), wet.max() - high, 0.0)
                ranges.append((round(change, 3), -solids, len(ranges), low, high, mesh))
    for _, solids, _, low, high, mesh in sorted(ranges, key=lambda entry: entry[:3])[:MOST_TRIED]:
        trial, process = trial_process(job, job_file, mesh, -solids, groove)
        clipped = np.clip(wet, low, high)
        row = best_row(trial, mesh, process, groove, clipped, str(job_file))
        if row is not None and row.margin >= 1:
            return low, high, mesh, -solids
    return None
