"""A backlight's values from measurements: straight readings, least squares, what is left free.

`Unknowns` are the values with their priors, `fit_line` tells how the readings of a view follow
them, a `Datum` is a measured figure of a view, `search_values` finds values and covariance,
`rank_next` what to measure next.
"""

from mpfcad.fit.advice import rank_next
from mpfcad.fit.datum import Datum, Figured
from mpfcad.fit.linear import Line, fit_line
from mpfcad.fit.posterior import Posterior, fit_values
from mpfcad.fit.search import Found, search_values
from mpfcad.fit.unknown import Unknowns, build_unknowns

__all__ = [
    "Datum",
    "Figured",
    "Found",
    "Line",
    "Posterior",
    "Unknowns",
    "build_unknowns",
    "fit_line",
    "fit_values",
    "rank_next",
    "search_values",
]
