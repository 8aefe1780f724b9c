"""What the eye makes of a cell's luminance: its worst harmonic, and its SEMU; information only."""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from mpfcad.measure.cell.series import CellSeries
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.eye import PANEL_TRANSMITTANCE, threshold_contrast

#: Places along each axis at which what is brighter and darker than the mean is told apart.
_FINE = 64


@dataclass(frozen=True)
class Visibility:
    """The harmonic that is farthest over the eye's threshold, or least below it.

    Attributes
    ----------
    harmonic
        its numbers across and along
    wavelength
        of its grating [mm]; of a pair, that of the two diagonal ones
    threshold
        contrast of such a grating that is seen half of the time (Barten 2003)
    over_threshold
        its amplitude over the mean, over that threshold; below 1 it is not seen
    """

    harmonic: tuple[int, int]
    wavelength: float
    threshold: float
    over_threshold: Estimate


def worst_harmonic(
    series: CellSeries, size: tuple[float, float], distance: float
) -> Visibility | None:
    """Return the worst harmonic for an eye at `distance` [mm] of a cell of `size` [mm].

    The harmonics are those of the series, and it is the worst as they are read: noise can make one
    the worst, so the value is rather too large. None of a series without harmonics.
    """
    found: list[Visibility] = []
    seen = series.mean.value * PANEL_TRANSMITTANCE
    orders = range(series.harmonics + 1)
    for pair in product(orders, orders):
        if not any(pair) or not np.all((series.order + 1) // 2 == pair, axis=1).any():
            continue
        wavelength = 1 / math.hypot(pair[0] / size[0], pair[1] / size[1])
        threshold = threshold_contrast(wavelength, distance, seen)
        amplitude = series.amplitude(*pair)
        share = (amplitude.value, amplitude.low, amplitude.high)
        over = Estimate.within(*(part / threshold for part in share))
        found.append(Visibility(pair, wavelength, threshold, over))
    return max(found, key=lambda one: one.over_threshold.value, default=None)


@dataclass(frozen=True)
class Semu:
    """SEMU of the part of a cell that is brighter, or darker, than its mean.

    Attributes
    ----------
    part
        `above` or `below` the mean
    area
        of that part in a cell [mm²], S
    value
        |Cx|/(1.97/S^0.33 + 0.72), Cx its mean departure from the mean of the rest [%]
    """

    part: str
    area: float
    value: Estimate


def semu(series: CellSeries, size: tuple[float, float]) -> Semu:
    """Return the larger SEMU of a cell's bright and dark parts.

    SEMI D31-1102: Cjnd = 1.97/S^0.33 + 0.72 (%), fitted to isolated spots at 50 cd/m² and 500 mm,
    so it is lax for a lattice of them. The interval is that of the parts as they are read: which
    places are bright is taken as known.
    """
    place = (np.arange(_FINE) + 0.5) / _FINE
    at = series.at(*(part.ravel() for part in np.meshgrid(place, place, indexing="ij")))
    bright = at @ series.coefficient > series.coefficient[0]
    if bright.all() or not bright.any():
        return Semu("above", float(size[0] * size[1]), Estimate.within(0.0, 0.0, 0.0))
    rise = at[bright].mean(axis=0) - at[~bright].mean(axis=0)
    error = float(np.sqrt(rise @ series.covariance @ rise))
    step = Estimate.student(float(rise @ series.coefficient), error, series.freedom)
    found = []
    for name, chosen, ground in (("above", bright, ~bright), ("below", ~bright, bright)):
        area = float(chosen.mean() * size[0] * size[1])
        level = float(at[ground].mean(axis=0) @ series.coefficient)
        share = 100 / level / (1.97 / area**0.33 + 0.72)
        low, high = max(step.low, 0.0) * share, step.high * share
        found.append(Semu(name, area, Estimate.within(step.value * share, low, high)))
    return max(found, key=lambda one: one.value.value)
