"""What a camera far away sees of the screen's middle: traced pixels, nothing smoothed.

Where everything repeats without end, nothing changes along the lamps: a line of the picture along
them is one traced value. On a finite panel it is 20 traced values of 10 mm each. Over LEDs the
cell's pixels are traced and repeat.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.rounds import Lit, TraceRun, relative_error, trace_rounds
from mpfcad.measure.uniformity import middle

if TYPE_CHECKING:
    from mpfcad.optics.forward.engine import CellTally

#: Edge [mm] of the square that is seen (Hsieh, MPF thesis: 20 cm × 20 cm), and its pixels.
EDGE = 200.0
PIXELS = 200
_PARTS = 20
#: Pixels along each side of a cell of LEDs: of 1 mm, but no fewer and no more than these.
_LEAST_BINS, _MOST_BINS = 12, 64
_MOST_CELLS = 4
_FIGURE = "pixel ± {:.4f} of the mean"


@dataclass(frozen=True, eq=False)
class CameraResult:
    """The picture, taken from straight above by parallel light.

    Attributes
    ----------
    luminance, standard_error
        (200, k) float64 [cd/m²]: lines of pixels along the lamps in k equal parts; over LEDs
        (b, b), the pixels of a cell
    pixel
        edge of a pixel [mm]; over LEDs along the grooves it may be `pixel_along`
    paths
        paths traced
    cells
        how often the cell stands across and along the picture of LEDs; None of tubes
    """

    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    pixel: float
    paths: int
    pixel_along: float | None = None
    cells: tuple[int, int] | None = None

    @property
    def picture(self) -> NDArray[np.float64]:
        """The picture, (n, m) float64 [cd/m²]: rows across the lamps, columns along them."""
        if self.cells is not None:
            return np.tile(self.luminance, self.cells)
        return np.repeat(self.luminance, PIXELS // self.luminance.shape[1], axis=1)


def camera_image(lit: Lit, run: TraceRun, error_goal: float) -> CameraResult:
    """Return the picture of 200 × 200 mm in the screen's middle; error relative, of one pixel."""
    if lit.is_cell:
        return _cell_image(lit, run, error_goal)
    from mpfcad.optics.source import EYE, Source

    pixel = EDGE / PIXELS
    parts = _PARTS if lit.is_finite else 1
    position = middle(lit) + (np.arange(PIXELS) + 0.5) * pixel - EDGE / 2
    along = ((np.arange(parts) + 0.5) / parts - 0.5) * EDGE
    source = Source(
        EYE,
        np.repeat(position, parts),
        pixel,
        acceptance=lit.stack.acceptance,
        along=np.tile(along, PIXELS) if lit.is_finite else 0.0,
        spot_along=EDGE / parts if lit.is_finite else 0.0,
    )
    tally = trace_rounds(lit, source, run, relative_error, error_goal, _FIGURE)
    value, error = (v.reshape(PIXELS, parts) for v in (tally.radiance, tally.radiance_error))
    return CameraResult(value, error, pixel, tally.total_paths)


def _cell_image(lit: Lit, run: TraceRun, error_goal: float) -> CameraResult:
    """Return the picture of whole cells of LEDs, at most 200 mm and `_MOST_CELLS` of them."""
    from mpfcad.measure.cell.enough import refuse_rare
    from mpfcad.measure.cell.pilot import choose
    from mpfcad.measure.cell.tracer import CellTracer
    from mpfcad.optics.forward.connection import CellMeter

    size = lit.stack.period
    bins = min(max(math.ceil(max(size) * PIXELS / EDGE), _LEAST_BINS), _MOST_BINS)
    meter = CellMeter(lit.stack.acceptance, size.across, size.along, bins)

    tracer = CellTracer(lit, meter, choose(lit, meter, run).estimator)

    def error_of(tally: "CellTally") -> float:
        if not refuse_rare(tracer, tally, run.path_limit, error_goal):
            return 1.0
        value, error = tracer.map(tally)
        return float(np.sqrt(np.mean(error**2)) / value.mean())

    tally = tracer.rounds(run, error_of, error_goal, _FIGURE)
    value, error = tracer.map(tally)
    cells = [min(max(1, int(EDGE / side)), _MOST_CELLS) for side in size]
    return CameraResult(
        value, error, size[0] / bins, tally.paths, size[1] / bins, (cells[0], cells[1])
    )
