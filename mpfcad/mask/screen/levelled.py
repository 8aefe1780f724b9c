"""What levelling leaves of a mask file's apertures, over a few grooves: for a picture.

The resin of a groove is averaged along it with a Gauss curve whose full width at half maximum is
the levelling length (`pattern.levelling`); nothing flows over the tips.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import Process
from mpfcad.mask.check.check import READERS
from mpfcad.mask.check.found import FoundMask
from mpfcad.mask.pattern.levelling import FULL_WIDTH, REACH
from mpfcad.mask.rule import GRID

#: Grooves in the picture; periods and levelling lengths along it, at least; points of a period and
#: of the whole, at most.
GROOVES, PERIODS, LENGTHS, POINTS, MOST = 9, 4, 3, 48, 480


@dataclass(frozen=True, eq=False)
class LevelledWindow:
    """A few grooves as printed, and once the resin has levelled.

    Attributes
    ----------
    first
        groove of the panel that is the first, counted from 0
    position
        (k,) float64 [mm], along the grooves from the window's start
    printed
        (n, k) float64, open share of the groove's width, 0…1, averaged over a point's length
    curvature
        (n, k) float64 [1/mm], after levelling, less its mean along the groove
    """

    first: int
    position: NDArray[np.float64]
    printed: NDArray[np.float64]
    curvature: NDArray[np.float64]


def levelled_window(
    path: Path,
    process: Process,
    pitch: float,
    period: float,
    levelling_length: float,
    groove: int,
) -> LevelledWindow | None:
    """Return the grooves about `groove`, midway along the panel; None of pixels, or too short ones.

    `pitch`, `period` and `levelling_length` are in mm.
    """
    from scipy.ndimage import gaussian_filter1d

    reader = READERS.get(path.suffix.removeprefix("."))
    if reader is None:
        return None
    found = reader(path)
    left, bottom, right, top = found.outline
    shown = max(PERIODS * period, LENGTHS * levelling_length)
    step = max(period / POINTS, shown / MOST)
    count_along = round(shown / step)
    sigma = levelling_length / FULL_WIDTH / step
    margin = int(np.ceil(REACH * sigma))
    points = count_along + 2 * margin
    start = (bottom + top) / 2 * GRID - points * step / 2
    if start < bottom * GRID or start + points * step > top * GRID:
        return None
    total = round((right - left) * GRID / pitch)
    count = min(GROOVES, total)
    first = min(max(groove - count // 2, 0), total - count)
    edge = np.asarray(start + np.arange(points + 1) * step, np.float64)
    printed = np.stack([_open_share(found, (first + n) * pitch, pitch, edge) for n in range(count)])

    levelled = gaussian_filter1d(printed, sigma, axis=1, truncate=REACH)[:, margin:-margin]
    curvature = process.curvature(np.clip(levelled, 0.0, 1.0))
    return LevelledWindow(
        first,
        np.asarray((np.arange(count_along) + 0.5) * step, np.float64),
        printed[:, margin:-margin],
        curvature - curvature.mean(axis=1, keepdims=True),
    )


def _open_share(
    found: FoundMask, start: float, pitch: float, edge: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the open share of a groove that begins at `start` [mm], between edges along [mm]."""
    box = (round(start / GRID), round(edge[0] / GRID), round((start + pitch) / GRID),
           round(edge[-1] / GRID))  # fmt: skip
    integral = np.zeros(len(edge))
    for shape in found.window(box).each():
        inner = shape.bbox()
        width = min(inner.right, box[2]) - max(inner.left, box[0])
        if width > 0:
            reach = np.clip(edge / GRID - inner.bottom, 0, inner.height())
            integral += width * GRID / pitch * reach * GRID
    share = np.diff(integral) / np.diff(edge)
    return share if found.drawn == "open" else 1.0 - share
