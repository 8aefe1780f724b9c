"""Write a library of groove pieces, or of cells, as 3MF: a mesh a piece, an instance a place."""

from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.file.threemf import CORE, XML, mesh_rows, store_package
from mpfcad.cad.shape.cell_mesh import build_cell_mesh
from mpfcad.cad.shape.mesh import Mesh, build_cross_section
from mpfcad.film import CellLibrary, PieceLibrary


def piece_section(library: PieceLibrary, number: int, angle_tolerance: float) -> NDArray:
    """Return the corners (k, 2) float64 [mm] of a piece's top, x from 0 to the pitch, and z."""
    section = build_cross_section(library.piece(number), angle_tolerance, np.float64)
    x = np.asarray(section.x, float) - float(section.x[0])
    x[-1] = library.groove.pitch
    return np.stack([x, np.asarray(section.z, float)], axis=1)


def piece_mesh(section: NDArray[np.float64], length: float) -> Mesh:
    """Return the closed mesh of the solid under a top (k, 2), drawn along y to `length` [mm]."""
    k = len(section)
    end = np.concatenate([section, [(section[-1, 0], 0.0), (section[0, 0], 0.0)]])
    count = k + 2
    vertex = np.concatenate([
        np.stack([end[:, 0], np.full(count, y), end[:, 1]], axis=1) for y in (0.0, length)
    ])  # fmt: skip
    around = np.arange(count)
    after = (around + 1) % count
    side = np.concatenate([
        np.stack([around, after, after + count], axis=1),
        np.stack([around, after + count, around + count], axis=1),
    ])  # fmt: skip
    # The ends: the top is a height over the base's corners, so fans from both cover it.
    low = int(np.argmin(section[:, 1]))
    right, left = k, k + 1
    fan = [(left, right, low)]
    fan += [(left, i + 1, i) for i in range(low)]
    fan += [(right, i + 1, i) for i in range(low, k - 1)]
    front = np.array(fan)
    back = front[:, ::-1] + count
    return Mesh(vertex, np.concatenate([side, front, back]).astype(np.int64))


def write_library(
    library: PieceLibrary | CellLibrary, path: Path, angle_tolerance: float, *, name: str = "film"
) -> None:
    """Write each piece in use as a mesh within `angle_tolerance` [rad], and an item a place.

    Coordinates are decimal numbers of doubles. Same library, same bytes.
    """
    store_package(Path(path), _model(library, angle_tolerance, name))


def used_meshes(
    library: PieceLibrary | CellLibrary, angle_tolerance: float
) -> Iterator[tuple[int, str, Mesh]]:
    """Give number, name and closed mesh of each piece that stands somewhere."""
    for number in map(int, np.unique(library.chosen)):
        if isinstance(library, CellLibrary):
            mesh = build_cell_mesh(library.piece(number), angle_tolerance)
        else:
            mesh = piece_mesh(piece_section(library, number, angle_tolerance), library.length)
        yield number, piece_name(library, number), mesh


def piece_name(library: PieceLibrary | CellLibrary, number: int) -> str:
    """Return what a piece is called: its curvatures."""
    both = dict.fromkeys(np.atleast_1d(library.curvature[number]))
    return f"C {' x '.join(f'{c:.6f}' for c in both)} /mm"


def _model(library: PieceLibrary | CellLibrary, angle_tolerance: float, name: str) -> Iterator[str]:
    yield f'{XML}<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}">'
    yield f'<metadata name="Title">{quoteattr(name)[1:-1]}</metadata>'
    yield '<metadata name="Application">mpfcad</metadata><resources>'
    identity: dict[int, int] = {}
    for number, called, mesh in used_meshes(library, angle_tolerance):
        identity[number] = 1 + len(identity)
        label = quoteattr(called)
        yield f'<object id="{identity[number]}" type="model" name={label}><mesh>'
        yield from mesh_rows(mesh)
        yield "</mesh></object>"
    yield "</resources><build>"
    pitch, length = library.groove.pitch, library.length
    for i, row in enumerate(library.chosen):
        yield "".join(
            f'<item objectid="{identity[int(piece)]}" transform="1 0 0 0 1 0 0 0 1 '
            f'{i * pitch:.12g} {k * length:.12g} 0"/>'
            for k, piece in enumerate(row)
        )
    yield "</build></model>"
