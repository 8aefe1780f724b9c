"""A measured surface in the parabola's place: one groove averaged from a stylus trace."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.fit import fit_stylus_trace
from mpfcad.film.stylus.trace import StylusTrace

#: Straight pieces across one groove.
PIECES = 50
#: Corners that lie nearer to a line [mm] are left out: less than a stylus tells, and each piece
#: costs a CAD kernel a face.
STRAIGHT = 5e-6


def average_groove(trace: StylusTrace, groove: Groove, profile: Profile) -> NDArray[np.float64]:
    """Return the groove's mean surface, (k, 2) float64 [mm]: x from its centre -w … w, height.

    The trace is levelled and centred as `fit_stylus_trace` does; then the polyline of equal steps
    that fits all its heights best is taken, its two ends the same tip, and its corners that lie in
    a line within `STRAIGHT` left out: k is at most 51.

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
    return _thinned(np.column_stack([x, np.append(height, height[0])]))


def _thinned(point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of a polyline that keep it within `STRAIGHT` (Ramer 1972)."""
    kept = np.zeros(len(point), bool)
    kept[[0, -1]] = True
    spans = [(0, len(point) - 1)]
    while spans:
        first, last = spans.pop()
        chord = point[last] - point[first]
        away = point[first + 1 : last] - point[first]
        distance = np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]) / np.hypot(*chord)
        if len(distance) and distance.max() > STRAIGHT:
            middle = first + 1 + int(distance.argmax())
            kept[middle] = True
            spans += [(first, middle), (middle, last)]
    return point[kept]
