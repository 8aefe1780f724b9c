"""The film as exact bodies of a STEP file, extruded along y: `BEF` and `fill`, or one `film`.

Everything is put together from shared corners and edges: no sewing, no booleans. Caps and underside
are cut every `BLOCK` grooves. A parabola is a conic (STEP's PARABOLA), neither polyline nor spline.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.step.extrusion import Extrusion, Line, Parabola, Point
from mpfcad.cad.step.file import StepFile
from mpfcad.cad.step.outline import SOLID_FLAT, solid_contact
from mpfcad.film import PrismFilm

#: `separate`: prism film and resin apart; `fused`: both as one body.
Bodies = Literal["separate", "fused"]
#: Grooves in one face of the caps and of the underside.
BLOCK = 64

#: Draws the upper outline of a groove between its two tips, left to right.
_Top = Callable[[Extrusion, PrismFilm, int, float, Point, Point], list[Line]]


def draw_bodies(file: StepFile, film: PrismFilm, bodies: Bodies) -> dict[str, list[str]]:
    """Add the bodies of a film to the file; return the solids of each by its name."""
    drawing = Extrusion(file, film.length)
    contact = solid_contact(film)
    if bodies == "fused":
        return {"film": [_draw_slab(drawing, film, contact, "film", _fused_top)]}
    drawn = {"BEF": [_draw_slab(drawing, film, contact, "BEF", _prism_top)]}
    fill = [_draw_fill(drawing, film, i, float(reach)) for i, reach in enumerate(contact) if reach]
    return {**drawn, "fill": fill} if fill else drawn


def _draw_slab(
    drawing: Extrusion, film: PrismFilm, contact: NDArray[np.float64], name: str, draw_top: _Top
) -> str:
    """Return one solid over the whole width, flat below."""
    tips = [drawing.point(float(x), film.thickness) for x in film.tip_position]
    top = [
        draw_top(drawing, film, i, float(contact[i]), tips[i], tips[i + 1])
        for i in range(film.groove_count)
    ]
    blocks = (
        [line for groove in top[first : first + BLOCK] for line in groove]
        for first in range(0, film.groove_count, BLOCK)
    )
    return drawing.slab(name, blocks, 0.0)


def _prism_top(
    body: Extrusion, film: PrismFilm, index: int, contact: float, left: Point, right: Point
) -> list[Line]:
    """Return the upper outline of the prism film under the resin."""
    centre = float(film.groove_position[index])
    if film.profile == "ideal" and contact == 0:
        return [body.line(left, right, _surface(film, index))]
    valley = body.point(centre, film.base)
    if film.profile == "filled" or contact == film.groove.half_width:
        return [body.line(left, valley), body.line(valley, right)]
    ends = _contact_points(body, film, index, contact)
    surface = _surface(film, index)
    return [
        body.line(left, ends[0], surface),
        body.line(ends[0], valley),
        body.line(valley, ends[1]),
        body.line(ends[1], right, surface),
    ]


def _fused_top(
    body: Extrusion, film: PrismFilm, index: int, contact: float, left: Point, right: Point
) -> list[Line]:
    """Return the upper outline of prism film and resin together."""
    if film.profile == "ideal" or contact == film.groove.half_width:
        return [body.line(left, right, _surface(film, index))]
    if contact == 0:
        return _prism_top(body, film, index, contact, left, right)
    ends = _contact_points(body, film, index, contact)
    return [
        body.line(left, ends[0]),
        body.line(ends[0], ends[1], _surface(film, index)),
        body.line(ends[1], right),
    ]


def _draw_fill(body: Extrusion, film: PrismFilm, index: int, contact: float) -> str:
    """Return the resin of one groove, one solid."""
    left, right = _contact_points(body, film, index, contact)
    valley = body.point(float(film.groove_position[index]), film.base)
    outline = [
        (body.line(left, valley), True),
        (body.line(valley, right), True),
        (body.line(left, right, _surface(film, index)), False),
    ]
    for line, forward in outline:
        body.side(line, forward)
    body.cap(outline)
    return body.solid("fill")


def _contact_points(
    body: Extrusion, film: PrismFilm, index: int, contact: float
) -> tuple[Point, Point]:
    """Return the two corners where the parabola of a groove meets its walls."""
    centre = float(film.groove_position[index])
    height = film.base + film.groove.wall_slope * contact
    return body.point(centre - contact, height), body.point(centre + contact, height)


def _surface(film: PrismFilm, index: int) -> Parabola | None:
    """Return the parabola of a groove, or None where it is flat."""
    curvature = float(film.curvature[index])
    sag = curvature / 2 * film.groove.half_width**2
    if sag < SOLID_FLAT:
        return None
    return Parabola(float(film.groove_position[index]), film.thickness - sag, curvature)
