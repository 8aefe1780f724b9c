"""A measured surface in the parabola's place: one groove averaged from a stylus trace."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.fit import fit_stylus_trace
from mpfcad.film.stylus.trace import StylusTrace

#: Straight pieces across one groove.
PIECES = 50


def average_groove(trace: StylusTrace, groove: Groove, profile: Profile) -> NDArray[np.float64]:
    """Return the groove's mean surface, (51, 2) float64 [mm]: x from its centre -w … w, height.

    The trace is levelled and centred as `fit_stylus_trace` does; then the polyline of equal steps
    that fits all its heights best is taken, its two ends the same tip.

    Raises
    ------
    InputError
        when the trace does not show grooves of this pitch and depth.
    """
    widths = int((trace.position[-1] - trace.position[0]) / groove.pitch * (1 + 1e-9))
    fit = fit_stylus_trace(trace, groove, profile, max(widths, 2))
    place = (fit.position + groove.half_width) / groove.pitch * PIECES
    left = np.clip(place.astype(int), 0, PIECES - 1)
    share = place - left
    basis = np.zeros((len(place), PIECES))
    row = np.arange(len(place))
    basis[row, left] += 1 - share
    basis[row, (left + 1) % PIECES] += share
    height = np.linalg.lstsq(basis, fit.height, rcond=None)[0]
    x = np.linspace(-groove.half_width, groove.half_width, PIECES + 1)
    return np.column_stack([x, np.append(height, height[0])])
