"""One body of a STEP file: a cross-section drawn along y, put together from shared edges.

No CAD kernel is needed: faces are planes and parabolas extruded along y, and each edge is made
once. Kernels write a face of N edges in N² and read it in N³ time, so whoever draws a long body
gives it several caps. The direction in which a face follows its edges is chosen so that a cap and
the sides refer to the same ORIENTED_EDGE: the caps' bounds are stated reversed (FACE_BOUND .F.).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from mpfcad.cad.step_file import StepFile, real

_SENSE = {True: ".T.", False: ".F."}


@dataclass(frozen=True)
class Parabola:
    """z = bottom + curvature/2 (x - centre)²; lengths in mm."""

    centre: float
    bottom: float
    curvature: float


class _Edge:
    """An edge of the file, and the references by which faces follow it."""

    __slots__ = ("backward", "entity", "forward")

    def __init__(self, entity: str) -> None:
        self.entity = entity
        self.forward: str | None = None
        self.backward: str | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Point:
    """A corner of the cross-section: its two ends and the edge along y between them."""

    x: float
    z: float
    near: str
    far: str
    along: _Edge


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """A piece of the cross-section, left to right or upward: its edges at both ends of the body.

    `surface` is what the piece draws along y, its normal to the left of the piece.
    """

    start: Point
    end: Point
    near: _Edge
    far: _Edge
    surface: str


#: A piece of an outline, and whether the outline follows it from start to end.
Step = tuple[Line, bool]


class Extrusion:
    """One body: its outline runs counter-clockwise (x right, z up)."""

    def __init__(self, file: StepFile, length: float) -> None:
        self.file = file
        self.length = length
        self.along = file.direction(0, 1, 0)
        self.faces: list[str] = []

    def point(self, x: float, z: float) -> Point:
        """Make a corner."""
        file = self.file
        place = file.point(x, 0, z)
        near = file.add(f"VERTEX_POINT('',{place})")
        far = file.add(f"VERTEX_POINT('',{file.point(x, self.length, z)})")
        return Point(x, z, near, far, self._edge(near, far, file.line(place, self.along)))

    def line(self, start: Point, end: Point, parabola: Parabola | None = None) -> Line:
        """Make a piece between two corners, left to right or upward, straight or of a parabola."""
        if parabola is None:
            curves, surface = self._straight(start, end)
        else:
            curves = [self._conic(parabola, y) for y in (0.0, self.length)]
            vector = self.file.vector(self.along)
            surface = self.file.share("SURFACE_OF_LINEAR_EXTRUSION", curves[0], vector)
        near = self._edge(start.near, end.near, curves[0])
        far = self._edge(start.far, end.far, curves[1])
        return Line(start, end, near, far, surface)

    def side(self, line: Line, forward: bool) -> None:
        """Add the face that a piece of the outline draws along y."""
        start, end = (line.start, line.end) if forward else (line.end, line.start)
        loop = (
            self._use(line.far, forward),
            self._use(end.along, False),
            self._use(line.near, not forward),
            self._use(start.along, True),
        )
        self._face(loop, True, line.surface, not forward)

    def cap(self, outline: list[Step]) -> None:
        """Add the two faces, at y = 0 and y = length, within a closed outline."""
        across = self.file.direction(1, 0, 0)
        for y, toward in ((0.0, -1), (self.length, 1)):
            normal = self.file.direction(0, toward, 0)
            plane = self.file.plane(self.file.point(0, y, 0), normal, across)
            if y == 0.0:
                loop = [self._use(line.near, not forward) for line, forward in outline[::-1]]
            else:
                loop = [self._use(line.far, forward) for line, forward in outline]
            self._face(loop, False, plane, True)

    def solid(self, name: str) -> str:
        """Return the body, once all its faces are there."""
        shell = self.file.add(f"CLOSED_SHELL('',({','.join(self.faces)}))")
        return self.file.add(f"MANIFOLD_SOLID_BREP('{name}',{shell})")

    def _straight(self, start: Point, end: Point) -> tuple[list[str], str]:
        """Return the two lines of a piece and its plane, all through the piece's lower end.

        So the resin shares them with the prism's wall on which it lies.
        """
        file = self.file
        across, up = end.x - start.x, end.z - start.z
        size = math.hypot(across, up)
        low = start if up >= 0 else end
        direction = file.direction(across / size, 0, up / size)
        places = [file.point(low.x, y, low.z) for y in (0, self.length)]
        normal = file.direction(-up / size, 0, across / size)
        curves = [file.line(place, direction) for place in places]
        return curves, file.plane(places[0], normal, self.along)

    def _conic(self, parabola: Parabola, y: float) -> str:
        """Return the parabola in the plane at y [mm], left to right."""
        file = self.file
        vertex = file.point(parabola.centre, y, parabola.bottom)
        axes = file.axes(vertex, self.along, file.direction(0, 0, 1))
        # Focal length f of z = x²/(4f).
        return file.share("PARABOLA", axes, real(1 / (2 * parabola.curvature)))

    def _edge(self, start: str, end: str, curve: str) -> _Edge:
        return _Edge(self.file.add(f"EDGE_CURVE('',{start},{end},{curve},.T.)"))

    def _use(self, edge: _Edge, forward: bool) -> str:
        found = edge.forward if forward else edge.backward
        if found is None:
            found = self.file.add(f"ORIENTED_EDGE('',*,*,{edge.entity},{_SENSE[forward]})")
            if forward:
                edge.forward = found
            else:
                edge.backward = found
        return found

    def _face(self, loop: Sequence[str], sense: bool, surface: str, up: bool) -> None:
        file = self.file
        edges = file.add(f"EDGE_LOOP('',({','.join(loop)}))")
        bound = file.add(f"FACE_BOUND('',{edges},{_SENSE[sense]})")
        self.faces.append(file.add(f"ADVANCED_FACE('',({bound}),{surface},{_SENSE[up]})"))
