"""Reads a library of groove pieces, or of cells, from a 3MF of instances, by lib3mf and expat."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary.threemf import Instances, read_instances
from mpfcad.errors import InputError
from mpfcad.optics.library.piece import Library
from mpfcad.optics.library.top import CellTops

#: Places may be off the grid, and corners off each other, by so much [mm]: lib3mf's float32.
_ROOM = 1e-5
#: A piece's volume may differ from that under its top by this share.
_VOLUME = 1e-5
#: A facet stands upright whose area from above is less than this share of a cell's; how near [mm]
#: a corner is on a cell's side.
_SLIVER, _SIDE = 1e-12, 1e-8


def is_library_file(path: Path) -> bool:
    """Return whether a file is a 3MF with more than one item to build: what is read here."""
    if Path(path).suffix.lower() != ".3mf" or not Path(path).is_file():
        return False
    import lib3mf

    model = lib3mf.Wrapper().CreateModel()
    try:
        model.QueryReader("3mf").ReadFromFile(str(path))
        return int(model.GetBuildItems().Count()) > 1
    except lib3mf.ELib3MFException:
        return False


def read_library(path: Path) -> Library | CellTops:
    """Return the library of a 3MF file whose items are groove pieces or cells side by side.

    Raises
    ------
    InputError
        when a mesh is no such piece, or the places do not cover a rectangle once.
    """
    meshes = _meshes(path)
    found = _instances(path, meshes)
    # Pieces that no instance uses are none of the film.
    meshes = {number: meshes[number] for number in np.unique(found.number).tolist()}
    where = {identity: f"{path}: 3MF object {identity}" for identity in meshes}
    sizes = np.array([_size(where[identity], point) for identity, (point, _) in meshes.items()])
    if np.ptp(sizes, axis=0).max() > _ROOM:
        raise InputError(f"{path}: 3MF: pieces of {sizes.min(0)} … {sizes.max(0)} mm: expected one")
    pitch, length = (round(float(size), 7) for size in sizes.mean(axis=0))
    chosen = _placed(path, found, list(meshes), sizes.mean(axis=0))
    drawn = [_section(*mesh) for mesh in meshes.values()]
    sections = tuple(section for section in drawn if section is not None)
    if len(sections) == len(drawn):
        for identity, section in zip(meshes, sections, strict=True):
            area = float(np.sum(np.diff(section[:, 0]) * (section[1:, 1] + section[:-1, 1]) / 2))
            _check_volume(where[identity], *meshes[identity], area * length)
        return Library(pitch, length, sections, chosen)
    tops = tuple(_top(where[identity], *mesh, (pitch, length)) for identity, mesh in meshes.items())
    return CellTops(pitch, length, tops, chosen)


def _placed(
    path: Path, found: Instances, identities: list[int], size: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the piece at each place of the grid, (n, m)."""
    place = found.transform[:, 3, :2] / size
    grid = np.round(place - place.min(axis=0)).astype(np.int64)
    off = float((np.abs(place - place.min(axis=0) - grid) * size).max())
    shape = tuple(int(n) for n in grid.max(axis=0) + 1)
    count = len(grid)
    if off > _ROOM or len(np.unique(grid, axis=0)) != count or count != np.prod(shape):
        raise InputError(
            f"{path}: 3MF: {count} instances, up to {off:.2g} mm off a grid of {shape[0]} × "
            f"{shape[1]}: expected one at each place"
        )
    chosen = np.zeros(shape, np.int64)
    chosen[grid[:, 0], grid[:, 1]] = np.searchsorted(identities, found.number)
    return chosen


