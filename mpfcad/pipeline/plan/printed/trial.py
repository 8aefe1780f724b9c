"""One screen tried for a map: a mesh with a solids fraction, its best pattern, and its margin."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import Groove, Process
from mpfcad.job import Job
from mpfcad.mask.fabric import Mesh
from mpfcad.mask.screen.printing import LUMINANCE_RESPONSE, curvature_ripple
from mpfcad.pipeline.plan.printed.fit import SPARE, Fit, fit_dots, fit_slots
from mpfcad.pipeline.plan.printed.process import read_job_process
from mpfcad.pipeline.plan.printed.screen import job_levelling, with_mesh
from mpfcad.units import deg, um

#: Solids fractions that are tried.
SOLIDS = tuple(round(0.2 + 0.05 * k, 2) for k in range(17))
#: Angle of a mesh to the grooves before the weakest moiré is looked for [°].
FIRST_ANGLE = 22.5
#: A ripple this far below its limit counts no more.
ENOUGH = 3.0


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


def rank(row: Proposal) -> tuple[float, bool, float]:
    """Order of screens: margin in steps of 5 %, a sourced mesh, less solvent."""
    return (round(row.margin * 20) / 20, row.mesh.is_sourced, row.solids_fraction)


def try_screen(job: Job, mesh: Mesh, solids: float) -> Job:
    """Return the job with a mesh and a solids fraction."""
    process = job.process.model_copy(update={"solids_fraction": solids})
    process.model_fields_set.add("solids_fraction")
    changed = with_mesh(job, mesh).model_copy(update={"process": process})
    changed.model_fields_set.add("process")
    return changed


def trial_process(
    job: Job, job_file: Path, mesh: Mesh, solids: float, groove: Groove
) -> tuple[Job, Process]:
    """Return the job with a mesh and a solids fraction, and its process.

    Raises
    ------
    InputError
        when more resin leaves the screen than the mesh holds, or the calibration is wrong.
    """
    calibration = job.process.calibration
    file = None if calibration is None else job_file.parent / calibration
    trial = try_screen(job, mesh, solids)
    process = read_job_process(trial, file, groove, str(job_file))
    assert process is not None  # with_screen has looked
    return trial, process


def best_row(
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
    return max(rows, key=rank, default=None)


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
        "ripple_per_mm": gates.ripple_curvature_per_mm / max(ripple, 1e-12),
        "ripple_luminance": gates.ripple_luminance / max(ripple * LUMINANCE_RESPONSE, 1e-12),
        "aperture_um": fit.aperture / limits[0] * (ENOUGH / SPARE),
    }
    weakest = min(figures, key=lambda name: figures[name])
    return Proposal(
        mesh, job.process.solids_fraction, fit.pattern, fit.period, FIRST_ANGLE * deg, low, high,
        fit.aperture, fit.web, ripple, math.nan, wet, min(ENOUGH, figures[weakest]), weakest,
    )  # fmt: skip
