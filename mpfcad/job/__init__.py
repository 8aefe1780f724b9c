"""The job: the TOML file that says which film to make, how, and against which gates.

`read_job` turns the file into a frozen `Job`; unknown keys are refused, and whatever is wrong
becomes one `InputError` line that names the file, the field, its value and what is expected.
"""

from mpfcad.job.halftone import HalftoneTable
from mpfcad.job.model import (
    EFFORTS,
    BaselineTable,
    CadTable,
    ConfidenceTable,
    CrossedTable,
    Effort,
    FilmTable,
    GateTable,
    Job,
    MapTable,
    MaskTable,
    ProcessTable,
    StackTable,
    TraceTable,
)
from mpfcad.job.reader import build_job, read_job
from mpfcad.job.template import TEMPLATE, TEMPLATE_NAME

__all__ = [
    "EFFORTS",
    "TEMPLATE",
    "TEMPLATE_NAME",
    "BaselineTable",
    "CadTable",
    "ConfidenceTable",
    "CrossedTable",
    "Effort",
    "FilmTable",
    "GateTable",
    "HalftoneTable",
    "Job",
    "MapTable",
    "MaskTable",
    "ProcessTable",
    "StackTable",
    "TraceTable",
    "build_job",
    "read_job",
]
