"""Spectra of light and the colour that they make: CIE 1931, bands, files; closed form."""

from mpfcad.spectrum.bands import DISPERSION, LEAST, MOST, Bands, weighs_only
from mpfcad.spectrum.cie import (
    chromaticity,
    matching_functions,
    uniform_chromaticity,
    wavelengths,
)
from mpfcad.spectrum.file import read_spectrum
from mpfcad.spectrum.shape import Spectrum, gaussian, planckian

__all__ = [
    "DISPERSION",
    "LEAST",
    "MOST",
    "Bands",
    "Spectrum",
    "chromaticity",
    "gaussian",
    "matching_functions",
    "planckian",
    "read_spectrum",
    "uniform_chromaticity",
    "wavelengths",
    "weighs_only",
]
