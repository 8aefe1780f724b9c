"""The program from Python: a job, a design or a sweep as an object, and results with units.

`Job`, `Design`, `Sweep` and `Fit` are made from a file, a dict, or an array of curvature; their
methods do what the commands of the same names do and return results whose figures are numbers with
intervals and xarray datasets with units in their names. `mpfcad` hands on all public names.
"""

from mpfcad.api.design import Design, DesignResult
from mpfcad.api.figure import Figure
from mpfcad.api.film import trace, verify
from mpfcad.api.fit import Fit, FitResult
from mpfcad.api.job import Job
from mpfcad.api.result import Export, Measurement, Run, Trace
from mpfcad.api.sweep import Sweep, SweepResult

__all__ = [
    "Design",
    "DesignResult",
    "Export",
    "Figure",
    "Fit",
    "FitResult",
    "Job",
    "Measurement",
    "Run",
    "Sweep",
    "SweepResult",
    "Trace",
    "trace",
    "verify",
]
