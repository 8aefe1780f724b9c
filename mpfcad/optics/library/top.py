"""A film as few different cells on a grid whose tops are heights over both directions."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.library.piece import joined_places

#: Buckets along each side of a cell, in which a walk to a place begins.
BUCKETS = 8
#: How near [mm] a corner lies to a side of the cell that it is on.
_ROOM = 1e-7
#: What lies beyond an edge where no facet does: the cell's side at x = 0, at the pitch, y = 0, ….
SIDE = 1


@dataclass(frozen=True, eq=False)
class CellTops:
    """Cells of one size, each closed by a top of triangles; lengths in mm.

    Attributes
    ----------
    pitch, length
        size of every cell along x and y
    top
        of each kind of cell the corners (k, 3) float64 of its top, x and y from 0, and its facets
        (t, 3) int64, anticlockwise from above
    chosen
        (n, m) int64, the kind at each place along x and y; the whole repeats without end
    """

    pitch: float
    length: float
    top: tuple[tuple[NDArray[np.float64], NDArray[np.int64]], ...]
    chosen: NDArray[np.int64]

    @property
    def high(self) -> float:
        """Height [mm] of the highest corner over the underside."""
        return float(max(corner[:, 2].max() for corner, _ in self.top))

    @property
    def low(self) -> float:
        """Height [mm] of the lowest corner."""
        return float(min(corner[:, 2].min() for corner, _ in self.top))

    def lowered(self, by: float) -> "CellTops":
        """Return the film without so much [mm] at its underside."""
        return replace(self, top=tuple((corner - (0, 0, by), facet) for corner, facet in self.top))

    @property
    def note(self) -> str:
        """What was read, in a line."""
        across, along = self.chosen.shape
        return f"{len(self.top)} kinds of cell, {across} × {along} places, traced as such"

    @property
    def size(self) -> tuple[float, float]:
        """Extent [mm] along x and y, over which it repeats."""
        across, along = self.chosen.shape
        return across * self.pitch, along * self.length


class CellArrays(NamedTuple):
    """What the kernels read of all films of cells of a scene.

    Attributes
    ----------
    plane
        (t, 4) float64, of each facet z = a + b x + c y [mm]; the last column is unused
    edge
        (3t, 4) float64, of each edge the outward (x, y), and what it comes to on the edge
    beyond
        (3t,) int64, the facet beyond each edge; -1 … -4: the cell's side at x = 0, at the pitch, at
        y = 0, at the length
    start
        (p BUCKETS²,) int64, of each kind of cell the facet over the middle of each bucket
    chosen
        (q,) uint16, the kind at each place, row by row, of one film after the other
    place
        (l, 3) int64, of each film the first place, and places along x and y
    size
        (l, 4) float64, of each film pitch, length, highest and lowest corner [mm]
    """

    plane: NDArray[np.float64]
    edge: NDArray[np.float64]
    beyond: NDArray[np.int64]
    start: NDArray[np.int64]
    chosen: NDArray[np.uint16]
    place: NDArray[np.int64]
    size: NDArray[np.float64]


def build_cells(films: list[CellTops]) -> CellArrays:
    """Return the films as the kernels read them.

    Raises
    ------
    InputError
        when a top does not cover its cell once.
    """
    parts: list[list[NDArray]] = [[np.zeros((0, 4))], [np.zeros((0, 4))], [], []]
    place, size, facets, places = [], [], 0, 0
    for film in films:
        for number, (corner, facet) in enumerate(film.top):
            where = f"library: cell {number}"
            plane, edge = _planes(corner, facet)
            beyond = _beyond(corner, facet, (film.pitch, film.length), where)
            start = _starts(edge, (film.pitch, film.length), where)
            inner = np.where(beyond >= 0, beyond + facets, beyond)
            for part, found in zip(parts, (plane, edge, inner, start + facets), strict=False):
                part.append(found)
            facets += len(facet)
        place.append((places, *film.chosen.shape))
        size.append((film.pitch, film.length, film.high, film.low))
        places += film.chosen.size
    none = np.zeros(0, np.int64)
    chosen = joined_places([(film.chosen, len(film.top)) for film in films])
    beyond, start = (np.concatenate([none, *p]).astype(np.int64) for p in parts[2:])
    return CellArrays(
        np.concatenate(parts[0]), np.concatenate(parts[1]), beyond, start, chosen,
        np.array(place, np.int64).reshape(-1, 3), np.array(size, np.float64).reshape(-1, 4),
    )  # fmt: skip


def _planes(corner: NDArray, facet: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the facets' planes (t, 4) and edges (3t, 4)."""
    p = corner[facet]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    b, c = -normal[:, 0] / normal[:, 2], -normal[:, 1] / normal[:, 2]
    a = p[:, 0, 2] - b * p[:, 0, 0] - c * p[:, 0, 1]
    step = np.roll(p, -1, axis=1) - p
    outward = np.stack([step[..., 1], -step[..., 0]], axis=-1)
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    at = np.sum(outward * p[..., :2], axis=-1)
    edge = np.concatenate([outward, at[..., None], np.zeros_like(at)[..., None]], axis=-1)
    return np.stack([a, b, c, np.zeros_like(a)], axis=1), edge.reshape(-1, 4)


def _beyond(
    corner: NDArray, facet: NDArray, size: tuple[float, float], where: str
) -> NDArray[np.int64]:
    """Return the facet beyond each edge, (3t,), or -1 … -4."""
    first, last = facet.ravel(), np.roll(facet, -1, axis=1).ravel()
    count = len(corner)
    key, back = first * count + last, last * count + first
    order = np.argsort(key)
    if (np.diff(key[order]) == 0).any():
        raise InputError(f"{where}: its top covers a place twice: expected a height over x, y")
    found = order[np.minimum(np.searchsorted(key, back, sorter=order), len(key) - 1)]
    beyond = np.where(key[found] == back, found // 3, -SIDE - 4)
    for side in range(4):
        axis, at = side // 2, (side % 2) * size[side // 2]
        on = np.abs(corner[:, axis] - at) <= _ROOM
        beyond[(beyond == -SIDE - 4) & on[first] & on[last]] = -SIDE - side
    if (beyond == -SIDE - 4).any():
        x, y = corner[first[np.argmin(beyond)], :2]
        raise InputError(
            f"{where}: its top ends at x = {x:g}, y = {y:g} mm: expected it to reach the sides"
        )
    return beyond


def _starts(edge: NDArray, size: tuple[float, float], where: str) -> NDArray[np.int64]:
    """Return the facet over the middle of each bucket, (BUCKETS²,)."""
    lines = edge.reshape(-1, 3, 4)
    found = []
    for i in range(BUCKETS):
        for k in range(BUCKETS):
            x, y = ((n + 0.5) / BUCKETS * extent for n, extent in zip((i, k), size, strict=True))
            outside = (lines[..., 0] * x + lines[..., 1] * y - lines[..., 2]).max(axis=1)
            nearest = int(np.argmin(outside))
            if outside[nearest] > _ROOM:
                raise InputError(f"{where}: no top at x = {x:g}, y = {y:g} mm: expected one")
            found.append(nearest)
    return np.array(found, np.int64)
