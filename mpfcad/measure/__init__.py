"""What is measured on a traced backlight: luminance over the lamp pitch and lamp-Mura contrast.

`light_film` reads a film mesh from disk and puts it into a stack; `luminance_over_pitch` and the
other measures trace it in rounds until their figures are known well enough, and return them with
their uncertainty. An interrupted trace goes on from its checkpoint.
"""

from mpfcad.measure.checkpoint import Checkpoints, case_hash
from mpfcad.measure.contrast import Estimate, contrast_of_harmonics, fit_harmonics
from mpfcad.measure.luminance import POINTS, LuminanceResult, luminance_over_pitch
from mpfcad.measure.rounds import Lit, TraceRun, TraceState, light_film

__all__ = [
    "POINTS",
    "Checkpoints",
    "Estimate",
    "Lit",
    "LuminanceResult",
    "TraceRun",
    "TraceState",
    "case_hash",
    "contrast_of_harmonics",
    "fit_harmonics",
    "light_film",
    "luminance_over_pitch",
]
