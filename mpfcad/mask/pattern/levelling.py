"""What is left of a pattern once the resin has levelled.

In an open groove capillary flow is driven by the surface's transverse curvature, so the fill obeys
a diffusion equation along the groove: after a while it is the printed resin averaged with a Gauss
curve. The levelling length is that curve's full width at half maximum. Nothing flows over the tips.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.aperture import Mask

#: Full width at half maximum over standard deviation of a Gauss curve.
FULL_WIDTH = 2 * (2 * np.log(2)) ** 0.5
#: Grooves that are looked at, and how many levelling lengths of each.
GROOVES, STRETCH = 64, 60
#: Points a levelling length or period, whichever is shorter.
POINTS = 25
#: A wanted ratio up to this is none.
DRY = 1e-9
#: Standard deviations at which the Gauss curve is cut: an earlier cut has a ripple of its own.
REACH = 6.5


@dataclass(frozen=True, eq=False)
class Residual:
    """How far the levelled ratio is from the levelled wanted one, over sampled grooves.

    Attributes
    ----------
    rms, worst
        root mean square and largest distance of the aperture ratio
    mean_ratio
        mean wanted ratio of the sample
    levelling_length
        of the resin [mm]
    groove
        (k,) int64, the grooves that were looked at, counted from 0
    groove_ratio, groove_rms
        (k,) float64, each one's mean wanted ratio, and root mean square of the distance, where it
        is printed
    """

    rms: float
    worst: float
    mean_ratio: float
    levelling_length: float
    groove: NDArray[np.int64]
    groove_ratio: NDArray[np.float64]
    groove_rms: NDArray[np.float64]


def levelling_residual(mask: Mask) -> Residual:
    """Return what levelling leaves of the pattern of a mask, away from the panel's ends.

    The sampled grooves are spread evenly, with those of the smallest and the largest ratio.
    """
    from scipy.ndimage import gaussian_filter1d

    width = mask.rules.levelling_length
    stretch = min(STRETCH * width, mask.length)
    points = int(np.ceil(POINTS * stretch / min(width, mask.period))) + 1
    sigma = width / FULL_WIDTH / (stretch / (points - 1))
    margin = min(round(REACH * sigma), (points - 1) // 3)
    grooves = _sample(mask)
    share = (np.arange(len(grooves)) * 0.6180339887) % 1
    square, worst, ratio = [], 0.0, []
    for groove, start in zip(grooves, share * (mask.length - stretch), strict=True):
        position = start + np.linspace(0, stretch, points)
        drawn, wanted = (
            np.diff(integral(int(groove), 1, position)[0]) / np.diff(position)
            for integral in (mask.open_length, mask.wanted_length)
        )
        error = gaussian_filter1d(drawn - wanted, sigma, truncate=REACH)
        error = error[margin : points - 1 - margin]
        inside = wanted[margin : points - 1 - margin] > DRY
        if inside.any():  # of a halftone the printed pieces alone: bare ones ripple by nothing
            error, wanted = error[inside], wanted[wanted > DRY]
        square.append(float(np.mean(error**2)))
        worst = max(worst, float(np.abs(error).max()))
        ratio.append(float(wanted.mean()))
    rms = float(np.sqrt(np.mean(square)))
    return Residual(
        rms, worst, float(np.mean(ratio)), width, grooves, np.array(ratio), np.sqrt(square)
    )


def _sample(mask: Mask) -> NDArray[np.int64]:
    spread = np.linspace(0, mask.groove_count - 1, GROOVES).astype(np.int64)
    wanted = mask.wanted_ratio
    least = np.where(wanted > DRY, wanted, np.inf)
    ends = [int(np.argmin(least)), int(np.argmax(wanted))]
    return np.unique(np.append(spread, ends))
