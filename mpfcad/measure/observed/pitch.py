"""A measured curve over whole lamp pitches: the same contrast and harmonics as a trace's."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.contrast.contrast import contrast_of_curve, contrasts_of_pitches
from mpfcad.measure.contrast.curve import CurveFit, fit_curve
from mpfcad.measure.contrast.fit import HarmonicFit, fit_harmonics
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.observed.curve import ObservedCurve
from mpfcad.measure.observed.lamp import find_phase
from mpfcad.measure.uniformity import uniformity

#: Steps over a pitch, as a trace's 33 points have; pitches that are judged at most.
STEPS, MOST_PITCHES = 32, 24
_FEWEST_A_PITCH = 12


@dataclass(frozen=True, eq=False)
class ObservedPitch:
    """What a measured curve says about the lamps.

    Attributes
    ----------
    pitch, lamp
        [mm]: lamp pitch, and the place of a lamp in the file
    curve
        the smooth curve through the points, over one pitch or several
    fit
        the Fourier series of all pitches folded into one
    contrast
        lamp-Mura contrast; of several pitches, of the worst
    each
        of each pitch
    uniformity
        Lmin/Lmax of nine points over the pitches
    """

    pitch: float
    lamp: float
    curve: CurveFit
    fit: HarmonicFit
    contrast: Estimate
    each: list[Estimate]
    uniformity: Estimate

    def cosines(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the first cosines over the mean, (count,), and their covariance.

        The sines are the film's misplacement, not the map's.
        """
        mean, own = float(self.fit.coefficient[0]), slice(1, 2 * count, 2)
        return self.fit.coefficient[own] / mean, self.fit.covariance[own, own] / mean**2


def observe_pitch(
    observed: ObservedCurve, pitch: float, lamp: float | None = None, seed: int = 1
) -> ObservedPitch:
    """Return a curve's figures over the whole lamp pitches in its middle.

    Points are averaged to 33 a pitch, as many as a trace has. Without a known `lamp` [mm] the
    brightest phase is taken as above one: the contrast does not depend on it.

    Raises
    ------
    InputError
        when the curve does not hold a whole pitch, or too few points in one.
    """
    x = observed.position
    lamp = find_phase(x, observed.luminance, pitch) if lamp is None else lamp
    first = np.ceil((x[0] - lamp) / pitch - 0.01)
    last = np.floor((x[-1] - lamp) / pitch + 0.01)
    count = int(last - first)
    if count < 1:
        raise InputError(
            f"{observed.reading}: {np.ptp(x):.4g} mm from {x[0]:.4g} mm: expected a whole lamp "
            f"pitch of {pitch:.4g} mm, from lamp to lamp"
        )
    skip = max(0, (count - MOST_PITCHES) // 2)
    start, count = lamp + (first + skip) * pitch, min(count, MOST_PITCHES)
    position, value, error = _points(observed, start, pitch, count)
    curve = fit_curve(position, value, error, periodic=count == 1)
    inside = (x >= start - 1e-9) & (x < start + count * pitch - 1e-9)
    fold = ((x[inside] - start) / pitch) % 1
    fit = _folded(fold, observed.luminance[inside], observed.error[inside])
    if not value.min() <= fit.mean.value <= value.max():
        raise InputError(
            f"{observed.reading}: mean luminance {fit.mean.value:.5g} cd/m2 of points from "
            f"{value.min():.5g} to {value.max():.5g}: expected one that varies, with noise"
        )
    nine = np.linspace(0, len(position) - 1, 9).astype(int)
    return ObservedPitch(
        pitch, lamp, curve, fit, contrast_of_curve(curve, seed),
        contrasts_of_pitches(curve, seed) if count > 1 else [contrast_of_curve(curve, seed)],
        uniformity(value[nine], error[nine], seed=seed),
    )  # fmt: skip


def _points(
    observed: ObservedCurve, start: float, pitch: float, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return position in pitches, mean luminance and error on the grid that a trace has."""
    place = (observed.position - start) / pitch * STEPS
    total = count * STEPS
    number = np.round(place).astype(int)
    inside = (number >= 0) & (number <= total)
    fewest = int(np.bincount(np.minimum(number[inside] // STEPS, count - 1), minlength=count).min())
    if fewest < _FEWEST_A_PITCH:
        raise InputError(
            f"{observed.reading}: {fewest} points in a lamp pitch of {pitch:.4g} mm: expected "
            f"{_FEWEST_A_PITCH} or more in each"
        )
    gap = float(np.diff(observed.position[inside]).max())
    if gap > pitch / 4:
        raise InputError(
            f"{observed.reading}: no point over {gap:.4g} mm: expected gaps of a quarter of the "
            f"lamp pitch, {pitch:.4g} mm, at most"
        )
    number, weight = number[inside], 1 / np.maximum(observed.error[inside], 1e-12) ** 2
    share = np.bincount(number, weight, total + 1)
    seen = share > 0
    total_weight: NDArray[np.float64] = np.where(seen, share, 1.0)
    light = np.bincount(number, weight * observed.luminance[inside], total + 1)
    value: NDArray[np.float64] = light / total_weight
    error: NDArray[np.float64] = 1 / np.sqrt(total_weight)
    grid = np.arange(total + 1)
    # Between sparse points the straight line, as uncertain as its ends.
    for each in (value, error):
        each[~seen] = np.interp(grid[~seen], grid[seen], each[seen])
    return grid / STEPS, value, error


def _folded(
    fold: NDArray[np.float64], luminance: NDArray[np.float64], error: NDArray[np.float64]
) -> HarmonicFit:
    """Return the Fourier series of all points, folded into one pitch, in 64 bins at most."""
    bins = min(2 * STEPS, len(fold) // 2 * 2)
    number = np.minimum((fold * bins).astype(int), bins - 1)
    count = np.bincount(number, minlength=bins)
    seen = count > 0
    place, value, square = (
        np.bincount(number, v, bins)[seen] / count[seen] for v in (fold, luminance, error**2)
    )
    return fit_harmonics(place, value, np.sqrt(square / count[seen]))
