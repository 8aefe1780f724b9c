"""How likely the verdict holds in the real backlight: inputs with widths carried to the contrast.

`Factor` is an input with its standard uncertainty, `factorial_steps` says which to change together,
`fit_slopes` and `Response` tell how the luminance over the pitch follows them, `likely_contrast`
the probability that the contrast meets its limit, `rank_measurements` what to measure next.
"""

from mpfcad.confidence.advice import rank_measurements
from mpfcad.confidence.factor import Factor, correlation, covariance_fault, read_covariance
from mpfcad.confidence.factorial import STEP, factorial_steps
from mpfcad.confidence.probability import (
    Likely,
    draw_steps,
    likely_contrast,
    shares_of_variance,
)
from mpfcad.confidence.response import Response, fit_slopes, shrink_each

__all__ = [
    "STEP",
    "Factor",
    "Likely",
    "Response",
    "correlation",
    "covariance_fault",
    "draw_steps",
    "factorial_steps",
    "fit_slopes",
    "likely_contrast",
    "rank_measurements",
    "read_covariance",
    "shares_of_variance",
    "shrink_each",
]
