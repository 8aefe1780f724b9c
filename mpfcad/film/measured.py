"""A measured surface in the parabola's place: one groove averaged from a stylus trace."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove, Profile
from mpfcad.film.quadratic import fewest_pieces
from mpfcad.film.stylus.fit import MOST_WIDTHS, fit_stylus_trace
from mpfcad.film.stylus.tip import StylusTip, dilate, erode
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import nm

#: Straight pieces across one groove.
PIECES = 50
#: How near the surface's pieces come to the averaged heights [mm], or these many of their standard
#: errors where that is more: what a stylus does not tell, and each piece costs a CAD kernel a face.
NEAR, NEAR_ERRORS = 5e-6, 3.0
#: Steps of a piece at which the tip is taken off.
FINE = 20
#: A surface that erosion gives back this close [mm] was touched by the tip.
TOUCHED = 5 * nm


def average_groove(trace: StylusTrace, groove: Groove, profile: Profile) -> NDArray[np.float64]:
    """Return the groove's mean surface, (k, 3) float64: corners, and what lies between them.

    Columns: x from the groove's centre, -w … w [mm], height above the bare groove's valley [mm],
    and curvature of the piece to the right [1/mm], 0 where it is straight.

    The trace is levelled and centred as `fit_stylus_trace` does; then the polyline of equal steps
    that fits all its heights best is taken, its two ends the same tip. The stylus's tip, if known,
    is taken off by erosion where it touched the surface; elsewhere the fitted groove is taken.
    The fewest straight and parabolic pieces within `NEAR` of its corners are kept: k is at most 51.

    Raises
    ------
    InputError
        when the trace does not show grooves of this pitch and depth, or its heights are off.
    """
    widths = max(min(trace.widths(groove.pitch), MOST_WIDTHS), 2)
    fit = fit_stylus_trace(trace, groove, profile, widths)
    if fit.heights_off:
        # Resin is what lies over the stated walls: over others it would be miscounted.
        raise InputError(
            f"{trace.name}: {fit.heights_off}: expected film.depth_um of the film that was traced, "
            "or heights on their true scale"
        )
    height, error = _mean(fit.position, fit.height, groove)
    if fit.tip is not None:
        surface, _ = _mean(fit.position, fit.surface, groove)
        height = _without_tip(height, surface, groove, fit.tip)
    x = np.linspace(-groove.half_width, groove.half_width, PIECES + 1)
    point = np.column_stack([x, np.append(height, height[0])])
    return fewest_pieces(point, max(NEAR, NEAR_ERRORS * error), kept=(PIECES // 2,))


def _mean(
    position: NDArray[np.float64], height: NDArray[np.float64], groove: Groove
) -> tuple[NDArray[np.float64], float]:
    """Return the polyline, (50,) float64 [mm], that fits heights best, and its standard error."""
    place = (position + groove.half_width) / groove.pitch * PIECES
    left = np.clip(place.astype(int), 0, PIECES - 1)
    share = place - left
    basis = np.zeros((len(place), PIECES))
    row = np.arange(len(place))
    basis[row, left] += 1 - share
    basis[row, (left + 1) % PIECES] += share
    found = np.asarray(np.linalg.lstsq(basis, height, rcond=None)[0], np.float64)
    left = float(np.std(height - basis @ found))
    return found, left * float(np.sqrt(PIECES / len(height)))


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
