"""Reads a library of groove pieces from a 3MF file of instances, by lib3mf."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.library.piece import Library

#: Places may be off the grid, and corners off each other, by so much [mm]: lib3mf's float32.
_ROOM = 1e-5
#: A piece's volume may differ from that under its top by this share.
_VOLUME = 1e-5


def is_library_file(path: Path) -> bool:
    """Return whether a file is a 3MF with more than one item to build: what is read here."""
    if Path(path).suffix.lower() != ".3mf" or not Path(path).is_file():
        return False
    try:
        return len(_items(path)[1]) > 1
    except InputError:
        return False


def read_library(path: Path) -> Library:
    """Return the library of a 3MF file whose items are groove pieces side by side.

    Raises
    ------
    InputError
        when a mesh is no such piece, or the places do not cover a rectangle once.
    """
    meshes, items = _items(path)
    pieces = {identity: _piece(path, identity, *mesh) for identity, mesh in meshes.items()}
    sizes = np.array([size for _, size in pieces.values()])
    if np.ptp(sizes, axis=0).max() > _ROOM:
        raise InputError(f"{path}: 3MF: pieces of {sizes.min(0)} … {sizes.max(0)} mm: expected one")
    pitch, length = sizes.mean(axis=0)
    number = {identity: place for place, identity in enumerate(pieces)}
    placed = np.array([[*shift, number[identity]] for identity, shift in items])
    place = placed[:, :2] / (pitch, length)
    grid = np.round(place - place.min(axis=0)).astype(np.int64)
    off = float((np.abs(place - place.min(axis=0) - grid) * (pitch, length)).max())
    shape = tuple(int(n) for n in grid.max(axis=0) + 1)
    if off > _ROOM or len(np.unique(grid, axis=0)) != len(items) or len(items) != np.prod(shape):
        raise InputError(
            f"{path}: 3MF: {len(items)} instances, up to {off:.2g} mm off a grid of {shape[0]} × "
            f"{shape[1]}: expected one at each place"
        )
    chosen = np.zeros(shape, np.int64)
    chosen[grid[:, 0], grid[:, 1]] = placed[:, 2].astype(np.int64)
    sections = tuple(section for section, _ in pieces.values())
    return Library(round(float(pitch), 7), round(float(length), 7), sections, chosen)


def _items(path: Path) -> tuple[dict[int, tuple[NDArray, NDArray]], list[tuple[int, NDArray]]]:
    """Return mesh objects by number, and (number, (x, y) [mm]) of each item."""
    import lib3mf

    meshes: dict[int, tuple[NDArray, NDArray]] = {}
    placed: list[tuple[int, NDArray]] = []
    model = lib3mf.Wrapper().CreateModel()
    try:
        model.QueryReader("3mf").ReadFromFile(str(path))
        if model.GetUnit().name != "MilliMeter":
            raise InputError(f"{path}: 3MF: unit {model.GetUnit().name}: expected millimetres")
        items = model.GetBuildItems()
        while items.MoveNext():
            item = items.GetCurrent()
            thing = item.GetObjectResource()
            identity = int(thing.GetUniqueResourceID())
            if not thing.IsMeshObject():
                raise InputError(f"{path}: 3MF: an assembly: expected pieces as meshes")
            if identity not in meshes:
                meshes[identity] = _mesh(thing)
            placed.append((identity, _shift(path, item)))
    except lib3mf.ELib3MFException as error:
        raise InputError(f"{path}: lib3mf cannot read this 3MF: {error}") from None
    return meshes, placed


def _mesh(thing: Any) -> tuple[NDArray, NDArray]:
    point = np.array([tuple(p.Coordinates) for p in thing.GetVertices()], float)
    return point, np.array([tuple(t.Indices) for t in thing.GetTriangleIndices()], np.int64)


def _shift(path: Path, item: Any) -> NDArray[np.float64]:
    if not item.HasObjectTransform():
        return np.zeros(2)
    table = np.array([list(row) for row in item.GetObjectTransform().Fields], float)
    if table.shape != (4, 3):
        table = table.T
    if np.abs(table[:3] - np.eye(3)).max() > 1e-6 or abs(table[3, 2]) > _ROOM:
        raise InputError(f"{path}: 3MF: an instance is turned or lifted: expected it moved alone")
    return table[3, :2]


def _piece(
    path: Path, identity: int, point: NDArray[np.float64], facet: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (top (k, 2), size along x and y) of a piece drawn along y."""
    where = f"{path}: 3MF object {identity}"
    low, high = point.min(axis=0), point.max(axis=0)
    if np.abs(low).max() > _ROOM:
        raise InputError(f"{where}: begins at {low} mm: expected 0, 0, 0")
    ends = [point[np.abs(point[:, 1] - y) < _ROOM][:, [0, 2]] for y in (0.0, high[1])]
    tops = [end[end[:, 1] > _ROOM] for end in ends]
    front, back = (top[np.argsort(top[:, 0], kind="stable")] for top in tops)
    drawn = len(ends[0]) + len(ends[1]) == len(point) and front.shape == back.shape
    if not drawn or np.abs(front - back).max() > _ROOM:
        raise InputError(f"{where}: expected a groove's top drawn along y")
    a, b, c = (point[facet[:, i]] for i in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    area = float(np.sum(np.diff(front[:, 0]) * (front[1:, 1] + front[:-1, 1]) / 2))
    if abs(volume - area * high[1]) > _VOLUME * abs(area * high[1]):
        raise InputError(f"{where}: volume {volume:g} mm³: expected {area * high[1]:g}, closed")
    front[0, 0], front[-1, 0] = 0.0, round(float(high[0]), 7)
    front[[0, -1], 1] = high[2]
    return front, high[:2]
