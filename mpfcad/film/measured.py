"""A measured surface in the parabola's place: one groove averaged from a stylus trace."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.fit import MOST_WIDTHS, fit_stylus_trace
from mpfcad.film.stylus.tip import StylusTip, dilate, erode
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import nm

#: Straight pieces across one groove.
PIECES = 50
#: Corners that lie nearer to a line [mm] are left out: less than a stylus tells, and each piece
#: costs a CAD kernel a face.
STRAIGHT = 5e-6
#: Steps of a piece at which the tip is taken off.
FINE = 20
#: A surface that erosion gives back this close [mm] was touched by the tip.
TOUCHED = 5 * nm


def average_groove(trace: StylusTrace, groove: Groove, profile: Profile) -> NDArray[np.float64]:
    """Return the groove's mean surface, (k, 2) float64 [mm]: x from its centre -w … w, height.

    The trace is levelled and centred as `fit_stylus_trace` does; then the polyline of equal steps
    that fits all its heights best is taken, its two ends the same tip. The stylus's tip, if known,
    is taken off by erosion where it touched the surface; elsewhere the fitted groove is taken.
    Corners that lie in a line within `STRAIGHT` are left out: k is at most 51.

    Raises
    ------
    InputError
        when the trace does not show grooves of this pitch and depth.
    """
    widths = max(min(trace.widths(groove.pitch), MOST_WIDTHS), 2)
    fit = fit_stylus_trace(trace, groove, profile, widths)
    height = _mean(fit.position, fit.height, groove)
    if fit.tip is not None:
        height = _without_tip(height, _mean(fit.position, fit.surface, groove), groove, fit.tip)
    x = np.linspace(-groove.half_width, groove.half_width, PIECES + 1)
    return _thinned(np.column_stack([x, np.append(height, height[0])]))


def _mean(
    position: NDArray[np.float64], height: NDArray[np.float64], groove: Groove
) -> NDArray[np.float64]:
    """Return the polyline, (50,) float64 [mm], that fits heights best."""
    place = (position + groove.half_width) / groove.pitch * PIECES
    left = np.clip(place.astype(int), 0, PIECES - 1)
    share = place - left
    basis = np.zeros((len(place), PIECES))
    row = np.arange(len(place))
    basis[row, left] += 1 - share
    basis[row, (left + 1) % PIECES] += share
    found: NDArray[np.float64] = np.asarray(
        np.linalg.lstsq(basis, height, rcond=None)[0], np.float64
    )
    return found


def _without_tip(
    traced: NDArray[np.float64],
    fitted: NDArray[np.float64],
    groove: Groove,
    tip: StylusTip,
) -> NDArray[np.float64]:
    """Return the traced polyline (50,) eroded where the tip touched, the fitted one elsewhere."""
    step = groove.pitch / PIECES / FINE
    place = np.arange(PIECES * FINE) / FINE
    fine, model = (
        np.interp(place, np.arange(PIECES + 1), np.append(line, line[0]))
        for line in (traced, fitted)
    )
    back = erode(dilate(model, step, tip, periodic=True), step, tip, periodic=True)
    touched = back - model < TOUCHED
    eroded = erode(fine, step, tip, periodic=True)
    return np.where(touched, eroded, model)[::FINE]


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
