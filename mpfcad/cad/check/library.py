"""Read a library of pieces or cells, a 3MF of instances, back with lib3mf and expat; compare it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary.threemf import Instances, read_instances
from mpfcad.cad.check.cell import check_cell
from mpfcad.cad.check.mesh_check import refuse_above
from mpfcad.cad.check.mesh_file_check import BodyCheck, body_volume, check_volume, merged_height
from mpfcad.cad.check.threemf import read_model
from mpfcad.cad.file.library import piece_name
from mpfcad.errors import ExportError, InputError
from mpfcad.film import CellLibrary, PieceLibrary, PrismFilm

#: A corner may be off the surface by so many steps of float32, in x and z.
STEPS = 4


@dataclass(frozen=True, eq=False)
class PlacedPieces:
    """What a 3MF of instances holds.

    Attributes
    ----------
    point, facet
        of each piece by its number in the file: (v, 3) float64 [mm], (t, 3) int64
    open_piece
        number of a piece that is not closed and oriented; None: all are
    number
        (k,) int64, piece of each instance
    place
        (k, 2) float64 [mm], x and y by which it is moved
    """

    point: dict[int, NDArray[np.float64]]
    facet: dict[int, NDArray[np.int64]]
    open_piece: int | None
    number: NDArray[np.int64]
    place: NDArray[np.float64]


@dataclass(frozen=True)
class LibraryCheck(BodyCheck):
    """What a library file was found to hold, of its pieces and over all places.

    Attributes
    ----------
    solid
        volume [mm³] of all instances together
    curvature
        (n, m) float64 [1/mm], C through the tips of the piece at each place, by its lowest corner;
        of cells with two, (n, m, 2)
    """

    solid: float
    curvature: NDArray[np.float64]


def read_pieces(path: Path) -> PlacedPieces:
    """Return the pieces of a 3MF file and where their instances stand.

    Raises
    ------
    ExportError
        when lib3mf cannot read it, its unit is not mm, or an instance is turned or lifted.
    """
    path = Path(path)
    model = read_model(path)
    point, facet, open_piece = {}, {}, None
    meshes = model.GetMeshObjects()
    while meshes.MoveNext():
        mesh = meshes.GetCurrentMeshObject()
        identity = int(mesh.GetModelResourceID())
        point[identity] = np.array([tuple(p.Coordinates) for p in mesh.GetVertices()], np.float64)
        facet[identity] = np.array([tuple(t.Indices) for t in mesh.GetTriangleIndices()], np.int64)
        if not mesh.IsManifoldAndOriented():
            open_piece = identity
    items = _instances(path)
    if len(items.number) != int(model.GetBuildItems().Count()):
        raise ExportError(f"{path.name}: lib3mf finds other items to build: expected the same")
    return PlacedPieces(point, facet, open_piece, items.number, items.transform[:, 3, :2])


def _instances(path: Path) -> Instances:
    """Return the items to build, each moved alone."""
    try:
        found = read_instances(path)
    except InputError as error:
        raise ExportError(str(error)) from error
    upright = np.array_equal(found.transform[:, :3], np.tile(np.eye(3), (len(found.number), 1, 1)))
    if not upright or found.transform[:, 3, 2].any():
        raise ExportError(f"{path.name}: an instance is turned or lifted: expected it moved alone")
    return found


def check_library(path: Path, library: PieceLibrary | CellLibrary) -> LibraryCheck:
    """Return what the 3MF file at `path` holds, once it is found to be `library`.

    Raises
    ------
    ExportError
        when a piece is missing, not closed, off in volume or surface, or an instance is not the
        piece that stands at its place.
    """
    path = Path(path)
    found = read_pieces(path)
    if found.open_piece is not None:
        raise ExportError(f"{path.name}: piece {found.open_piece}: not closed and oriented")
    _check_places(path, library, found)
    volume, count, curvature = {}, {}, np.zeros(library.curvature.shape)
    # The file's pieces are those in use, in their order.
    for identity, number in zip(
        sorted(found.point), map(int, np.unique(library.chosen)), strict=True
    ):
        point, name = found.point[identity], piece_name(library, number)
        volume[name] = body_volume(point, found.facet[identity])
        count[name] = len(found.facet[identity])
        top = point[point[:, 2] > 0]
        if isinstance(library, CellLibrary):
            curvature[number] = check_cell(path, name, top, library.piece(number), volume[name])
        else:
            curvature[number] = _check_piece(path, name, top, library.piece(number), volume[name])
    each = np.array(list(volume.values()))
    _, kind = np.unique(library.chosen, return_inverse=True)
    if curvature.ndim == 2 and np.array_equal(library.curvature[:, 0], library.curvature[:, 1]):
        curvature = curvature[:, 0]
    return LibraryCheck(volume, count, float(each[np.ravel(kind)].sum()), curvature[library.chosen])


def _check_piece(
    path: Path, name: str, top: NDArray[np.float64], piece: PrismFilm, volume: float
) -> float:
    """Return C [1/mm] of a groove piece by its top's corners, compared with the closed form."""
    check_volume(path, name, volume, piece.volume, piece.volume)
    off = float(np.abs(top[:, 2] - piece.height(top[:, 0])).max())
    step = float(np.spacing(np.float32(max(piece.thickness, piece.length))))
    room = STEPS * (1 + piece.groove.wall_slope) * step + merged_height(piece)
    refuse_above(path, f"{name}: height error [mm]", off, room)
    return _curvature(top, piece)


