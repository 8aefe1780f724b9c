"""The resin of films as they are made: how much each groove holds, and which C holds that much.

A print lays down a volume of resin; what shape it takes is up to the groove. So of a film that
departs from the designed one the resin is what stays: each groove gets the C through the tips with
which it holds, over the area that it takes, as much as the mask gives there.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.imperfection import Imperfection, build_section
from mpfcad.film.measured_section import measured_bare_area
from mpfcad.units import um

#: Steps of the search for C, how near it comes, and how near it must: shares of a full groove.
STEPS, NEAR, NEAR_ENOUGH = 60, 1e-10, 1e-4
#: Least and largest growth of the resin taken for that of the same groove when it is sharp.
GROWTH = 0.05, 2.0


def bare_mean_height(film: PrismFilm, imperfection: Imperfection) -> float:
    """Return the mean height [mm] of the prisms without resin, of a `filled` film.

    Between the two walls of inclination φ and a circle of radius r that touches both lies an area
    of r² (tan φ - φ): more prism in a rounded valley, less at a rounded tip.
    """
    if imperfection.measured is not None:
        return film.base + measured_bare_area(film, imperfection.measured) / film.groove.pitch
    slope = film.groove.wall_slope
    corner = slope - np.arctan(slope)
    rounding = (imperfection.valley_radius**2 - imperfection.tip_radius**2) * corner
    return film.base + film.groove.depth / 2 + float(rounding) / film.groove.pitch


def resin_height(film: PrismFilm, imperfection: Imperfection) -> NDArray[np.float64]:
    """Return the mean height of the resin in each groove of a `filled` film, (n,) float64 [mm]."""
    area = np.diff(build_section(film, imperfection).area_to(film.tip_position))
    return area / film.groove.pitch - bare_mean_height(film, imperfection)


def curvature_of_resin(
    film: PrismFilm, imperfection: Imperfection, height: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the C through the tips [1/mm] with which each groove holds its resin, (n,) float64.

    Parameters
    ----------
    film
        the film as made; its own curvature does not matter
    imperfection
        its radii, or the measured surface
    height
        (n,) float64 [mm], the wanted resin of each groove over the area that it takes

    Raises
    ------
    InputError
        when a groove cannot hold so much.
    """
    full = film.groove.depth / 2
    wanted = height / full
    worst = int(np.argmax(wanted))
    if not wanted[worst] <= 1 + 1e-12:
        raise InputError(
            f"film: groove {worst}: the mask gives {height[worst] / um:.4g} µm of resin: expected "
            f"at most {full / um:.4g} µm, what a groove {film.groove.depth / um:.4g} µm deep holds"
        )
    fill = np.clip(wanted, 0.0, 1.0)
    if imperfection.measured is not None or imperfection.contact_angle is not None:
        return film.groove.curvature_of_fill(fill)
    empty = wanted <= 0
    growth = np.ones(len(fill))
    before = found_before = np.full(len(fill), np.nan)
    for step in range(STEPS):
        found = _fill_at(film, imperfection, fill)
        gap = np.where(empty, 0.0, wanted - found)
        if np.abs(gap).max() < NEAR:
            break
        if step:
            moved = fill - before
            np.divide(found - found_before, moved, out=growth, where=np.abs(moved) > 1e-14)
            growth = np.clip(growth, *GROWTH)
        before, found_before = fill, found
        fill = np.clip(fill + gap / growth, 0.0, 1.0)
    worst = int(np.argmax(np.abs(gap)))
    if not abs(gap[worst]) <= NEAR_ENOUGH:
        raise InputError(
            f"film: groove {worst}: no curvature holds the {height[worst] / um:.4g} µm of resin "
            f"that the mask gives (nearest {float(found[worst]) * full / um:.4g} µm): expected "
            f"smaller radii"
        )
    return film.groove.curvature_of_fill(fill)


def _fill_at(
    film: PrismFilm, imperfection: Imperfection, fill: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the resin of the C that a sharp groove's `fill` has, both shares of a full groove."""
    film = replace(film, curvature=film.groove.curvature_of_fill(fill))
    return resin_height(film, imperfection) / (film.groove.depth / 2)
