"""Write the body of a cross-section as one exact solid of a STEP file."""

from pathlib import Path

from mpfcad.cad.step.extrusion import Extrusion, Line, Point
from mpfcad.cad.step.file import PLAIN, Header, StepFile, real
from mpfcad.cad.step.product import Colour, Products
from mpfcad.film import Section
from mpfcad.film.section import ARC, LINE

#: Pieces over one face of the caps and of the underside: readers slow down with long faces.
BLOCK = 64
#: Colours of a film of one body, and of a mould.
FILM_COLOUR: Colour = (0.62, 0.74, 0.86)
MOULD_COLOUR: Colour = (0.80, 0.70, 0.45)


class _Drawing(Extrusion):
    """An extrusion that also knows downward parabolas and arcs; each runs left to right."""

    def piece(self, section: Section, index: int, start: Point, end: Point) -> Line:
        """Make one piece of a section between two corners."""
        if section.kind[index] == LINE:
            return self.line(start, end)
        curves = [self._curve(section, index, y) for y in (0.0, self.length)]
        surface = self.file.share(
            "SURFACE_OF_LINEAR_EXTRUSION", curves[0], self.file.vector(self.along)
        )
        near = self._edge(start.near, end.near, curves[0])
        far = self._edge(start.far, end.far, curves[1])
        return Line(start, end, near, far, surface)

    def _curve(self, section: Section, index: int, y: float) -> str:
        """Return the parabola or circle of a piece in the plane at y [mm].

        Its parameter grows to the right: a parabola opens along its x axis, a circle starts at its
        leftmost point and runs over its top (convex) or bottom (concave).
        """
        file, bend = self.file, float(section.bend[index])
        place = file.point(float(section.centre_x[index]), y, float(section.centre_z[index]))
        up = 1 if bend > 0 else -1
        if section.kind[index] == ARC:
            axes = file.axes(place, file.direction(0, -up, 0), file.direction(-1, 0, 0))
            return file.share("CIRCLE", axes, real(abs(bend)))
        axes = file.axes(place, file.direction(0, up, 0), file.direction(0, 0, up))
        # Focal length f of z = x²/(4f).
        return file.share("PARABOLA", axes, real(1 / (2 * abs(bend))))


def write_section_step(
    section: Section,
    path: Path,
    *,
    name: str,
    body: str,
    colour: Colour,
    header: Header = PLAIN,
) -> None:
    """Write one solid `body` in mm, exact; same section and names, same bytes."""
    path = Path(path)
    file = StepFile(header)
    products = Products(file)
    solid = _draw(file, section, body)
    products.assembly(name, {body: products.part(body, [solid], colour)})
    products.write(path, name)


def _draw(file: StepFile, section: Section, body: str) -> str:
    """Return the solid under the outline."""
    drawing = _Drawing(file, section.length)
    corners = [drawing.point(float(x), float(z)) for x, z in zip(section.x, section.z, strict=True)]
    blocks = (
        [
            drawing.piece(section, i, corners[i], corners[i + 1])
            for i in range(first, min(first + BLOCK, section.piece_count))
        ]
        for first in range(0, section.piece_count, BLOCK)
    )
    return drawing.slab(body, blocks, section.underside)
