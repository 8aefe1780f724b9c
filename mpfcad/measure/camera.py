"""What a camera far away sees of the screen's middle: traced pixels, nothing smoothed.

Where everything repeats without end, nothing changes along the lamps: a line of the picture along
them is one traced value. On a finite panel it is 20 traced values of 10 mm each.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.rounds import Lit, TraceRun, relative_error, trace_rounds
from mpfcad.measure.uniformity import middle

#: Edge [mm] of the square that is seen (Hsieh, MPF thesis: 20 cm × 20 cm), and its pixels.
EDGE = 200.0
PIXELS = 200
_PARTS = 20
_FIGURE = "pixel ± {:.4f} of the mean"


@dataclass(frozen=True, eq=False)
class CameraResult:
    """The picture, taken from straight above by parallel light.

    Attributes
    ----------
    luminance, standard_error
        (200, k) float64 [cd/m²]: lines of pixels along the lamps in k equal parts
    pixel
        edge of a pixel [mm]
    paths
        backward paths traced
    """

    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    pixel: float
    paths: int

    @property
    def picture(self) -> NDArray[np.float64]:
        """The picture, (200, 200) float64 [cd/m²]: rows across the lamps, columns along them."""
        return np.repeat(self.luminance, PIXELS // self.luminance.shape[1], axis=1)


def camera_image(lit: Lit, run: TraceRun, error_goal: float) -> CameraResult:
    """Return the picture of 200 × 200 mm in the screen's middle; error relative, of one pixel."""
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
