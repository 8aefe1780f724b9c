"""Write a library of pieces and a window of the film as a STEP assembly: solids, and their places.

Each piece is drawn once, exactly. The assembly holds the window, and beside it, at negative y, one
of each piece.
"""

from pathlib import Path

import numpy as np

from mpfcad.cad.file.library import piece_name
from mpfcad.cad.step.cell import draw_single
from mpfcad.cad.step.file import PLAIN, Header, StepFile
from mpfcad.cad.step.product import Products
from mpfcad.cad.step.section import FILM_COLOUR
from mpfcad.cad.step.solid import draw_bodies
from mpfcad.errors import InputError
from mpfcad.film import CellFilm, CellLibrary, PieceLibrary

#: Most places of a window.
MOST_PLACES = 20_000
#: Distance of the library's pieces from each other and from the window, over a piece's size.
APART = 2.0


def library_places(
    library: PieceLibrary | CellLibrary,
) -> dict[int, list[tuple[float, float]]]:
    """Return where each piece in use stands [mm]: the first place is that beside the window."""
    pitch, length = library.groove.pitch, library.length
    places: dict[int, list[tuple[float, float]]] = {}
    for number in map(int, np.unique(library.chosen)):
        beside = (len(places) * APART * pitch, -APART * length)
        inside = np.argwhere(library.chosen == number) * (pitch, length)
        places[number] = [beside, *((float(x), float(y)) for x, y in inside)]
    return places


def write_library_step(
    library: PieceLibrary | CellLibrary, path: Path, *, name: str = "film", header: Header = PLAIN
) -> None:
    """Write the assembly in mm; same film and name, same bytes.

    Raises
    ------
    InputError
        when the window has too many places, or a piece cannot be drawn exactly.
    """
    if library.chosen.size > MOST_PLACES:
        raise InputError(
            f"{path.name}: a window of {library.chosen.size} pieces: expected at most "
            f"{MOST_PLACES}: a smaller cad.width_mm, length_mm"
        )
    file = StepFile(header)
    products = Products(file)
    parts, where = {}, {}
    for number, places in library_places(library).items():
        called = piece_name(library, number)
        piece = library.piece(number)
        if isinstance(piece, CellFilm):
            solid = draw_single(piece, products)
        else:
            (solid,) = draw_bodies(file, piece, "fused")["film"]
        parts[called] = products.part(called, [solid], FILM_COLOUR)
        where[called] = places
    products.placed(name, parts, where)
    products.write(Path(path), name)


def window_extent(library: PieceLibrary | CellLibrary) -> tuple[tuple[float, ...], ...]:
    """Return the lowest and highest corner [mm] of window and library."""
    pitch, length = library.groove.pitch, library.length
    count = len(np.unique(library.chosen))
    width = max(library.size[0], ((count - 1) * APART + 1) * pitch)
    high = library.base + library.groove.depth
    return (0.0, -APART * length, 0.0), (width, library.size[1], high)
