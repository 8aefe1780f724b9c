"""A drawing as SVG in mm: rows of apertures as patterns, so that it stays small; y runs up.

Black is drawn. Arrays of the same number of rows and the same step are one pattern tile, one period
high and as wide as the panel, that fills a rectangle of rows × period.
"""

from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby
from pathlib import Path

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.format.flat import columns_of
from mpfcad.mask.layer import APERTURE, COUPON, LAYERS, OUTLINE
from mpfcad.mask.rule import GRID

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
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_mm(size[0])}mm" '
        f'height="{_mm(size[1])}mm" viewBox="{_mm(left)} 0 {_mm(size[0])} {_mm(size[1])}">'
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
    yield f'<g class="{LAYERS[layer]}" fill="{colour}" stroke="none">'
    for i, group in enumerate(_bands(arrays)):
        rows, (_, step) = group[0].place.rows, group[0].place.row_step
        if rows == 1:
            yield from (_shape(array) for array in group)
            continue
        left = min(a.place.origin[0] + a.box[0] for a in group)
        right = max(a.place.origin[0] + a.box[2] for a in group)
        foot = min(a.place.origin[1] + a.box[1] for a in group)
        place = f'x="{_mm(left)}" y="{_mm(foot)}" width="{_mm(right - left)}"'
        name = f"{LAYERS[layer]}{i}"
        yield f'<pattern id="{name}" patternUnits="userSpaceOnUse" {place} height="{_mm(step)}">'
        # What is inside a pattern is drawn from the tile's corner on.
        yield from (_shape(array, left, foot) for array in group)
        yield "</pattern>"
        yield f'<rect {place} height="{_mm(rows * step)}" fill="url(#{name})"/>'
    yield "</g>"


def _bands(arrays: Iterable[ApertureArray]) -> Iterator[list[ApertureArray]]:
    """Yield neighbouring arrays whose rows fit one tile, a row step high."""
    band: list[ApertureArray] = []
    low = high = 0
    for array in columns_of(arrays):
        foot, top = (array.place.origin[1] + array.box[k] for k in (1, 3))
        if band:
            first = band[0].place
            same = (first.rows, first.row_step) == (array.place.rows, array.place.row_step)
            reach = max(high, top) - min(low, foot)
            if not (same and (first.rows == 1 or reach <= first.row_step[1])):
                yield band
                band = []
        low, high = (min(low, foot), max(high, top)) if band else (foot, top)
        band.append(array)
    if band:
        yield band


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
            yield f'<use href="#{placed.tile.name}" x="{_mm(x)}" y="{_mm(y)}"/>'
    yield "</g>"


def _mm(value: int) -> str:
    """Return a length in mm without needless zeros."""
    return f"{int(value) * GRID:.6f}".rstrip("0").rstrip(".")
