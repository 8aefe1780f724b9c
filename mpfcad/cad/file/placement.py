"""The placement list of a film of pieces: where each stands, how it lies, and which it is.

One line a piece, as programs of optics take three-dimensional textures: its origin, the directions
of its own x and y axes, its scale, and its type, the number of the piece in the 3MF file from 1.
"""

from pathlib import Path

import numpy as np

from mpfcad.cad.file.library import piece_name
from mpfcad.errors import ExportError
from mpfcad.film import CellLibrary, PieceLibrary

COLUMNS = "x_mm,y_mm,z_mm,x_axis_x,x_axis_y,x_axis_z,y_axis_x,y_axis_y,y_axis_z,scale,type,name"


def write_placement(library: PieceLibrary | CellLibrary, path: Path) -> None:
    """Write the list over the whole film; same film, same bytes."""
    path = Path(path)
    part = path.with_name("." + path.name + ".part")
    used = np.unique(library.chosen)
    called = {
        int(piece): f"{n},{piece_name(library, int(piece))}" for n, piece in enumerate(used, 1)
    }
    pitch, length = library.groove.pitch, library.length
    try:
        with part.open("w", encoding="ascii", newline="\n") as file:
            file.write(COLUMNS + "\n")
            for i, row in enumerate(library.chosen):
                file.writelines(
                    f"{i * pitch:.12g},{k * length:.12g},0,1,0,0,0,1,0,1,{called[int(piece)]}\n"
                    for k, piece in enumerate(row)
                )
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def check_placement(path: Path, library: PieceLibrary | CellLibrary) -> None:
    """Compare the list at `path` with the film.

    Raises
    ------
    ExportError
        naming the first line that is another piece, or elsewhere.
    """
    path = Path(path)
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=1, usecols=range(11), ndmin=2)
    except ValueError as error:
        raise ExportError(f"{path.name}: not a placement list: {error}") from None
    across, along = np.indices(library.chosen.shape).reshape(2, -1)
    if len(table) != library.chosen.size:
        raise ExportError(f"{path.name}: {len(table)} pieces: expected {library.chosen.size}")
    _, kind = np.unique(library.chosen, return_inverse=True)
    wanted = np.zeros((len(table), 11))
    wanted[:, 0], wanted[:, 1] = across * library.groove.pitch, along * library.length
    wanted[:, [3, 7, 9]] = 1.0
    wanted[:, 10] = 1 + kind.reshape(-1)
    off = np.flatnonzero(~(np.abs(table - wanted) <= 1e-9).all(axis=1))
    if len(off):
        raise ExportError(f"{path.name}: line {off[0] + 2}: another piece, or elsewhere")