def _curvature(top: NDArray[np.float64], piece: PrismFilm) -> float:
    """Return C [1/mm] through the tips by the lowest corner, which the parabola holds.

    z = thickness - C/2 (w² - x²), x from the groove's middle and w half of the pitch.
    """
    x, _, z = top[np.argmin(top[:, 2])]
    half = piece.groove.half_width
    return float(2 * (piece.thickness - z) / (half**2 - (x - half) ** 2))


def _check_places(path: Path, library: PieceLibrary | CellLibrary, found: PlacedPieces) -> None:
    """Refuse instances that are not the library's, one at each place."""
    used, chosen = np.unique(library.chosen, return_inverse=True)
    if len(found.point) != len(used) or len(found.number) != library.chosen.size:
        raise ExportError(
            f"{path.name}: {len(found.point)} pieces, {len(found.number)} instances: expected "
            f"{len(used)}, {library.chosen.size}"
        )
    across, along = np.indices(library.chosen.shape)
    wanted = np.stack([across.ravel() * library.groove.pitch, along.ravel() * library.length], 1)
    step = float(np.spacing(np.float32(max(library.size))))
    refuse_above(path, "place of an instance [mm]", float(np.abs(found.place - wanted).max()), step)
    identity = np.array(sorted(found.point))[np.ravel(chosen)]
    wrong = np.flatnonzero(identity != found.number)
    if len(wrong):
        raise ExportError(
            f"{path.name}: instance {wrong[0]} is piece {found.number[wrong[0]]}: expected "
            f"{identity[wrong[0]]}"
        )


def mean_difference(
    library: PieceLibrary | CellLibrary, found: NDArray[np.float64], side: float
) -> float:
    """Return the largest difference [1/mm] of C found (n, m) from the map's, mean over squares.

    Pieces are rounded to few curvatures, and what is left is handed on: means are what they keep.
    `side` [mm] of the squares, of whole pieces, one at least; of cells with two C, (n, m, 2), the
    larger one.
    """
    step = [max(1, round(side / size)) for size in (library.groove.pitch, library.length)]
    edge = [np.arange(0, count, by) for count, by in zip(found.shape, step, strict=False)]
    both = library.wanted
    wanted = both[..., 0] if both.ndim == 3 and found.ndim == 2 else both
    off = np.add.reduceat(np.add.reduceat(found - wanted, edge[0], 0), edge[1], 1)
    count = np.outer(*(np.diff(np.append(e, n)) for e, n in zip(edge, found.shape, strict=False)))
    return float(np.abs(off / (count if found.ndim == 2 else count[..., None])).max())
