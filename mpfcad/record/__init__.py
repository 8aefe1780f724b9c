"""What was found, as plain values: gates and verdict, verification.json, measurements.

`Gate` decides by the interval; `build_verification` puts everything that was found into plain
values; `describe_…` does the same for single measures. Nothing here draws or writes a page.
"""

from mpfcad.gate import OUTCOMES, Gate, Outcome, exit_code, worst_outcome
from mpfcad.record.cell import describe_cell, describe_estimator
from mpfcad.record.colour import describe_colour
from mpfcad.record.difference import Rounded, compare_records
from mpfcad.record.file import ResinCheck
from mpfcad.record.junit import check_junit, junit_report, write_junit
from mpfcad.record.luminance import CONTRAST_FORMULA, describe_luminance
from mpfcad.record.measurement import (
    MEASUREMENT_SCHEMA,
    describe_angular,
    describe_camera,
    describe_conoscope,
    describe_contrast,
    describe_estimate,
    describe_flux,
    describe_panel,
    describe_polarisation,
    describe_uniformity,
    ratio,
)
from mpfcad.record.published import SCHEMAS, published_schema
from mpfcad.record.spread import describe_spread
from mpfcad.record.verdict import ORDER, in_order
from mpfcad.record.verification import (
    Checks,
    build_gates,
    build_verification,
    colour_gate,
    confidence_gate,
)

__all__ = [
    "CONTRAST_FORMULA",
    "MEASUREMENT_SCHEMA",
    "ORDER",
    "OUTCOMES",
    "SCHEMAS",
    "Checks",
    "Gate",
    "Outcome",
    "ResinCheck",
    "Rounded",
    "build_gates",
    "build_verification",
    "check_junit",
    "colour_gate",
    "compare_records",
    "confidence_gate",
    "describe_angular",
    "describe_camera",
    "describe_cell",
    "describe_colour",
    "describe_conoscope",
    "describe_contrast",
    "describe_estimate",
    "describe_estimator",
    "describe_flux",
    "describe_luminance",
    "describe_panel",
    "describe_polarisation",
    "describe_spread",
    "describe_uniformity",
    "exit_code",
    "in_order",
    "junit_report",
    "published_schema",
    "ratio",
    "worst_outcome",
    "write_junit",
]
