"""The screen as a design variable: mesh, period, solids and angle that print a map, in a table.

Every mesh of the catalogue is tried with every solids fraction. The period is the shortest whose
slots and webs are cells of the mesh with a little to spare. A screen's *margin* is the least of its
figures over their limits: 1 is just printable, and the largest margin is the best screen.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import Groove, Process, check_printable, groove_ranges
from mpfcad.job import Job
from mpfcad.mask.fabric import Mesh, read_catalogue, shipped_catalogue
from mpfcad.mask.rule import MaskRules
from mpfcad.mask.screen.moire import MoireSetting, worst_contrast
from mpfcad.mask.screen.printing import LUMINANCE_RESPONSE, curvature_ripple
from mpfcad.pipeline.plan.printed.fit import SPARE, Fit, fit_dots, fit_slots
from mpfcad.pipeline.plan.printed.process import read_job_process
from mpfcad.pipeline.plan.printed.screen import job_levelling, with_mesh
from mpfcad.units import deg, um

#: Solids fractions that are tried, and angles of the mesh to the grooves [°].
SOLIDS = tuple(round(0.2 + 0.05 * k, 2) for k in range(17))
ANGLES = (22.5, 7.5, 15.0, 30.0, 37.5)
#: Rows of the table; a ripple this far below its limit counts no more.
MOST_ROWS, ENOUGH = 12, 3.0


@dataclass(frozen=True, eq=False)
class Proposal:
    """One screen for a map; lengths in mm.

    Attributes
    ----------
    mesh
        with the job's emulsion
    solids_fraction, pattern, period, angle
        of the resin; slots or dots, and their period; of the threads to the grooves [rad]
    ratio_min, ratio_max
        of the open grooves
    aperture, web
        smallest
    ripple
        root mean square of the curvature [1/mm] after levelling, the worse of both ends
    moire
        contrast of the strongest beat; NaN as long as it is not computed
    wet_volume
        mean volume that is printed [mm, = 1000 cm³/m²]
    margin
        least figure over its limit; 1 is just printable
    weakest
        which figure that is
    """

    mesh: Mesh
    solids_fraction: float
    pattern: Literal["slot", "dot"]
    period: float
    angle: float
    ratio_min: float
    ratio_max: float
    aperture: float
    web: float
    ripple: float
    moire: float
    wet_volume: float
    margin: float
    weakest: str

    def document(self) -> dict[str, Any]:
        """Return it in outside names, fit for JSON."""
        return {
            "mesh": self.mesh.name,
            "sourced": self.mesh.is_sourced,
            "pattern": self.pattern,
            "period_um": self.period / um,
            "mesh_angle_deg": self.angle / deg,
            "solids_fraction": self.solids_fraction,
            "aperture_ratio": [self.ratio_min, self.ratio_max],
            "smallest_aperture_um": self.aperture / um,
            "smallest_web_um": self.web / um,
            "ripple_curvature_per_mm": self.ripple,
            "ripple_luminance": self.ripple * LUMINANCE_RESPONSE,
            "moire_contrast": self.moire,
            "ink_volume_cm3_m2": self.mesh.volume / um,
            "wet_volume_cm3_m2": self.wet_volume / um,
            "margin": self.margin,
            "weakest": self.weakest,
        }

    def reason(self) -> str:
        """Return why this screen, in a line."""
        return (
            f"mesh {self.mesh.name}, period {self.period / um:g} µm, {self.pattern}s, solids "
            f"{self.solids_fraction:.0%}: margin {self.margin:.2f} by {self.weakest}; ratio "
            f"{self.ratio_min:.3f} … {self.ratio_max:.3f}, ripple {self.ripple:.2g} /mm, moiré "
            f"{self.moire:.2g}"
        )


def propose(
    job: Job, job_file: Path, curvature: NDArray[np.float64], groove: Groove
) -> list[Proposal]:
    """Return screens for grooves of the given curvatures [1/mm], best first, one a mesh.

    Raises
    ------
    InputError
        when a file is wrong, or no mesh prints any of it.
    """
    calibration = job.process.calibration
    file = None if calibration is None else job_file.parent / calibration
    found: list[Proposal] = []
    refusals: list[str] = []
    for mesh in _catalogue(job, job_file):
        best: Proposal | None = None
        for solids in SOLIDS:
            try:
                trial = _trial(job, mesh, solids)
                process = read_job_process(trial, file, groove, str(job_file))
                assert process is not None
                check_printable(process, curvature, str(job_file))
                row = _row(trial, mesh, process, groove, curvature, str(job_file))
            except InputError as error:
                refusals.append(str(error))
                continue
            if row is not None and (best is None or _rank(row) > _rank(best)):
                best = row
        if best is not None:
            found.append(best)
    if not found:
        raise InputError(refusals[-1] if refusals else f"{job_file}: mask.mesh: no mesh to try")
    found.sort(key=_rank, reverse=True)
    shown = [_with_angle(job, row, groove) for row in found[:MOST_ROWS]]
    return sorted(shown, key=_rank, reverse=True)


def _catalogue(job: Job, job_file: Path) -> tuple[Mesh, ...]:
    table = job.mask.mesh
    if table is not None and table.catalogue is not None:
        return read_catalogue(job_file.parent / table.catalogue)
    return shipped_catalogue()


def _rank(row: Proposal) -> tuple[float, bool, float]:
    """Order of screens: margin in steps of 5 %, a sourced mesh, less solvent."""
    return (round(row.margin * 20) / 20, row.mesh.is_sourced, row.solids_fraction)


def _trial(job: Job, mesh: Mesh, solids: float) -> Job:
    """Return the job with a mesh and a solids fraction."""
    process = job.process.model_copy(update={"solids_fraction": solids})
    process.model_fields_set.add("solids_fraction")
    changed = with_mesh(job, mesh).model_copy(update={"process": process})
    changed.model_fields_set.add("process")
    return changed


def _row(
    job: Job,
    mesh: Mesh,
    process: Process,
    groove: Groove,
    curvature: NDArray[np.float64],
    where: str,
) -> Proposal | None:
    """Return a mesh's screen; None when no period holds its slots or dots."""
    coated = mesh.coated(0.0 if job.mask.mesh is None else job.mask.mesh.emulsion)
    ratio = process.aperture_ratio_of_curvature(curvature[groove.takes_resin(curvature)])
    if not ratio.size:
        raise InputError(
            f"{where}: map: no groove takes resin: expected a curvature_per_mm below "
            f"{groove.curvature_empty:g}"
        )
    ends = (float(ratio.min()), float(ratio.max()))
    cell = coated.min_feature
    limits = (max(cell, job.mask.min_aperture), max(cell, job.mask.min_web))
    levelling = job_levelling(job, process, groove, ends[0], where) or job.mask.levelling_length
    fits = (
        fit_slots(ends, limits, levelling),
        fit_dots(ends, limits, groove.pitch, levelling),
    )
    fill = groove.fill_fraction(curvature)
    wet = float(fill.mean()) * groove.area / groove.pitch / job.process.solids_fraction
    rows = [_judged(job, coated, process, fit, ends, limits, wet) for fit in fits if fit]
    return max(rows, key=_rank, default=None)


