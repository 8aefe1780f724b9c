"""Finds the film for a backlight.

`estimate_operators` and `Response` are the two-scale model: the luminance of any curvature map and
its derivatives in a fraction of a second. `search_by_response` proposes maps by it and has each
traced in full; `search_by_inversion` is the published method. Maps are cosine series within a
`Constraint`.
"""

from mpfcad.design.bound import BOUND_GRID, bound_contrast
from mpfcad.design.cosine import ROWS, Constraint, cosine_basis, row_position, series_rows
from mpfcad.design.estimate import estimate_operators
from mpfcad.design.grid import Grid
from mpfcad.design.optimum import Correction, Goal, Prediction, find_optimum, predict
from mpfcad.design.reach import Reach, find_reach
from mpfcad.design.response import Operators, Response
from mpfcad.design.scenario import FilmState, Scenarios, drawn_contrasts, find_likely
from mpfcad.design.search import Iteration, Traced, best_of, correction_of, search_by_response
from mpfcad.design.thesis import search_by_inversion

__all__ = [
    "BOUND_GRID",
    "ROWS",
    "Constraint",
    "Correction",
    "FilmState",
    "Goal",
    "Grid",
    "Iteration",
    "Operators",
    "Prediction",
    "Reach",
    "Response",
    "Scenarios",
    "Traced",
    "best_of",
    "bound_contrast",
    "correction_of",
    "cosine_basis",
    "drawn_contrasts",
    "estimate_operators",
    "find_likely",
    "find_optimum",
    "find_reach",
    "predict",
    "row_position",
    "search_by_inversion",
    "search_by_response",
    "series_rows",
]
