"""Whether facets bound a solid: closed, oriented outward, meeting nowhere but at their edges."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

#: Facets looked at together.
_CHUNK = 1 << 17
_MEET = "facets may meet only in the edges and corners they share"


def check_solid(path: Path, vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> None:
    """Raise unless facets (n, 3) over vertices (v, 3) float64 [mm] bound a solid.

    Raises
    ------
    InputError
        when the mesh is open, inverted, or touches or crosses itself; the text names the place.
    """
    fault = find_fault(vertex, facet)
    if fault:
        raise InputError(f"{path}: mesh: {fault}")


def find_fault(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> str | None:
    """Return why facets bound no solid and where, in words, or None where they do."""
    return _open_edge(vertex, facet) or _inverted(vertex, facet) or _contact(vertex, facet)


def at(point: NDArray[np.float64]) -> str:
    """Return a place in words."""
    return "({:.6g}, {:.6g}, {:.6g}) mm".format(*(np.asarray(point) + 0.0))


def _open_edge(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> str | None:
    """Return where a directed edge has not its reverse exactly once."""
    start = facet.ravel()
    end = np.roll(facet, -1, axis=1).ravel()
    count = len(vertex)
    forward, backward = np.sort(start * count + end), np.sort(end * count + start)
    if (forward == backward).all() and (forward[1:] != forward[:-1]).all():
        return None
    edge, times = np.unique(forward, return_counts=True)
    reverse = edge % count * count + edge // count
    right = np.searchsorted(backward, edge, side="right")
    returns = right - np.searchsorted(backward, edge)
    # `backward` holds as often what `forward` holds the other way round.
    unpaired = edge[returns != times]
    fault = "open or inconsistently oriented"
    if len(unpaired) == 0:
        unpaired, fault = edge[(times > 1) & (edge <= reverse)], "touches itself"
    first = int(unpaired[0])
    place = at((vertex[first // count] + vertex[first % count]) / 2)
    return (
        f"{fault} at {place}: "
        "each edge must be shared by exactly two facets, once in each direction"
    )


def volume(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> float:
    """Return the volume that facets enclose [mm³], below 0 where they are oriented inward."""
    middle, total = vertex.mean(axis=0), 0.0
    for part in _parts(facet):
        a, b, c = (vertex[part[:, i]] - middle for i in range(3))
        total += float(np.einsum("ij,ij->", a, np.cross(b, c)))
    return total / 6


def _parts(facet: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Yield the facets some at a time: what is computed of them stays small."""
    for first in range(0, len(facet), _CHUNK):
        yield facet[first : first + _CHUNK]


def _inverted(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> str | None:
    enclosed = volume(vertex, facet)
    if enclosed > 0:
        return None
    return f"volume {enclosed:g} mm³: facets must be oriented outward"


def _contact(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> str | None:
    """Return where a closed mesh crosses or touches itself, or one of its bodies is inverted."""
    if is_height_field(vertex, facet):
        return None
    from mpfcad.optics.solid.crossing_facet import facet_contact
    from mpfcad.optics.solid.crossing_section import extruded_section, section_contact

    section = extruded_section(vertex, facet)
    found = facet_contact(vertex, facet) if section is None else section_contact(section)
    if found is None:
        return None
    what, place = found
    rule = "each body must be oriented outward, a hole in one inward" if what[0] == "a" else _MEET
    return f"{what} at {at(place)}: {rule}"


def is_height_field(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> bool:
    """Return whether closed facets are one height over a flat rectangle, between upright sides.

    Such a mesh cannot meet itself: the underside fills the rectangle once, as no facet of it is
    turned over; so does what looks strictly upward, and each side ends where that begins.
    """
    low, high = vertex.min(axis=0), vertex.max(axis=0)
    base = float(np.prod((high - low)[:2]))
    top = bottom = 0.0
    for part in _parts(facet):
        corner = vertex[part]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        under = (corner[..., 2] == low[2]).all(axis=1)
        rest = ~under
        for axis in (0, 1):
            for plane, sign in ((low[axis], -1), (high[axis], 1)):
                side = (corner[..., axis] == plane).all(axis=1)
                if (sign * normal[side, axis] < 0).any():
                    return False
                rest &= ~side
        up, down = normal[rest, 2], -normal[under, 2]
        if (up <= 0).any() or (down < 0).any() or (corner[rest, :, 2] <= low[2]).any():
            return False
        top, bottom = top + up.sum() / 2, bottom + down.sum() / 2
    return bool(abs(top - base) <= 1e-6 * base and abs(bottom - base) <= 1e-6 * base)
