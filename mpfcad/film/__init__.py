"""What the film *is*: one groove in closed form, and a row of grooves as a film. Pure numpy.

`Groove` knows the bare V and its resin; `PrismFilm` is a row of them with one curvature each;
`CurvatureMap` holds what the user wants and lays it onto the grooves; `Process` ties the mask's
aperture ratio to the fill fraction and so to the curvature.
"""

from mpfcad.film.geometry import PrismFilm
from mpfcad.film.groove import PROFILES, Groove, Profile

__all__ = ["PROFILES", "Groove", "PrismFilm", "Profile"]
