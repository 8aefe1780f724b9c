"""The whole way: job -> plan -> files -> examined from the files -> verdict and report.

`run_job` makes an export folder that appears whole or not at all; `verify_export` finds every
figure of one again from its own files, through the same code; `make_mask`, `make_cad` and
`trace_mesh` are the single steps; `measure_film` finds every photometric figure of a film.
"""

from mpfcad.pipeline.confidence.covariance import with_covariance
from mpfcad.pipeline.design.run import default_design_out, run_design
from mpfcad.pipeline.effort import TRACE_SETTINGS, TraceSetting
from mpfcad.pipeline.fit.fit import FitSetting, default_fit_out, fit_backlight
from mpfcad.pipeline.measure.case import Case, job_case, read_case
from mpfcad.pipeline.measure.compare import compare_cases
from mpfcad.pipeline.measure.figures import WHAT, Measuring
from mpfcad.pipeline.measure.led_case import read_cases
from mpfcad.pipeline.measure.measure import default_measure_out, default_what, measure_film
from mpfcad.pipeline.measure.rays import write_rays
from mpfcad.pipeline.measure.trace import trace_mesh
from mpfcad.pipeline.plan.need import available_memory, run_need
from mpfcad.pipeline.plan.plan import Plan, read_plan
from mpfcad.pipeline.plan.restored import restore_plan
from mpfcad.pipeline.progress import SILENT, Progress, Silent
from mpfcad.pipeline.run.make import CAD_FORMATS, MASK_FORMATS
from mpfcad.pipeline.run.mask_plan import MaskPlan, read_mask_plan, read_proposals
from mpfcad.pipeline.run.mould import MouldSetting, make_mould
from mpfcad.pipeline.run.reissue import changed_job, restore_mask_plan
from mpfcad.pipeline.run.run import (
    checked_masks,
    default_out,
    make_cad,
    make_mask,
    make_planned_mask,
    run_job,
)
from mpfcad.pipeline.run.verify import verify_export
from mpfcad.pipeline.sweep.run import default_sweep_out, run_sweep

__all__ = [
    "CAD_FORMATS",
    "MASK_FORMATS",
    "SILENT",
    "TRACE_SETTINGS",
    "WHAT",
    "Case",
    "FitSetting",
    "MaskPlan",
    "Measuring",
    "MouldSetting",
    "Plan",
    "Progress",
    "Silent",
    "TraceSetting",
    "available_memory",
    "changed_job",
    "checked_masks",
    "compare_cases",
    "default_design_out",
    "default_fit_out",
    "default_measure_out",
    "default_out",
    "default_sweep_out",
    "default_what",
    "fit_backlight",
    "job_case",
    "make_cad",
    "make_mask",
    "make_mould",
    "make_planned_mask",
    "measure_film",
    "read_case",
    "read_cases",
    "read_mask_plan",
    "read_plan",
    "read_proposals",
    "restore_mask_plan",
    "restore_plan",
    "run_design",
    "run_job",
    "run_need",
    "run_sweep",
    "trace_mesh",
    "verify_export",
    "with_covariance",
    "write_rays",
]
