"""Closed forms of the groove beside what the thesis measured of it."""

from thesis.film_case import DEPTH, PITCH
from thesis.table import table

_CURVATURES = (0, 15, 30, 40, 45.13, 52.38, 57.04, 58, 60, 63.34, 70, 80)


def film_table() -> str:
    """Return fill fraction and fitted curvature against the curvature through the tips."""
    from mpfcad.film import Groove

    groove = Groove(PITCH, DEPTH)
    printed = float(groove.curvature_of_fill(0.10))
    through_fit = float(groove.curvature_of_fitted(58.0))
    rows = [
        ["fill fraction", *(f"{float(groove.fill_fraction(c)):.4f}" for c in _CURVATURES)],
        ["fitted curvature", *(f"{float(groove.fitted_curvature(c)):.1f}" for c in _CURVATURES)],
    ]
    fitted = float(groove.fitted_curvature(printed))
    fill = 100 * float(groove.fill_fraction(through_fit))
    return f"""A film printed at 10 % filling ratio was measured: the parabola fitted to
the profiler's trace had a curvature of 58 /mm. By our closed forms 10 % fill has
{printed:.1f} /mm through the tips and {fitted:.1f} /mm fitted: they bracket it. A fitted 58 /mm is
{through_fit:.1f} /mm through the tips, a fill of {fill:.1f} %.

{table(["C through the tips [1/mm]", *(f"{c:g}" for c in _CURVATURES)], rows)}
The process: screen and aperture ratio to fill fraction to curvature is [process.md](process.md)'s.
"""
