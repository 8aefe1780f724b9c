"""The mould of a film: its negative, turned over, enlarged by the shrinkage; what a tool cuts.

film = mould · (1 - shrinkage), in every direction. A diamond's round nose cannot reach into the
valleys of the mould, which are the tips of the film: what it leaves is the film with tips of that
radius, so the cut mould is the negative of such a film, and exact.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import Imperfection, PrismFilm, Section, build_section
from mpfcad.units import um


@dataclass(frozen=True, eq=False)
class Mould:
    """A mould, x mirrored against the film, z = 0 at the bottom of its valleys; lengths in mm.

    Attributes
    ----------
    film
        the film's section
    section
        the exact negative
    cut
        what the tool makes of it; `section` itself for a sharp tool
    tool_radius
        nose radius of the tool
    lost_area, lost_height
        (n,) float64 [mm², mm], what the tool leaves standing in each groove of the mould, left to
        right, and by how much the higher of its two valleys is filled
    tip_position
        (n+1,) float64 [mm], the mould's valleys
    """

    film: Section
    section: Section
    cut: Section
    tool_radius: float
    lost_area: NDArray[np.float64]
    lost_height: NDArray[np.float64]
    tip_position: NDArray[np.float64]


def build_mould(
    film: PrismFilm,
    imperfection: Imperfection | None = None,
    *,
    shrinkage: float = 0.0,
    backing: float = 5.0,
    tool_radius: float = 0.0,
    sliver: float | None = None,
) -> Mould:
    """Return the mould of a film with `backing` [mm] of metal behind its valleys.

    Parts of the film narrower than `sliver` [mm] are merged into their neighbours.

    Raises
    ------
    InputError
        when the film or the tool's nose does not fit.
    """
    made = imperfection or Imperfection()
    if tool_radius and made.measured is not None:
        raise InputError(
            f"tool radius: {tool_radius / um:g} µm: expected 0 for a measured profile, whose "
            "corners no tool cuts"
        )
    options = {} if sliver is None else {"sliver": sliver}
    outline = build_section(film, made, **options)
    cut = outline
    shrink = 1 - shrinkage
    nose = tool_radius * shrink
    if nose > made.tip_radius:
        try:
            cut = build_section(film, replace(made, tip_radius=nose), **options)
        except InputError as error:
            text = str(error).partition(": expected")[2]
            raise InputError(
                f"tool radius: {tool_radius / um:g} µm: does not fit the film's tips: "
                f"expected{text}"
            ) from None
    level = outline.thickness
    negative = outline.turned_over(level, backing * shrink).scaled(1 / shrink)
    reachable = negative
    if cut is not outline:
        reachable = cut.turned_over(level, backing * shrink).scaled(1 / shrink)
    tips = negative.width - film.tip_position[::-1] / shrink
    tips[[0, -1]] = 0.0, negative.width
    area = np.diff(reachable.area_to(tips) - negative.area_to(tips))
    height = reachable.height(tips) - negative.height(tips)
    return Mould(
        outline,
        negative,
        reachable,
        tool_radius,
        np.maximum(area, 0.0),
        np.maximum(np.maximum(height[:-1], height[1:]), 0.0),
        tips,
    )
