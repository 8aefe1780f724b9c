"""What is measured on a traced backlight: luminance over the lamp pitch and lamp-Mura contrast.

`luminance_over_pitch` reads a film mesh from disk, traces it in a stack until the contrast's
interval is narrow enough, and returns figures that carry their uncertainty.
"""

from mpfcad.measure.contrast import Estimate, contrast_of_harmonics, fit_harmonics
from mpfcad.measure.luminance import POINTS, LuminanceResult, luminance_over_pitch

__all__ = [
    "POINTS",
    "Estimate",
    "LuminanceResult",
    "contrast_of_harmonics",
    "fit_harmonics",
    "luminance_over_pitch",
]
