"""The film as exact bodies of a STEP file, extruded along y: `BEF` and `fill`, or one `film`.

Everything is put together from shared corners and edges: no sewing, no booleans. Caps and underside
are cut every `BLOCK` grooves. A parabola is a conic (STEP's PARABOLA), neither polyline nor spline.
"""

from collections.abc import Callable
from typing import Literal

from mpfcad.cad.outline import SOLID_FLAT, solid_contact
from mpfcad.cad.step_extrusion import Extrusion, Line, Parabola, Point
from mpfcad.cad.step_file import StepFile
from mpfcad.film import PrismFilm

#: `separate`: prism film and resin apart; `fused`: both as one body.
Bodies = Literal["separate", "fused"]
#: Grooves in one face of the caps and of the underside.
BLOCK = 16

#: Draws the upper outline of a groove between its two tips, left to right.
_Top = Callable[[Extrusion, PrismFilm, int, float, Point, Point], list[Line]]


def draw_bodies(file: StepFile, film: PrismFilm, bodies: Bodies) -> dict[str, list[str]]:
    """Add the bodies of a film to the file; return the solids of each by its name."""
    if bodies == "fused":
        return {"film": [_draw_slab(file, film, "film", _fused_top)]}
    drawn = {"BEF": [_draw_slab(file, film, "BEF", _prism_top)]}
    contact = solid_contact(film)
    fill = [_draw_fill(file, film, i, float(reach)) for i, reach in enumerate(contact) if reach]
    return {**drawn, "fill": fill} if fill else drawn


def _draw_slab(file: StepFile, film: PrismFilm, name: str, draw_top: _Top) -> str:
    """Return one solid over the whole width, flat below."""
    body = Extrusion(file, film.length)
    tips = [body.point(float(x), film.thickness) for x in film.tip_position]
    contact = solid_contact(film)
    top = [
        draw_top(body, film, i, float(contact[i]), tips[i], tips[i + 1])
        for i in range(film.groove_count)
    ]
    foot = body.point(tips[0].x, 0.0)
    left = body.line(foot, tips[0])
    body.side(left, False)
    for first in range(0, film.groove_count, BLOCK):
        last = min(first + BLOCK, film.groove_count)
        next_foot = body.point(tips[last].x, 0.0)
        under = body.line(foot, next_foot)
        right = body.line(next_foot, tips[last])
        lines = [line for groove in top[first:last] for line in groove]
        body.side(under, True)
        for line in lines:
            body.side(line, False)
        above = [(line, False) for line in reversed(lines)]
        body.cap([(under, True), (right, True), *above, (left, False)])
        foot, left = next_foot, right
    body.side(left, True)
    return body.solid(name)


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


def _draw_fill(file: StepFile, film: PrismFilm, index: int, contact: float) -> str:
    """Return the resin of one groove, one solid."""
    body = Extrusion(file, film.length)
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
