"""What is measured on a traced backlight, each figure with its standard error.

`light_film` reads a film mesh from disk and puts it into a stack. The measures trace it in rounds
until their figures are known well enough: `luminance_over_pitch` with the lamp-Mura contrast,
`angular_luminance`, `conoscope`, `output_flux`, `screen_uniformity`, `camera_image`,
`panel_luminance`. An interrupted trace goes on from its checkpoint.
"""

from mpfcad.measure.angle.angular import AngularCurve, AngularResult, angular_luminance
from mpfcad.measure.angle.conoscope import ConoscopeResult, conoscope
from mpfcad.measure.angle.survey import Survey, survey_directions
from mpfcad.measure.camera import CameraResult, camera_image
from mpfcad.measure.cell.block import BlockResult, block_figures
from mpfcad.measure.cell.estimator import Estimator
from mpfcad.measure.cell.luminance import (
    CellResult,
    compile_cell_tracer,
    luminance_over_cell,
    trace_terms,
)
from mpfcad.measure.cell.spread import SpreadResult, led_spread
from mpfcad.measure.cell.tracer import can_connect, refuse_sheetless
from mpfcad.measure.checkpoint import Checkpoints
from mpfcad.measure.colour.screen import ColourResult, refuse_uncoloured, screen_colour
from mpfcad.measure.contrast.contrast import contrast_of_curve
from mpfcad.measure.contrast.curve import CurveFit, fit_curve
from mpfcad.measure.contrast.fit import HarmonicFit, fit_harmonics
from mpfcad.measure.contrast.harmonic import harmonic_amplitude, relative_spread
from mpfcad.measure.estimate import Estimate, reach
from mpfcad.measure.eye import describe_eye, threshold_contrast
from mpfcad.measure.flux import FluxResult, output_flux
from mpfcad.measure.luminance import LuminanceResult, luminance_over_pitch
from mpfcad.measure.meter import POINTS, Spot
from mpfcad.measure.panel import PanelResult, check_finite, panel_luminance
from mpfcad.measure.polarisation import (
    PolarisationResult,
    polarisation,
    refuse_unpolarised,
)
from mpfcad.measure.rounds import LEAST_PATHS, Lit, TraceRun, TraceState, light_film
from mpfcad.measure.uniformity import METERS, SCREEN_POINTS, UniformityResult, screen_uniformity

__all__ = [
    "LEAST_PATHS",
    "METERS",
    "POINTS",
    "SCREEN_POINTS",
    "AngularCurve",
    "AngularResult",
    "BlockResult",
    "CameraResult",
    "CellResult",
    "Checkpoints",
    "ColourResult",
    "ConoscopeResult",
    "CurveFit",
    "Estimate",
    "Estimator",
    "FluxResult",
    "HarmonicFit",
    "Lit",
    "LuminanceResult",
    "PanelResult",
    "PolarisationResult",
    "Spot",
    "SpreadResult",
    "Survey",
    "TraceRun",
    "TraceState",
    "UniformityResult",
    "angular_luminance",
    "block_figures",
    "camera_image",
    "can_connect",
    "check_finite",
    "compile_cell_tracer",
    "conoscope",
    "contrast_of_curve",
    "describe_eye",
    "fit_curve",
    "fit_harmonics",
    "harmonic_amplitude",
    "led_spread",
    "light_film",
    "luminance_over_cell",
    "luminance_over_pitch",
    "output_flux",
    "panel_luminance",
    "polarisation",
    "reach",
    "refuse_sheetless",
    "refuse_uncoloured",
    "refuse_unpolarised",
    "relative_spread",
    "screen_colour",
    "screen_uniformity",
    "survey_directions",
    "threshold_contrast",
    "trace_terms",
]
