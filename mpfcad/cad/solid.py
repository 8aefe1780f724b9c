"""The film as two exact bodies, extruded along y. Needs OCCT: import it only where it is used.

Everything is put together by hand from shared corners and edges: no sewing, no booleans. OCCT
writes a face of N edges in N² and reads it in N³ time, so caps and underside are cut every `BLOCK`
grooves. A parabola is a conic (OCCT's `Geom_Parabola`), neither polyline nor spline.
"""

import math
from dataclasses import dataclass

from OCP.BRep import BRep_Builder
from OCP.Geom import Geom_Curve, Geom_Line, Geom_Parabola, Geom_Plane, Geom_SurfaceOfLinearExtrusion
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax2, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import (
    TopoDS_Compound,
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shape,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)

from mpfcad.cad.outline import SOLID_FLAT, check_drawable, solid_contact
from mpfcad.film import PrismFilm
from mpfcad.units import nm

#: Grooves in one face of the caps and of the underside.
BLOCK = 16
#: OCCT's tolerance of corners, edges and faces.
TOLERANCE = 0.1 * nm

_ALONG = gp_Dir(0, 1, 0)
_FORWARD = {True: TopAbs_FORWARD, False: TopAbs_REVERSED}


@dataclass(frozen=True)
class _Parabola:
    """z = bottom + curvature/2 (x - centre)²; lengths in mm."""

    centre: float
    bottom: float
    curvature: float


@dataclass(frozen=True, eq=False)
class _Point:
    """A corner of the cross-section: its two ends and the edge along y between them."""

    x: float
    z: float
    near: TopoDS_Vertex
    far: TopoDS_Vertex
    along: TopoDS_Edge


@dataclass(frozen=True, eq=False)
class _Line:
    """A piece of the cross-section from `start` to `end`: its edges at y = 0 and y = length."""

    start: _Point
    end: _Point
    near: TopoDS_Edge
    far: TopoDS_Edge
    parabola: _Parabola | None


#: A piece of an outline, and whether the outline follows it from start to end.
_Step = tuple[_Line, bool]


class _Extrusion:
    """One body: a cross-section drawn along y, its outline counter-clockwise (x right, z up).

    A parabola must be a top side, made from left to right and followed from right to left.
    """

    def __init__(self, length: float) -> None:
        self.length = length
        self.builder = BRep_Builder()
        self.shell = TopoDS_Shell()
        self.builder.MakeShell(self.shell)

    def point(self, x: float, z: float) -> _Point:
        """Make a corner."""
        near, far = TopoDS_Vertex(), TopoDS_Vertex()
        start = gp_Pnt(x, 0, z)
        self.builder.MakeVertex(near, start, TOLERANCE)
        self.builder.MakeVertex(far, gp_Pnt(x, self.length, z), TOLERANCE)
        along = self._edge(Geom_Line(start, _ALONG), near, far, 0.0, self.length)
        return _Point(x, z, near, far, along)

    def line(self, start: _Point, end: _Point, parabola: _Parabola | None = None) -> _Line:
        """Make a straight piece, or one of a parabola, between two corners."""
        if parabola is None:
            across, up = end.x - start.x, end.z - start.z
            direction = gp_Dir(across, 0, up)
            first, last = 0.0, math.hypot(across, up)
            curves = [Geom_Line(gp_Pnt(start.x, y, start.z), direction) for y in (0, self.length)]
        else:
            first, last = start.x - parabola.centre, end.x - parabola.centre
            curves = [_conic(parabola, y) for y in (0, self.length)]
        near = self._edge(curves[0], start.near, end.near, first, last)
        far = self._edge(curves[1], start.far, end.far, first, last)
        return _Line(start, end, near, far, parabola)

    def side(self, line: _Line, forward: bool) -> None:
        """Add the face that a piece of the outline draws along y."""
        face = TopoDS_Face()
        if line.parabola is None:
            sign = 1 if forward else -1
            across, up = sign * (line.end.x - line.start.x), sign * (line.end.z - line.start.z)
            surface = Geom_Plane(gp_Pnt(line.start.x, 0, line.start.z), gp_Dir(up, 0, -across))
        else:
            surface = Geom_SurfaceOfLinearExtrusion(_conic(line.parabola, 0), _ALONG)
            self._lay_on(surface, line)
        start, end = (line.start, line.end) if forward else (line.end, line.start)
        steps = [
            (line.far, forward),
            (end.along, False),
            (line.near, not forward),
            (start.along, True),
        ]
        self.builder.MakeFace(face, surface, TOLERANCE)
        self._close(face, steps)

    def cap(self, outline: list[_Step]) -> None:
        """Add the two faces, at y = 0 and y = length, within a closed outline."""
        for y, toward in ((0.0, -1), (self.length, 1)):
            face = TopoDS_Face()
            plane = Geom_Plane(gp_Pnt(outline[0][0].start.x, y, 0), gp_Dir(0, toward, 0))
            self.builder.MakeFace(face, plane, TOLERANCE)
            if y == 0.0:
                self._close(face, [(line.near, forward) for line, forward in outline])
            else:
                self._close(face, [(line.far, not forward) for line, forward in outline[::-1]])

    def solid(self) -> TopoDS_Solid:
        """Return the body, once all its faces are there."""
        self.shell.Closed(True)
        solid = TopoDS_Solid()
        self.builder.MakeSolid(solid)
        self.builder.Add(solid, self.shell)
        return solid

    def _edge(
        self, curve: Geom_Curve, start: TopoDS_Vertex, end: TopoDS_Vertex, first: float, last: float
    ) -> TopoDS_Edge:
        edge = TopoDS_Edge()
        self.builder.MakeEdge(edge, curve, TOLERANCE)
        self.builder.Add(edge, start.Oriented(TopAbs_FORWARD))
        self.builder.Add(edge, end.Oriented(TopAbs_REVERSED))
        self.builder.Range(edge, first, last)
        return edge

    def _lay_on(self, surface: Geom_SurfaceOfLinearExtrusion, line: _Line) -> None:
        """Tell OCCT where the four edges of a parabolic face lie on it: u = x, v = y."""
        centre = line.parabola.centre
        lines = (
            (line.near, gp_Pnt2d(0, 0), gp_Dir2d(1, 0)),
            (line.far, gp_Pnt2d(0, self.length), gp_Dir2d(1, 0)),
            (line.start.along, gp_Pnt2d(line.start.x - centre, 0), gp_Dir2d(0, 1)),
            (line.end.along, gp_Pnt2d(line.end.x - centre, 0), gp_Dir2d(0, 1)),
        )
        for edge, origin, direction in lines:
            trace = Geom2d_Line(origin, direction)
            self.builder.UpdateEdge(edge, trace, surface, TopLoc_Location(), TOLERANCE)

    def _close(self, face: TopoDS_Face, steps: list[tuple[TopoDS_Edge, bool]]) -> None:
        wire = TopoDS_Wire()
        self.builder.MakeWire(wire)
        for edge, forward in steps:
            self.builder.Add(wire, edge.Oriented(_FORWARD[forward]))
        wire.Closed(True)
        self.builder.Add(face, wire)
        self.builder.Add(self.shell, face)


