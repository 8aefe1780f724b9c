"""The screen's mask: film to apertures to OASIS and GDSII, and checked again from the file.

`build_mask` gives each groove the aperture ratio that its curvature needs, as one array of equal
rectangles; `write_mask` (gdstk) keeps those arrays symbolic; `check_mask` (klayout) computes every
groove's aperture ratio from the file alone. Drawn is open; lengths in a file are µm on a 1 nm grid.
"""

from mpfcad.mask.aperture import Mask
from mpfcad.mask.array import ApertureArray, Placement, Tile, TileArray
from mpfcad.mask.build import build_mask
from mpfcad.mask.check import MaskCheck, check_mask
from mpfcad.mask.groove_mask import GrooveMask
from mpfcad.mask.rule import PATTERNS, MaskRules, Pattern
from mpfcad.mask.write import write_mask

__all__ = [
    "PATTERNS",
    "ApertureArray",
    "GrooveMask",
    "Mask",
    "MaskCheck",
    "MaskRules",
    "Pattern",
    "Placement",
    "Tile",
    "TileArray",
    "build_mask",
    "check_mask",
    "write_mask",
]
