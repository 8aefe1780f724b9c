"""What the film *is*: one groove in closed form, and a row of grooves as a film. Pure numpy.

`Groove` knows the bare V and its resin; `PrismFilm` is a row of them with one curvature each;
`MadeFilm` is one rounded or measured, `Section` the outline of it, or of a mould, as exact pieces;
`CurvatureMap` holds what the user wants and lays it onto the grooves; `CurvatureField` and
`FieldFilm` are the same for a curvature that varies along the grooves too, `FieldPiece` a window of
it; `Process` ties the mask's aperture ratio to the fill fraction and so to the curvature. The
`*_file` modules read and write; `fit_stylus_trace` finds the curvature of a printed groove and
`write_process` calibrates from it.
"""

from mpfcad.film.cell import CellFilm, CellShape
from mpfcad.film.curvature.file import read_curvature_table, write_curvature_map
from mpfcad.film.curvature.map import CurvatureMap, Extent, Repeat, check_curvature
from mpfcad.film.curvature.table import CurvatureTable, build_curvature_map
from mpfcad.film.field.cells import CellLibrary, build_cell_library
from mpfcad.film.field.field import CurvatureField, FieldFilm, PanelField
from mpfcad.film.field.file import (
    ALONG_ARRAY,
    has_along,
    is_field_file,
    read_curvature_cell,
    read_curvature_field,
    write_curvature_field,
)
from mpfcad.film.field.halftone import Halftone, HalftoneField, build_halftone
from mpfcad.film.field.library import PieceLibrary, build_library
from mpfcad.film.field.piece import FieldPiece, cut_piece
from mpfcad.film.field.repeated import CurvatureCell, RepeatedField
from mpfcad.film.field.series import CurvatureSeries
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.groove import PROFILES, Groove, Profile
from mpfcad.film.imperfection import Imperfection, build_section
from mpfcad.film.made import MadeFilm
from mpfcad.film.measured import average_groove
from mpfcad.film.panel import PanelFilm
from mpfcad.film.process.file import read_process
from mpfcad.film.process.levelling import levelling_length, modulation_left
from mpfcad.film.process.model import Process, check_aperture_ratio, check_printable, groove_ranges
from mpfcad.film.process.posterior import (
    PRIOR_RELEASE,
    Calibration,
    prior_belief,
)
from mpfcad.film.process.tone import ToneBelief, ToneCurve
from mpfcad.film.process.write import Coupon, write_process, write_tone_process
from mpfcad.film.pyramid import PyramidGroove
from mpfcad.film.section import Section
from mpfcad.film.stylus.file.reading import (
    ReadingOption,
    parse_columns,
    parse_units,
    read_stylus_trace,
)
from mpfcad.film.stylus.fit import Interval, StylusFit, fit_stylus_trace
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.film.stylus.trace import StylusTrace

__all__ = [
    "ALONG_ARRAY",
    "PRIOR_RELEASE",
    "PROFILES",
    "Calibration",
    "CellFilm",
    "CellLibrary",
    "CellShape",
    "Coupon",
    "CurvatureCell",
    "CurvatureField",
    "CurvatureMap",
    "CurvatureSeries",
    "CurvatureTable",
    "Extent",
    "FieldFilm",
    "FieldPiece",
    "Groove",
    "Halftone",
    "HalftoneField",
    "Imperfection",
    "Interval",
    "MadeFilm",
    "PanelField",
    "PanelFilm",
    "PieceLibrary",
    "PrismFilm",
    "Process",
    "Profile",
    "PyramidGroove",
    "ReadingOption",
    "Repeat",
    "RepeatedField",
    "Section",
    "StylusFit",
    "StylusTip",
    "StylusTrace",
    "ToneBelief",
    "ToneCurve",
    "average_groove",
    "build_cell_library",
    "build_curvature_map",
    "build_halftone",
    "build_library",
    "build_section",
    "check_aperture_ratio",
    "check_curvature",
    "check_printable",
    "cut_piece",
    "fit_stylus_trace",
    "groove_ranges",
    "has_along",
    "is_field_file",
    "levelling_length",
    "modulation_left",
    "parse_columns",
    "parse_units",
    "prior_belief",
    "read_curvature_cell",
    "read_curvature_field",
    "read_curvature_table",
    "read_process",
    "read_stylus_trace",
    "write_curvature_field",
    "write_curvature_map",
    "write_process",
    "write_tone_process",
]
