"""Reads a film mesh from an STL file and makes sure that it can be traced as a repeating tile.

The tracer starts from the file alone. It asks for a closed, outward oriented mesh with a flat
underside and upright sides whose top repeats from side to side: then the film continues beyond its
edges as copies of itself, and what happens between lamps far from the panel's rim is traced without
one.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.mesh_solid import at, check_solid

_RECORD = np.dtype(
    [("normal", "<f4", (3,)), ("vertex", "<f4", (3, 3)), ("attribute", "<u2")], align=False
)


@dataclass(frozen=True, eq=False)
class FilmMesh:
    """A film tile: its top surface as triangles, over a flat underside at z = 0.

    Attributes
    ----------
    vertex
        (v, 3) float64 [mm], moved so that the tile spans x 0…width, y 0…length, z 0…thickness
    top
        (t, 3) int64, vertex numbers of the facets that are neither underside nor side
    size
        (width, length, thickness) [mm]
    """

    vertex: NDArray[np.float64]
    top: NDArray[np.int64]
    size: tuple[float, float, float]


def read_film_mesh(path: Path) -> FilmMesh:
    """Return the film tile of a binary STL file (coordinates in mm).

    Raises
    ------
    InputError
        when the file is missing or no binary STL, or the mesh is open, inverted, without a flat
        underside, or does not repeat from side to side; the text names the place.
    """
    vertex, facet = read_solid(path)
    check_solid(path, vertex, facet)
    return film_of(path, vertex, facet)


def read_solid(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (v, 3) [mm] and facets (n, 3) of a binary STL file, whatever they bound.

    Raises
    ------
    InputError
        when the file is missing or no binary STL, or a number in it is not finite.
    """
    path = Path(path)
    vertex, facet = weld(read_facets(path))
    _check_finite(path, vertex)
    return vertex, facet


def film_of(path: Path, vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> FilmMesh:
    """Return the film tile that the facets of a solid are.

    Raises
    ------
    InputError
        when it is no film or does not repeat from side to side; the text names the place.
    """
    low, high = vertex.min(axis=0), vertex.max(axis=0)
    vertex = vertex - low
    size = high - low
    if not (size > 0).all():
        raise InputError(f"{path}: mesh: extent {tuple(size)} mm: must be a solid")
    top = _top_facets(path, vertex, facet, size)
    _check_repeats(path, vertex, top, size)
    return FilmMesh(vertex, top, (float(size[0]), float(size[1]), float(size[2])))


def read_facets(path: Path) -> NDArray[np.float32]:
    """Return the facets' corners, (n, 3, 3) float32 [mm]."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    count = int.from_bytes(data[80:84], "little")
    if len(data) < 84 or len(data) != 84 + count * _RECORD.itemsize:
        raise InputError(
            f"{path}: not a binary STL: {len(data)} bytes for {count} facets, "
            f"expected {84 + count * _RECORD.itemsize}"
        )
    if count < 4:
        raise InputError(f"{path}: mesh: {count} facets: at least 4 make a solid")
    return np.frombuffer(data, _RECORD, count, offset=84)["vertex"]


def weld(corner: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (v, 3) float64 and facets (n, 3) int64; equal coordinates are one vertex.

    Facets with two equal corners bound nothing and are left out: their neighbours join.
    """
    points = corner.reshape(-1, 3) + np.float32(0)  # -0 becomes 0
    # Two coordinates a whole number: sorted several times faster than records.
    bits = points.view(np.uint32)
    number = _numbered(_numbered(bits[:, 0], bits[:, 1]), bits[:, 2])
    vertex = np.empty((number.max() + 1, 3))
    vertex[number] = points
    facet = number.reshape(-1, 3)
    collapsed = (facet == np.roll(facet, 1, axis=1)).any(axis=1)
    return vertex, facet[~collapsed]


def _numbered(high: NDArray[np.integer], low: NDArray[np.uint32]) -> NDArray[np.int64]:
    """Return the rank of each pair, (n,), in the order of `high`, then of `low`."""
    key = high.astype(np.uint64)
    key <<= np.uint64(32)
    key |= low
    order = np.argsort(key)
    key = key[order]
    rank = np.empty(len(key), np.int64)
    rank[order] = np.r_[0, np.cumsum(key[1:] != key[:-1])]
    return rank


def _check_finite(path: Path, vertex: NDArray[np.float64]) -> None:
    bad = np.flatnonzero(~np.isfinite(vertex).all(axis=1))
    if len(bad):
        raise InputError(f"{path}: mesh: vertex {vertex[bad[0]]}: must be finite")


def _top_facets(
    path: Path, vertex: NDArray[np.float64], facet: NDArray[np.int64], size: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the facets that are neither the underside nor one of the four upright sides."""
    corner = vertex[facet]
    under = (corner[..., 2] == 0).all(axis=1)
    side = np.zeros(len(facet), bool)
    for axis in (0, 1):
        for plane in (0.0, size[axis]):
            side |= (corner[..., axis] == plane).all(axis=1)
    edges = corner[under]
    area = np.abs(np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])[:, 2]).sum() / 2
    if abs(area - size[0] * size[1]) > 1e-6 * size[0] * size[1]:
        raise InputError(
            f"{path}: mesh: flat underside at the lowest z covers {area:g} mm² of "
            f"{size[0] * size[1]:g} mm²: a film needs a flat rectangular underside"
        )
    top = facet[~under & ~side]
    up = np.cross(vertex[top[:, 1]] - vertex[top[:, 0]], vertex[top[:, 2]] - vertex[top[:, 0]])[
        :, 2
    ]
    projected = up.sum() / 2
    if (up < 0).any() or abs(projected - size[0] * size[1]) > 1e-6 * size[0] * size[1]:
        bad = at(vertex[top[np.argmin(up)]].mean(axis=0))
        raise InputError(
            f"{path}: mesh: the upper surface near {bad} overhangs or leaves part of the "
            "rectangle uncovered: a film's top is one height over its whole base"
        )
    # One height over its base cannot cross itself; touch the underside it can.
    thin = vertex[top][..., 2] == 0
    if thin.any():
        raise InputError(
            f"{path}: mesh: touches itself at {at(vertex[top][thin][0])}: "
            "the upper surface must lie above the underside"
        )
    return top


def _check_repeats(
    path: Path, vertex: NDArray[np.float64], top: NDArray[np.int64], size: NDArray[np.float64]
) -> None:
    """Raise unless the top meets opposite sides in the same line."""
    used = vertex[np.unique(top)]
    for axis, name in ((0, "x"), (1, "y")):
        other = 1 - axis
        lines = []
        for plane in (0.0, size[axis]):
            line = used[used[:, axis] == plane][:, (other, 2)]
            lines.append(line[np.lexsort(line.T)])
        if lines[0].shape != lines[1].shape or (lines[0] != lines[1]).any():
            raise InputError(
                f"{path}: mesh: the upper surface at {name} = 0 and {name} = {size[axis]:g} mm "
                "differs: the tile must repeat from side to side"
            )
