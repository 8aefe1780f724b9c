"""A drawing as SVG in mm: rows of apertures as dashed lines, so that it stays small; y runs up.

Black is drawn. A column of equal rectangles is a line as wide as they are, dashed by their length
and distance; columns with the same rows share the line. Renderers draw dashes as shapes at any
resolution, where a pattern would be a picture. Edges are not smoothed (`crispEdges`): where
smoothed edges of neighbours meet, light comes through.
"""

from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby, pairwise
from pathlib import Path

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.format.flat import columns_of
from mpfcad.mask.layer import APERTURE, COUPON, LAYERS, OUTLINE
from mpfcad.mask.rule import GRID

#: Links as SVG 1.1 names them: Inkscape up to 1.2 follows no other.
XLINK = "http://www.w3.org/1999/xlink"
#: Steps after which the dashes of a line begin anew.
PART = 128
INK, PAPER = "#000", "#fff"


def write_svg(drawing: Drawing, path: Path) -> None:
    """Write `drawing` to `path`."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for part in _parts(drawing):
            file.write(part + "\n")


def _parts(drawing: Drawing) -> Iterator[str]:
    left, bottom, right, top = drawing.bounds()
    size = (right - left, top - bottom)
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="{XLINK}" width="{_mm(size[0])}mm" '
        f'height="{_mm(size[1])}mm" viewBox="{_mm(left)} 0 {_mm(size[0])} {_mm(size[1])}" '
        f'shape-rendering="crispEdges">'
    )
    notes = "\n".join(drawing.lines[1:])
    yield f"<title>{escape(drawing.lines[0])}</title><desc>{escape(notes)}</desc>"
    yield f'<g transform="matrix(1 0 0 -1 0 {_mm(top)})">'
    box = f'width="{_mm(drawing.width)}" height="{_mm(drawing.length)}"'
    yield f'<g id="{LAYERS[OUTLINE]}"><rect x="0" y="0" {box} fill="none" stroke="none"/></g>'
    for layer, group in groupby(drawing.polygons, key=lambda polygon: polygon[0]):
        yield f'<g class="{LAYERS[layer]}" fill="{INK}">'
        for _, points in group:
            corners = " ".join(f"{_mm(x)},{_mm(y)}" for x, y in points)
            yield f'<polygon points="{corners}"/>'
        yield "</g>"
    yield from _layer(COUPON, drawing.coupon, INK)
    closed = drawing.phototool.polarity == "closed"
    if closed:
        yield f'<g id="closed"><rect x="0" y="0" {box} fill="{INK}"/></g>'
    yield from _layer(APERTURE, drawing.arrays, PAPER if closed else INK)
    yield from _tiles(drawing, PAPER if closed else INK)
    yield "</g></svg>"


def _layer(layer: int, arrays: Iterable[ApertureArray], colour: str) -> Iterator[str]:
    """Yield the arrays of a layer: rows of rectangles as dashed lines, the rest one by one."""
    lines: dict[tuple[int, int, int], str] = {}
    yield (
        f'<g class="{LAYERS[layer]}" fill="{colour}" stroke="{colour}" stroke-width="0" '
        f'stroke-linecap="butt">'
    )
    for array in columns_of(arrays):
        place = array.place
        rows, (dx, step) = place.rows, place.row_step
        if rows == 1 or not isinstance(array.shape, tuple) or dx or step <= array.shape[1]:
            for x, y in place.positions():
                yield _shape(ApertureArray(array.shape, Placement((int(x), int(y)))))
            continue
        width, length = array.shape
        key = (rows, step, width)
        if key not in lines:
            lines[key] = f"{LAYERS[layer][0]}{len(lines)}"
            yield (
                f'<defs><path id="{lines[key]}" stroke-width="{_mm(width)}" fill="none" '
                f'd="{_line(rows, step)}"/></defs>'
            )
        x, y = place.origin
        yield (
            f'<use xlink:href="#{lines[key]}" x="{_half_mm(2 * x + width)}" y="{_mm(y)}" '
            f'stroke-dasharray="{_mm(length)} {_mm(step - length)}"/>'
        )
    yield "</g>"


def _line(rows: int, step: int) -> str:
    """Return a line along `rows` steps, in parts whose dashes begin anew with a whole step.

    So a renderer that adds up its dashes in single precision is off by no more than a part's worth.
    """
    edges = [*range(0, rows, PART), rows]
    return "".join(f"M0 {_mm(low * step)}V{_mm(high * step)}" for low, high in pairwise(edges))


def _shape(array: ApertureArray, left: int = 0, foot: int = 0) -> str:
    x, y = array.place.origin[0] - left, array.place.origin[1] - foot
    if isinstance(array.shape, tuple):
        width, length = array.shape
        return f'<rect x="{_mm(x)}" y="{_mm(y)}" width="{_mm(width)}" height="{_mm(length)}"/>'
    corners = " ".join(f"{_mm(a + x)},{_mm(b + y)}" for a, b in array.shape)
    return f'<polygon points="{corners}"/>'


def _tiles(drawing: Drawing, colour: str) -> Iterator[str]:
    """Yield every tile once and its places."""
    tiles = drawing.tile_cells()
    if not tiles:
        return
    yield "<defs>"
    for tile in tiles:
        yield f'<g id="{tile.name}" fill="{colour}">'
        for array in columns_of(tile.arrays):
            for x, y in array.place.positions():
                yield _shape(ApertureArray(array.shape, Placement((int(x), int(y)))))
        yield "</g>"
    yield f'</defs><g class="{LAYERS[APERTURE]}">'
    for placed in drawing.tiles:
        for x, y in placed.place.positions():
            yield f'<use xlink:href="#{placed.tile.name}" x="{_mm(x)}" y="{_mm(y)}"/>'
    yield "</g>"


def _half_mm(value: int) -> str:
    """Return half a length in mm."""
    return f"{int(value) * GRID / 2:.7f}".rstrip("0").rstrip(".")


def _mm(value: int) -> str:
    """Return a length in mm without needless zeros."""
    return f"{int(value) * GRID:.6f}".rstrip("0").rstrip(".")
