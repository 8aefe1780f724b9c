"""What the film *is*: one groove in closed form, and a row of grooves as a film. Pure numpy.

`Groove` knows the bare V and its resin; `PrismFilm` is a row of them with one curvature each;
`CurvatureMap` holds what the user wants and lays it onto the grooves; `CurvatureField` and
`FieldFilm` are the same for a curvature that varies along the grooves too; `Process` ties the
mask's aperture ratio to the fill fraction and so to the curvature. The `*_file` modules read and
write.
"""

from mpfcad.film.curvature import CurvatureMap, Extent, Repeat, check_curvature
from mpfcad.film.curvature_file import read_curvature_map, write_curvature_map
from mpfcad.film.field import CurvatureField, FieldFilm
from mpfcad.film.field_file import is_field_file, read_curvature_field
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.groove import PROFILES, Groove, Profile
from mpfcad.film.process import Process, check_aperture_ratio, check_printable, groove_ranges
from mpfcad.film.process_file import read_process

__all__ = [
    "PROFILES",
    "CurvatureField",
    "CurvatureMap",
    "Extent",
    "FieldFilm",
    "Groove",
    "PrismFilm",
    "Process",
    "Profile",
    "Repeat",
    "check_aperture_ratio",
    "check_curvature",
    "check_printable",
    "groove_ranges",
    "is_field_file",
    "read_curvature_field",
    "read_curvature_map",
    "read_process",
    "write_curvature_map",
]
