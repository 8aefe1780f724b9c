"""Luminance that a meter or a camera measured: read, folded over the lamps, judged as a trace."""

from mpfcad.measure.observed.askew import askew_words, read_stripes, spots_askew_words
from mpfcad.measure.observed.cell import ObservedCell, observe_cell
from mpfcad.measure.observed.curve import ObservedCurve, read_curve
from mpfcad.measure.observed.image import LuminanceImage, Photo, read_image
from mpfcad.measure.observed.lamp import NAMED_PITCH, SAME_PITCH, check_pitch, find_pitch
from mpfcad.measure.observed.lattice import lattice_words
from mpfcad.measure.observed.pitch import ObservedPitch, observe_pitch
from mpfcad.measure.observed.stripe import curve_of_image

__all__ = [
    "NAMED_PITCH",
    "SAME_PITCH",
    "LuminanceImage",
    "ObservedCell",
    "ObservedCurve",
    "ObservedPitch",
    "Photo",
    "askew_words",
    "check_pitch",
    "curve_of_image",
    "find_pitch",
    "lattice_words",
    "observe_cell",
    "observe_pitch",
    "read_curve",
    "read_image",
    "read_stripes",
    "spots_askew_words",
]
