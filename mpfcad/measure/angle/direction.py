"""Meters that look from given directions at one lamp pitch as a whole."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mpfcad.measure.rounds import Lit, TraceRun, trace_rounds

if TYPE_CHECKING:
    from mpfcad.optics.base.recorder import Tally

#: Directions have errors of their own, which need blocks of their own.
_LEAST_BLOCKS = 8
FIGURE = "luminance ± {:.4f} of the largest"


def trace_directions(
    lit: Lit, run: TraceRun, polar: ArrayLike, azimuth: ArrayLike, error_goal: float
) -> "Tally":
    """Return the tally of meters toward which light leaves at polar and azimuth angles [rad].

    Each point is averaged over a lamp pitch. Azimuth 0 is along +x, across the lamps. Rounds go on
    until the points' standard errors, root mean square, are `error_goal` of the largest luminance.
    A direction's error is its `own_error`.
    """
    from mpfcad.optics.source import EYE, Source

    polar, azimuth = np.broadcast_arrays(np.asarray(polar, float), np.asarray(azimuth, float))
    pitch = lit.stack.period.across
    source = Source(
        EYE,
        np.full(polar.shape, pitch / 2),
        pitch,
        tilt_x=-np.sin(polar) * np.cos(azimuth),
        tilt_y=-np.sin(polar) * np.sin(azimuth),
        acceptance=lit.stack.acceptance,
    )

    def error(tally: "Tally") -> float:
        return float(np.sqrt(np.mean(tally.own_error**2)) / np.max(tally.radiance))

    return trace_rounds(lit, source, run, error, error_goal, FIGURE, least_blocks=_LEAST_BLOCKS)
