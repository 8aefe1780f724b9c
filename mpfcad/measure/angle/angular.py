"""Angular luminance across and along the lamps, and the viewing angles read off it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.angle.direction import trace_directions
from mpfcad.measure.draw import estimate_by_draws
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun

#: Polar angles [rad] of one curve, -80° … 80°.
ANGLES = np.radians(np.arange(-80, 81, 5))
_PEAK_POINTS = 5


@dataclass(frozen=True, eq=False)
class AngularCurve:
    """Luminance over the viewing angle in one plane, averaged over a lamp pitch.

    Attributes
    ----------
    angle
        (n,) float64 [rad], from the normal
    luminance, standard_error
        (n,) float64 [cd/m²]
    freedom
        degrees of freedom of a direction's standard error
    fwhm
        full width [rad] at half of the peak; None when the curve does not fall that far
    third
        full width [rad] at a third of the normal luminance; None likewise
    """

    angle: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    freedom: float
    fwhm: Estimate | None
    third: Estimate | None


@dataclass(frozen=True, eq=False)
class AngularResult:
    """Both curves; `across` the lamps (x) and `along` them (y)."""

    across: AngularCurve
    along: AngularCurve
    paths: int


def angular_luminance(lit: Lit, run: TraceRun, error_goal: float) -> AngularResult:
    """Return the angular luminance across and along the lamps, averaged over a lamp pitch.

    `error_goal`: standard error of a point over the largest luminance, root mean square.
    """
    n = len(ANGLES)
    polar = np.concatenate([ANGLES, ANGLES])
    azimuth = np.repeat([0.0, np.pi / 2], n)
    tally = trace_directions(lit, run, polar, azimuth, error_goal)
    across, along = (
        _curve(tally.radiance[part], tally.own_error[part], tally.blocks - 1.0, run.seed)
        for part in (slice(0, n), slice(n, 2 * n))
    )
    return AngularResult(across, along, tally.total_paths)


def _curve(luminance: NDArray, error: NDArray, freedom: float, seed: int) -> AngularCurve:
    def estimate(figure: Callable[[NDArray[np.float64]], float | None]) -> Estimate | None:
        return estimate_by_draws(figure, luminance, error, freedom, seed)

    fwhm = estimate(lambda v: width(ANGLES, v, peak(ANGLES, v) / 2))
    third = estimate(lambda v: width(ANGLES, v, v[len(v) // 2] / 3))
    return AngularCurve(ANGLES, luminance, error, freedom, fwhm, third)


def peak(angle: NDArray[np.float64], luminance: NDArray[np.float64]) -> float:
    """Return the peak of a curve: the top of a least-squares parabola through the points about it.

    The largest of noisy points alone is too high.
    """
    at = int(np.argmax(luminance))
    first = min(max(at - _PEAK_POINTS // 2, 0), len(angle) - _PEAK_POINTS)
    part = slice(first, first + _PEAK_POINTS)
    a, b, c = np.polyfit(angle[part] - angle[at], luminance[part], 2)
    span = angle[part] - angle[at]
    top = -b / (2 * a) if a < 0 else span[0]
    if not span[0] <= top <= span[-1]:
        return float(max(np.polyval((a, b, c), span[[0, -1]])))
    return float(np.polyval((a, b, c), top))


def width(angle: NDArray[np.float64], luminance: NDArray[np.float64], level: float) -> float | None:
    """Return the full width of a curve about its highest point at a level; None if it has none.

    From the highest point outward to the first fall below the level on each side, straight between
    neighbouring points.
    """
    at = int(np.argmax(luminance))
    ends = []
    for step in (-1, 1):
        i = at
        while 0 <= i < len(angle) and luminance[i] > level:
            i += step
        if not 0 <= i < len(angle) or i == at:
            return None
        inner, outer = luminance[i - step], luminance[i]
        share = (inner - level) / (inner - outer)
        ends.append(angle[i - step] + share * (angle[i] - angle[i - step]))
    return float(ends[1] - ends[0])
