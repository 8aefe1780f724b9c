"""One solid of planes and patches as the text of a STEP file; no CAD library is used.

Corners are known by their places and edges by their corners, so neighbouring faces share them.
"""

import math
from pathlib import Path

from mpfcad.cad.step.file import PLAIN, Header, StepFile, real
from mpfcad.cad.step.product import Products
from mpfcad.cad.step.section import FILM_COLOUR

Place = tuple[float, float, float]


class PatchSolid:
    """Corners, edges and faces of one solid; each is made once."""

    def __init__(self, header: Header = PLAIN, products: Products | None = None) -> None:
        self.products = Products(StepFile(header)) if products is None else products
        self.file = self.products.file
        self.corners: dict[Place, str] = {}
        self.edges: dict[tuple[Place, Place], str] = {}
        self.faces: list[str] = []

    def corner(self, place: Place) -> str:
        """Return the corner at a place [mm]."""
        if place not in self.corners:
            point = self.file.point(*place)
            self.corners[place] = self.file.add(f"VERTEX_POINT('',{point})")
        return self.corners[place]

    def straight(self, start: Place, end: Place) -> str:
        """Return the straight line from one place towards another."""
        span = [b - a for a, b in zip(start, end, strict=True)]
        size = math.sqrt(sum(part * part for part in span))
        return self.file.line(
            self.file.point(*start), self.file.direction(*(part / size for part in span))
        )

    def bowl(self, bottom: Place, along: tuple[float, float], curvature: float) -> str:
        """Return the upward parabola with this lowest point, drawn along a horizontal direction."""
        file, (x, y) = self.file, along
        # Its axes: up, along; their cross product is the plane's normal.
        axes = file.axes(file.point(*bottom), file.direction(-y, x, 0), file.direction(0, 0, 1))
        return file.share("PARABOLA", axes, real(1 / (2 * curvature)))

    def edge(self, start: Place, end: Place, curve: str | None = None) -> tuple[str, bool]:
        """Return the edge between two places and whether it runs from start to end."""
        if (end, start) in self.edges:
            return self.edges[end, start], False
        if (start, end) not in self.edges:
            curve = curve or self.straight(start, end)
            ends = f"{self.corner(start)},{self.corner(end)}"
            self.edges[start, end] = self.file.add(f"EDGE_CURVE('',{ends},{curve},.T.)")
        return self.edges[start, end], True

    def face(self, places: list[Place], surface: str, *, outward: bool = True) -> None:
        """Add the face with these corners, anticlockwise from outside; new edges are straight."""
        loop = []
        for start, end in zip(places, places[1:] + places[:1], strict=True):
            edge, forward = self.edge(start, end)
            # One of its own for each loop: stricter kernels than OCCT take one in two for a fault.
            sense = ".T." if forward else ".F."
            loop.append(self.file.add(f"ORIENTED_EDGE('',*,*,{edge},{sense})"))
        ring = self.file.add(f"EDGE_LOOP('',({','.join(loop)}))")
        bound = self.file.add(f"FACE_OUTER_BOUND('',{ring},.T.)")
        sense = ".T." if outward else ".F."
        self.faces.append(self.file.add(f"ADVANCED_FACE('',({bound}),{surface},{sense})"))

    def flat(self, places: list[Place], normal: Place, across: Place) -> None:
        """Add a plane face."""
        file = self.file
        plane = file.plane(file.point(*places[0]), file.direction(*normal), file.direction(*across))
        self.face(places, plane)

    def solid(self) -> str:
        """Return the faces as one closed solid."""
        shell = self.file.add(f"CLOSED_SHELL('',({','.join(self.faces)}))")
        return self.file.add(f"MANIFOLD_SOLID_BREP('film',{shell})")

    def write(self, path: Path, name: str) -> None:
        """Write the faces as one closed solid `film` of an assembly with this name."""
        body = self.solid()
        self.products.assembly(name, {"film": self.products.part("film", [body], FILM_COLOUR)})
        self.products.write(Path(path), name)
