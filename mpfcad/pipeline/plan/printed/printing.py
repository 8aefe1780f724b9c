"""What a job's screen prints, and the limits that it is judged by."""

from mpfcad.film import Process
from mpfcad.job import Job
from mpfcad.mask import Mask
from mpfcad.mask.screen.printing import Printing, find_printing
from mpfcad.pipeline.plan.printed.process import implied_release
from mpfcad.record.printing import PrintLimits
from mpfcad.units import um


def plan_printing(job: Job, mask: Mask, process: Process) -> Printing:
    """Return what the screen of a job prints of its mask."""
    mesh, release = mask.rules.mesh, None
    if mesh is not None:
        release = implied_release(process, mesh, job.process.solids_fraction)
        if release is not None and not _is_calibrated(job):
            release = (release[0], None)  # what the job, or the prior, puts in; at most 1
    return find_printing(mask, process, job.mask.registration_um * um, release)


def _is_calibrated(job: Job) -> bool:
    return job.process.calibration is not None or job.process.model == "thesis"


def job_print_limits(job: Job) -> PrintLimits:
    """Return the limits of the job's `[gates]`."""
    gates = job.gates
    return PrintLimits(
        ratio_min=gates.ratio_min,
        ratio_max=gates.ratio_max,
        ripple_curvature=gates.ripple_curvature_per_mm,
        ripple_luminance=gates.ripple_luminance,
        registration_curvature=gates.registration_curvature_per_mm,
    )
