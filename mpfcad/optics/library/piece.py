"""A film as few different groove pieces on a grid: what a 3MF file of instances holds."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

#: Most different pieces of a library.
MOST = 4096
#: Most of all films of a scene.
_MOST_KINDS = 65_536
#: Ends of a section may differ by so much [mm].
_ROOM = 1e-7


@dataclass(frozen=True, eq=False)
class Library:
    """Pieces one groove wide and a given length along y; lengths in mm.

    Attributes
    ----------
    pitch, length
        size of every piece along x and y
    section
        of each piece the corners (k, 2) float64 of its top, x from 0 to the pitch and z, which
        begin and end at the tips
    chosen
        (n, m) int64, the piece at each place along x and y; the whole repeats without end
    """

    pitch: float
    length: float
    section: tuple[NDArray[np.float64], ...]
    chosen: NDArray[np.int64]

    def __post_init__(self) -> None:
        for number, corner in enumerate(self.section):
            where = f"library: piece {number}"
            if len(corner) < 2 or (np.diff(corner[:, 0]) <= 0).any():
                raise InputError(f"{where}: its top: expected x that rises from tip to tip")
            if abs(corner[0, 0]) > _ROOM or abs(corner[-1, 0] - self.pitch) > _ROOM:
                raise InputError(
                    f"{where}: x {corner[0, 0]:g} … {corner[-1, 0]:g} mm: expected 0 … "
                    f"{self.pitch:g}, one groove"
                )
            if abs(corner[[0, -1], 1] - self.high).max() > _ROOM:
                raise InputError(
                    f"{where}: tips at {corner[0, 1]:g} and {corner[-1, 1]:g} mm: expected all "
                    f"at {self.high:g}"
                )
        if self.chosen.ndim != 2 or not self.chosen.size:
            raise InputError("library: no pieces are placed: expected one or more")
        if self.chosen.min() < 0 or self.chosen.max() >= len(self.section):
            raise InputError(
                f"library: piece {self.chosen.max()}: expected 0 … {len(self.section)}"
            )

    @property
    def high(self) -> float:
        """Height [mm] of the tips over the underside."""
        return float(max(corner[:, 1].max() for corner in self.section))

    @property
    def low(self) -> float:
        """Height [mm] of the lowest corner."""
        return float(min(corner[:, 1].min() for corner in self.section))

    def lowered(self, by: float) -> "Library":
        """Return the film without so much [mm] at its underside."""
        return replace(self, section=tuple(corner - (0.0, by) for corner in self.section))

    @property
    def note(self) -> str:
        """What was read, in a line."""
        across, along = self.chosen.shape
        return f"{len(self.section)} pieces of a groove, {across} × {along} places, traced as such"

    @property
    def size(self) -> tuple[float, float]:
        """Extent [mm] along x and y, over which it repeats."""
        across, along = self.chosen.shape
        return across * self.pitch, along * self.length


class LibraryArrays(NamedTuple):
    """What the kernels read of all libraries of a scene.

    Attributes
    ----------
    x, z
        (c,) float64 [mm], corners of all pieces one behind the other
    first
        (p+1,) int64, the first corner of each piece
    chosen
        (q,) uint16, the piece at each place, row by row, of one library after the other
    place
        (l, 3) int64, of each library the first place, and places along x and y
    size
        (l, 4) float64, of each library pitch, length, tips, and the lowest corner [mm]
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    first: NDArray[np.int64]
    chosen: NDArray[np.uint16]
    place: NDArray[np.int64]
    size: NDArray[np.float64]


PITCH, LENGTH, HIGH, LOW = range(4)


def joined_places(films: list[tuple[NDArray[np.int64], int]]) -> NDArray[np.uint16]:
    """Return what stands at each place of films (places, kinds), kinds numbered through, (q,).

    Two bytes a place: the places of a panel are looked up at random, and what fits a cache is
    found sooner.

    Raises
    ------
    InputError
        when all films have more kinds than two bytes can tell.
    """
    kinds = sum(count for _, count in films)
    if kinds > _MOST_KINDS:
        raise InputError(f"library: {kinds} pieces in all films: expected at most {_MOST_KINDS}")
    joined = np.empty(sum(chosen.size for chosen, _ in films), np.uint16)
    start = before = 0
    for chosen, count in films:
        end = start + chosen.size
        np.add(chosen.ravel(), before, out=joined[start:end], casting="unsafe")
        start, before = end, before + count
    return joined


def build_libraries(libraries: list[Library]) -> LibraryArrays:
    """Return the libraries as the kernels read them."""
    corners = [corner for library in libraries for corner in library.section]
    corner = np.concatenate([*corners, np.zeros((0, 2))])
    first = np.concatenate([[0], np.cumsum([len(part) for part in corners])]).astype(np.int64)
    place, size, pieces, places = [], [], 0, 0
    for library in libraries:
        place.append((places, *library.chosen.shape))
        size.append((library.pitch, library.length, library.high, library.low))
        pieces += len(library.section)
        places += library.chosen.size
    return LibraryArrays(
        np.ascontiguousarray(corner[:, 0]),
        np.ascontiguousarray(corner[:, 1]),
        first,
        joined_places([(film.chosen, len(film.section)) for film in libraries]),
        np.array(place, np.int64).reshape(-1, 3),
        np.array(size, np.float64).reshape(-1, 4),
    )
