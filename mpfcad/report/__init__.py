"""Pages that a person can decide from: one HTML file each, with its drawings and plots.

`page` builds pages from the record; `drawing` draws what stands on them.
"""

from mpfcad.report.drawing.picture import PICTURES, write_pictures
from mpfcad.report.film.evidence import Evidence
from mpfcad.report.film.page import build_page, write_report
from mpfcad.report.page.compare_page import write_compare_page
from mpfcad.report.page.design_page import write_design_page
from mpfcad.report.page.fit_page import write_fit_page
from mpfcad.report.page.measure_page import write_measure_page
from mpfcad.report.page.sweep_page import write_sweep_page
from mpfcad.report.page.thickness_section import limit_words, range_words

__all__ = [
    "PICTURES",
    "Evidence",
    "build_page",
    "limit_words",
    "range_words",
    "write_compare_page",
    "write_design_page",
    "write_fit_page",
    "write_measure_page",
    "write_pictures",
    "write_report",
    "write_sweep_page",
]