def _judged(
    job: Job,
    mesh: Mesh,
    process: Process,
    fit: Fit,
    ends: tuple[float, float],
    limits: tuple[float, float],
    wet: float,
) -> Proposal:
    """Return a pattern's screen with its margin; `wet` is the mean volume printed [mm]."""
    low, high = ends
    ripple = float(curvature_ripple(process, np.array(ends), fit.residual).max())
    gates = job.gates
    figures = {
        "ratio_min": low / max(gates.ratio_min, 1e-9),
        "ratio_max": (1 - high) / max(1 - gates.ratio_max, 1e-9),
        "ripple_per_mm": min(ENOUGH, gates.ripple_curvature_per_mm / max(ripple, 1e-12)),
        "ripple_luminance": min(
            ENOUGH, gates.ripple_luminance / max(ripple * LUMINANCE_RESPONSE, 1e-12)
        ),
        "aperture_um": fit.aperture / limits[0] * (ENOUGH / SPARE),
    }
    weakest = min(figures, key=lambda name: figures[name])
    return Proposal(
        mesh, job.process.solids_fraction, fit.pattern, fit.period, ANGLES[0] * deg, low, high,
        fit.aperture, fit.web, ripple, math.nan, wet, figures[weakest], weakest,
    )  # fmt: skip


