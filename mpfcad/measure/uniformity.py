"""Luminance on the screen's 5, 9 and 13 points, and the uniformity read off them.

5 points: the middle and the four at a quarter of width and height (data sheets of TV panels).
9 points: at 10, 50 and 90 % of width and height (VESA, Flat Panel Display Measurements 2.0, 306-1).
13 points: both together.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.contrast import contrast_of_points
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, relative_error, trace_rounds

_FIGURE = "luminance ± {:.4f} of the mean"
_NINE = tuple(product((0.1, 0.5, 0.9), repeat=2))
_QUARTERS = tuple(product((0.25, 0.75), repeat=2))
#: (13, 2) shares of the panel's width (across the lamps) and length (along them).
SCREEN_POINTS = np.array(_NINE + _QUARTERS)
#: Which of `SCREEN_POINTS` each meter takes.
METERS = {5: (4, 9, 10, 11, 12), 9: tuple(range(9)), 13: tuple(range(13))}


@dataclass(frozen=True, eq=False)
class UniformityResult:
    """Luminance at the screen's points.

    Attributes
    ----------
    point
        (13, 2) float64, shares of the panel's width and length
    luminance, standard_error
        (13,) float64 [cd/m²]
    uniformity
        δ = Lmin/Lmax on 5, 9 and 13 points
    paths
        backward paths traced
    """

    point: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    uniformity: dict[int, Estimate]
    paths: int


def screen_uniformity(lit: Lit, run: TraceRun, error_goal: float) -> UniformityResult:
    """Return the normal luminance at the screen's points, each to a relative standard error."""
    from mpfcad.optics.source import EYE, Source

    stack = lit.stack
    source = Source(
        EYE,
        middle(lit) + (SCREEN_POINTS[:, 0] - 0.5) * stack.panel_width,
        lit.spot.width,
        acceptance=stack.acceptance,
        along=(SCREEN_POINTS[:, 1] - 0.5) * stack.panel_length,
        spot_along=stack["meter_spot_mm"],
    )
    tally = trace_rounds(lit, source, run, relative_error, error_goal, _FIGURE)
    value, error = tally.radiance, tally.radiance_error
    found = {
        count: uniformity(value[list(at)], error[list(at)], tally.blocks, run.seed)
        for count, at in METERS.items()
    }
    return UniformityResult(SCREEN_POINTS, value, error, found, tally.total_paths)


def uniformity(
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
    seed: int = 0,
) -> Estimate:
    """Return δ = Lmin/Lmax of points [cd/m²] with standard errors, without the noise's bias.

    δ = (1 - K)/(1 + K) with K the points' contrast, which `contrast_of_points` estimates.
    """
    contrast = contrast_of_points(luminance, error, blocks, seed)
    value, low, high = ((1 - k) / (1 + k) for k in (contrast.value, contrast.high, contrast.low))
    return Estimate.within(value, low, high)


def middle(lit: Lit) -> float:
    """Return x [mm] of the panel's middle, from the axis of the lamp left of it."""
    stack = lit.stack
    return stack.panel_width / 2 - stack.origin[0]
