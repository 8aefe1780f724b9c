"""The screen's mask: film to apertures to files, and checked again from each file.

`build_mask` gives each groove the aperture ratio that its curvature needs, as arrays that are never
flattened; `write_mask` draws them as OASIS, GDSII, DXF, Gerber, SVG or TIFF on a 1 nm grid, as a
`Phototool` says; `check_mask` computes every groove's ratio from the file alone, with another
library than wrote it.
"""

from mpfcad.mask.aperture import Mask
from mpfcad.mask.array import ApertureArray, Placement, Tile, TileArray
from mpfcad.mask.check.check import MaskCheck, check_mask
from mpfcad.mask.check.drc import write_markers
from mpfcad.mask.check.preview import write_preview
from mpfcad.mask.format.write import refuse_large, write_mask
from mpfcad.mask.pattern.build import build_mask
from mpfcad.mask.pattern.grooves import GrooveMask
from mpfcad.mask.phototool import Phototool
from mpfcad.mask.rule import PATTERNS, MaskRules, Pattern

__all__ = [
    "PATTERNS",
    "ApertureArray",
    "GrooveMask",
    "Mask",
    "MaskCheck",
    "MaskRules",
    "Pattern",
    "Phototool",
    "Placement",
    "Tile",
    "TileArray",
    "build_mask",
    "check_mask",
    "refuse_large",
    "write_markers",
    "write_mask",
    "write_preview",
]