def _with_angle(job: Job, row: Proposal, groove: Groove) -> Proposal:
    """Return a screen with the angle of the weakest moiré."""
    from dataclasses import replace

    rules = MaskRules(
        row.pattern, row.period, job.mask.min_aperture, job.mask.min_web,
        levelling_length=job.mask.levelling_length, mesh=row.mesh,
    )  # fmt: skip
    mean = (row.ratio_min + row.ratio_max) / 2
    worst = []
    for angle in ANGLES:
        setting = MoireSetting(angle * deg, job.mask.pixel, job.mask.viewing_distance)
        worst.append(worst_contrast(rules, setting, groove.pitch, mean))
        if worst[-1] == 0:
            break
    best = int(np.argmin(np.round(worst, 6)))
    return replace(row, angle=ANGLES[best] * deg, moire=worst[best])


def choose_screen(
    job: Job, job_file: Path, curvature: NDArray[np.float64], groove: Groove
) -> tuple[Job, str]:
    """Return the job with the best screen in place of `mask.mesh = "auto"`, and why that one.

    `curvature` [1/mm] is every one that the screen has to print, one axis.

    Raises
    ------
    InputError
        naming the grooves that no mesh prints, and the nearest map that one does.
    """
    best = propose(job, job_file, curvature, groove)[0]
    if best.margin < 1:
        raise InputError(_nearest_map(job, job_file, best, curvature, groove))
    chosen = _trial(job, best.mesh, best.solids_fraction)
    table = chosen.mask.mesh
    assert table is not None
    table = table.model_copy(update={"angle_deg": best.angle / deg})
    table.model_fields_set.add("angle_deg")
    update = {"period_um": round(best.period / um, 6), "mesh": table, "pattern": best.pattern}
    mask = chosen.mask.model_copy(update=update)
    mask.model_fields_set.update(update)
    return chosen.model_copy(update={"mask": mask}), best.reason()


def with_screen(
    job: Job, job_file: Path, curvature: NDArray[np.float64], groove: Groove
) -> tuple[Job, str | None]:
    """Return a job with a screen chosen where it says `auto`, and why; else the job itself."""
    table = job.mask.mesh
    if table is None or not table.is_auto:
        return job, None
    if job.film.profile != "filled" or job.film.cell != "groove":
        return job.model_copy(update={"mask": job.mask.model_copy(update={"mesh": None})}), None
    return choose_screen(job, job_file, curvature, groove)


def _nearest_map(
    job: Job, job_file: Path, best: Proposal, curvature: NDArray[np.float64], groove: Groove
) -> str:
    """Return the refusal of a map that no mesh prints."""
    calibration = job.process.calibration
    file = None if calibration is None else job_file.parent / calibration
    trial = _trial(job, best.mesh, best.solids_fraction)
    process = read_job_process(trial, file, groove, str(job_file))
    assert process is not None
    low, high = (
        float(process.curvature(min(ratio, process.aperture_ratio_max)))
        for ratio in (job.gates.ratio_max, job.gates.ratio_min)
    )
    is_open = groove.takes_resin(curvature)
    bad = np.flatnonzero(is_open & ((curvature < low) | (curvature > high)))
    which = groove_ranges(bad) if bad.size else f"{best.weakest}"
    return (
        f"{job_file}: map: {which}: curvature_per_mm {curvature.min():.4g} … "
        f"{curvature[is_open].max():.4g}: no mesh of the catalogue prints that (best: "
        f"{best.reason()}): expected {low:.4g} … {high:.4g}, the nearest map it prints, or 80 (no "
        f"resin)"
    )