def _meshes(path: Path) -> dict[int, tuple[NDArray, NDArray]]:
    """Return the mesh objects by the file's own numbers."""
    import lib3mf

    model = lib3mf.Wrapper().CreateModel()
    try:
        model.QueryReader("3mf").ReadFromFile(str(path))
        if model.GetUnit().name != "MilliMeter":
            raise InputError(f"{path}: 3MF: unit {model.GetUnit().name}: expected millimetres")
        found = model.GetMeshObjects()
        meshes = {}
        while found.MoveNext():
            thing = found.GetCurrentMeshObject()
            meshes[int(thing.GetModelResourceID())] = _mesh(thing)
    except lib3mf.ELib3MFException as error:
        raise InputError(f"{path}: lib3mf cannot read this 3MF: {error}") from None
    return meshes


def _instances(path: Path, meshes: dict[int, Any]) -> Instances:
    """Return the instances of a file's meshes, each moved alone."""
    found = read_instances(path)
    strange = set(found.number.tolist()) - set(meshes)
    if strange:
        raise InputError(
            f"{path}: 3MF object {min(strange)}: an assembly: expected pieces as meshes"
        )
    upright = np.abs(found.transform[:, :3] - np.eye(3)).max() <= 1e-6
    level = np.abs(found.transform[:, 3, 2]).max() <= _ROOM
    if not (upright and level):
        raise InputError(f"{path}: 3MF: an instance is turned or lifted: expected it moved alone")
    return found


def _mesh(thing: Any) -> tuple[NDArray, NDArray]:
    point = np.array([tuple(p.Coordinates) for p in thing.GetVertices()], float)
    return point, np.array([tuple(t.Indices) for t in thing.GetTriangleIndices()], np.int64)


def _size(where: str, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the extent along x and y of a piece that begins at 0, 0, 0."""
    low, high = point.min(axis=0), point.max(axis=0)
    if np.abs(low).max() > _ROOM:
        raise InputError(f"{where}: begins at {low} mm: expected 0, 0, 0")
    return high[:2]


def _section(point: NDArray[np.float64], facet: NDArray[np.int64]) -> NDArray[np.float64] | None:
    """Return the top (k, 2), x and z, of a piece drawn along y; None: it is not."""
    high = point.max(axis=0)
    ends = [point[np.abs(point[:, 1] - y) < _ROOM][:, [0, 2]] for y in (0.0, high[1])]
    tops = [end[end[:, 1] > _ROOM] for end in ends]
    front, back = (top[np.argsort(top[:, 0], kind="stable")] for top in tops)
    drawn = len(ends[0]) + len(ends[1]) == len(point) and front.shape == back.shape
    if not drawn or np.abs(front - back).max() > _ROOM:
        return None
    front[0, 0], front[-1, 0] = 0.0, round(float(high[0]), 7)
    front[[0, -1], 1] = high[2]
    return front


def _check_volume(
    where: str, point: NDArray[np.float64], facet: NDArray[np.int64], under: float
) -> None:
    """Refuse a piece that is not all that lies under its top."""
    a, b, c = (point[facet[:, i]] for i in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    if abs(volume - under) > _VOLUME * abs(under):
        raise InputError(f"{where}: volume {volume:g} mm³: expected {under:g}, closed")


def _top(
    where: str, point: NDArray[np.float64], facet: NDArray[np.int64], size: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the corners and facets of a cell's top: those that look up."""
    a, b, c = (point[facet[:, i]] for i in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    flat = _SLIVER * size[0] * size[1]
    used, facets = np.unique(facet[area > flat], return_inverse=True)
    covered = float(area[area > flat].sum() / 2)
    if abs(covered - size[0] * size[1]) > _VOLUME * size[0] * size[1]:
        raise InputError(
            f"{where}: its top covers {covered:g} mm²: expected {size[0] * size[1]:g}, a height "
            "over x and y"
        )
    corner = point[used]
    for axis in (0, 1):  # lib3mf's float32 taken off the sides
        for side in (0.0, size[axis]):
            corner[np.abs(corner[:, axis] - side) < _SIDE, axis] = side
    mean = corner[facets.reshape(-1, 3)][..., 2].mean(axis=1)
    _check_volume(where, point, facet, float(np.sum(mean * area[area > flat] / 2)))
    return corner, facets.reshape(-1, 3).astype(np.int64)
