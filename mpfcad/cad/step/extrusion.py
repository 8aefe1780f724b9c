"""Bodies of a STEP file: cross-sections drawn along y, put together from shared corners and edges.

No CAD kernel is needed: faces are planes and parabolas extruded along y, and each corner and edge
is made once for a solid. Kernels write a face of N edges in N² and read it in N³ time, so whoever
draws a long body gives it several caps. Each ORIENTED_EDGE stands in one loop, and no solid refers
to another's corners, edges or faces: some kernels take both for faults.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mpfcad.cad.step.file import StepFile, real

_SENSE = {True: ".T.", False: ".F."}


@dataclass(frozen=True)
class Parabola:
    """z = bottom + curvature/2 (x - centre)²; lengths in mm."""

    centre: float
    bottom: float
    curvature: float


@dataclass(frozen=True, eq=False, slots=True)
class Point:
    """A corner of the cross-section: its two ends and the edge along y between them."""

    x: float
    z: float
    near: str
    far: str
    along: str


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """A piece of the cross-section, left to right or upward: its edges at both ends of the body.

    `surface` is what the piece draws along y, its normal to the left of the piece.
    """

    start: Point
    end: Point
    near: str
    far: str
    surface: str


#: A piece of an outline, and whether the outline follows it from start to end.
Step = tuple[Line, bool]


class Extrusion:
    """Bodies, one after another; their outlines run counter-clockwise (x right, z up).

    A corner or piece that is asked for again within a solid is the same again.
    """

    def __init__(self, file: StepFile, length: float) -> None:
        self.file = file
        self.length = length
        self.along = file.direction(0, 1, 0)
        self._faces: list[str] = []
        self._points: dict[tuple[float, float], Point] = {}
        self._lines: dict[tuple[Point, Point, Parabola | None], Line] = {}

    def point(self, x: float, z: float) -> Point:
        """Return a corner."""
        found = self._points.get((x, z))
        if found is None:
            found = self._points[x, z] = self._make_point(x, z)
        return found

    def _make_point(self, x: float, z: float) -> Point:
        file = self.file
        place = file.point(x, 0, z)
        near = file.add(f"VERTEX_POINT('',{place})")
        far = file.add(f"VERTEX_POINT('',{file.point(x, self.length, z)})")
        return Point(x, z, near, far, self._edge(near, far, file.line(place, self.along)))

    def line(self, start: Point, end: Point, parabola: Parabola | None = None) -> Line:
        """Return a piece between two corners, left to right or upward: straight, or a parabola."""
        key = (start, end, parabola)
        found = self._lines.get(key)
        if found is None:
            found = self._lines[key] = self._make_line(start, end, parabola)
        return found

    def _make_line(self, start: Point, end: Point, parabola: Parabola | None) -> Line:
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
        self._face(loop, line.surface, not forward)

    def cap(self, outline: list[Step]) -> None:
        """Add the two faces, at y = 0 and y = length, within a closed outline."""
        across = self.file.direction(1, 0, 0)
        for y, toward in ((0.0, -1), (self.length, 1)):
            normal = self.file.direction(0, toward, 0)
            plane = self.file.plane(self.file.point(0, y, 0), normal, across)
            if y == 0.0:
                loop = [self._use(line.near, forward) for line, forward in outline]
            else:
                loop = [self._use(line.far, not forward) for line, forward in outline[::-1]]
            self._face(loop, plane, True)

    def solid(self, name: str) -> str:
        """Return the solid of all faces added since the last one; the next has its own corners."""
        shell = self.file.add(f"CLOSED_SHELL('',({','.join(self._faces)}))")
        self._faces = []
        self._points.clear()
        self._lines.clear()
        return self.file.add(f"MANIFOLD_SOLID_BREP('{name}',{shell})")

    def slab(self, name: str, blocks: Iterable[list[Line]], underside: float) -> str:
        """Return the body between an upper outline, left to right, and a flat underside.

        A block holds the pieces over one face of the caps and of the underside.
        """
        left = foot = None
        for lines in blocks:
            if left is None or foot is None:
                foot = self.point(lines[0].start.x, underside)
                left = self.line(foot, lines[0].start)
                self.side(left, False)
            next_foot = self.point(lines[-1].end.x, underside)
            under = self.line(foot, next_foot)
            right = self.line(next_foot, lines[-1].end)
            self.side(under, True)
            for line in lines:
                self.side(line, False)
            above = [(line, False) for line in reversed(lines)]
            self.cap([(under, True), (right, True), *above, (left, False)])
            foot, left = next_foot, right
        if left is not None:
            self.side(left, True)
        return self.solid(name)

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

    def _edge(self, start: str, end: str, curve: str) -> str:
        return self.file.add(f"EDGE_CURVE('',{start},{end},{curve},.T.)")

    def _use(self, edge: str, forward: bool) -> str:
        return self.file.add(f"ORIENTED_EDGE('',*,*,{edge},{_SENSE[forward]})")

    def _face(self, loop: Sequence[str], surface: str, up: bool) -> None:
        file = self.file
        edges = file.add(f"EDGE_LOOP('',({','.join(loop)}))")
        bound = file.add(f"FACE_OUTER_BOUND('',{edges},.T.)")
        self._faces.append(file.add(f"ADVANCED_FACE('',({bound}),{surface},{_SENSE[up]})"))