def _conic(parabola: _Parabola, y: float) -> Geom_Parabola:
    """Return the parabola in the plane at y [mm]; its parameter is x from the centre [mm]."""
    vertex = gp_Pnt(parabola.centre, y, parabola.bottom)
    # Focal length f of z = x²/(4f).
    return Geom_Parabola(gp_Ax2(vertex, _ALONG, gp_Dir(0, 0, 1)), 1 / (2 * parabola.curvature))


def _surface(film: PrismFilm, index: int) -> _Parabola | None:
    """Return the parabola of a groove, or None where it is flat."""
    curvature = float(film.curvature[index])
    sag = curvature / 2 * film.groove.half_width**2
    if sag < SOLID_FLAT:
        return None
    return _Parabola(float(film.groove_position[index]), film.thickness - sag, curvature)


def build_prism(film: PrismFilm) -> TopoDS_Solid:
    """Return the prism film under the resin, one body.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    """
    check_drawable(film)
    body = _Extrusion(film.length)
    tips = [body.point(float(x), film.thickness) for x in film.tip_position]
    contact = solid_contact(film)
    top = [
        _prism_top(body, film, i, float(contact[i]), tips[i], tips[i + 1])
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
    return body.solid()


def _prism_top(
    body: _Extrusion, film: PrismFilm, index: int, contact: float, left: _Point, right: _Point
) -> list[_Line]:
    """Return the upper outline of the prism film in one groove, left to right."""
    centre = float(film.groove_position[index])
    if film.profile == "ideal" and contact == 0:
        return [body.line(left, right, _surface(film, index))]
    valley = body.point(centre, film.base)
    if film.profile == "filled" or contact == film.groove.half_width:
        return [body.line(left, valley), body.line(valley, right)]
    height = film.base + film.groove.wall_slope * contact
    ends = [body.point(centre - contact, height), body.point(centre + contact, height)]
    surface = _surface(film, index)
    return [
        body.line(left, ends[0], surface),
        body.line(ends[0], valley),
        body.line(valley, ends[1]),
        body.line(ends[1], right, surface),
    ]


def build_fill(film: PrismFilm) -> TopoDS_Compound | None:
    """Return the resin, one body a groove in one compound; None when no groove holds any.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    """
    check_drawable(film)
    contact = solid_contact(film)
    pieces = [
        _fill_piece(film, i, float(contact[i])) for i in range(film.groove_count) if contact[i]
    ]
    if not pieces:
        return None
    compound = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(compound)
    for piece in pieces:
        builder.Add(compound, piece)
    return compound


def _fill_piece(film: PrismFilm, index: int, contact: float) -> TopoDS_Shape:
    """Return the resin of one groove."""
    body = _Extrusion(film.length)
    centre = float(film.groove_position[index])
    height = film.base + film.groove.wall_slope * contact
    left, right = body.point(centre - contact, height), body.point(centre + contact, height)
    valley = body.point(centre, film.base)
    outline = [
        (body.line(left, valley), True),
        (body.line(valley, right), True),
        (body.line(left, right, _surface(film, index)), False),
    ]
    for line, forward in outline:
        body.side(line, forward)
    body.cap(outline)
    return body.solid()
