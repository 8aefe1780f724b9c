"""Arrays taken apart as far as a format needs: tiles to arrays, lattices to single columns."""

from collections.abc import Iterable, Iterator

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.format.drawing import Drawing

#: A tile is gone through place by place up to so many; beyond, its apertures are listed, so many
#: at a time.
FEW, MANY = 16, 1 << 20


def flat_tiles(drawing: Drawing) -> Iterator[ApertureArray]:
    """Yield the arrays of every tile at each of its places."""
    for placed in drawing.tiles:
        for at in placed.place.positions():
            for array in placed.tile.arrays:
                yield ApertureArray(array.shape, shift(array.place, at))


def listed_tiles(drawing: Drawing) -> Iterator[ApertureArray]:
    """Yield the apertures of every tile, those of many places listed in few arrays."""
    for placed in drawing.tiles:
        for array in placed.tile.arrays:
            yield from repeated(array, placed.place)


def repeated(array: ApertureArray, outer: Placement) -> Iterator[ApertureArray]:
    """Yield an array of a cell at the places of the cell, which few or many arrays hold."""
    if outer.count <= FEW:
        for at in outer.positions():
            yield ApertureArray(array.shape, shift(array.place, at))
        return
    places, inner = outer.positions(), array.place.positions()
    many = max(1, MANY // len(inner))
    for first in range(0, len(places), many):
        offset = (places[first : first + many, None] + inner).reshape(-1, 2)
        yield ApertureArray(array.shape, Placement((0, 0), offset=offset))


def shift(place: Placement, by: Iterable[int]) -> Placement:
    """Return a placement moved by (x, y)."""
    x, y = (int(a + b) for a, b in zip(place.origin, by, strict=True))
    steps = (place.column_step, place.row_step)
    return Placement((x, y), place.columns, place.rows, *steps, place.offset)


def columns_of(arrays: Iterable[ApertureArray]) -> Iterator[ApertureArray]:
    """Yield arrays of one column, and everything else one by one."""
    for array in arrays:
        place = array.place
        if place.offset is None and place.row_step[0] == 0:
            for i in range(place.columns):
                x = place.origin[0] + i * place.column_step[0]
                y = place.origin[1] + i * place.column_step[1]
                step = place.row_step if place.rows > 1 else (0, 0)
                yield ApertureArray(array.shape, Placement((x, y), rows=place.rows, row_step=step))
        else:
            for x, y in place.positions():
                yield ApertureArray(array.shape, Placement((int(x), int(y))))
