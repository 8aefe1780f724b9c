"""The verdict and how it is told: gates, verification.json, and the HTML report.

`Gate` decides by the interval; `build_verification` puts everything that was found into plain
values; `write_report` makes the page that a person can decide from.
"""

from mpfcad.report.compare_page import write_compare_page
from mpfcad.report.design_page import write_design_page
from mpfcad.report.evidence import Evidence
from mpfcad.report.measure_page import write_measure_page
from mpfcad.report.measurement import (
    MEASUREMENT_SCHEMA,
    describe_angular,
    describe_camera,
    describe_conoscope,
    describe_contrast,
    describe_estimate,
    describe_flux,
    describe_panel,
    describe_uniformity,
    ratio,
)
from mpfcad.report.page import write_report
from mpfcad.report.picture import PICTURES, write_pictures
from mpfcad.report.sweep_page import write_sweep_page
from mpfcad.report.thickness_section import limit_words, range_words
from mpfcad.report.verdict import OUTCOMES, Gate, Outcome, exit_code, worst_outcome
from mpfcad.report.verification import (
    CONTRAST_FORMULA,
    Checks,
    build_gates,
    build_verification,
    describe_luminance,
    find_difference,
)

__all__ = [
    "CONTRAST_FORMULA",
    "MEASUREMENT_SCHEMA",
    "OUTCOMES",
    "PICTURES",
    "Checks",
    "Evidence",
    "Gate",
    "Outcome",
    "build_gates",
    "build_verification",
    "describe_angular",
    "describe_camera",
    "describe_conoscope",
    "describe_contrast",
    "describe_estimate",
    "describe_flux",
    "describe_luminance",
    "describe_panel",
    "describe_uniformity",
    "exit_code",
    "find_difference",
    "limit_words",
    "range_words",
    "ratio",
    "worst_outcome",
    "write_compare_page",
    "write_design_page",
    "write_measure_page",
    "write_pictures",
    "write_report",
    "write_sweep_page",
]
