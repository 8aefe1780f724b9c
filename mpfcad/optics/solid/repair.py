"""Makes a solid of facets that bound none, where what is meant is plain; nothing is guessed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.solid.closed import find_fault, volume
from mpfcad.optics.solid.crossing_facet import joined, nesting
from mpfcad.optics.solid.crossing_section import extruded_section
from mpfcad.optics.solid.hole import fill_holes
from mpfcad.optics.solid.union import unite_bodies, unite_section

#: Corners on open edges no farther apart than this are one [mm].
NEAR = 1e-4


class Repair(NamedTuple):
    """A mesh after its repair, and what was changed.

    Attributes
    ----------
    vertex, facet
        (v, 3) float64 [mm], all of them float32 numbers; (n, 3) int64
    merged_corners, dropped_facets, turned_facets, filled_holes
        how many; a hole is an open edge all around
    united_bodies
        how many there were before overlaps were united; 0 where none were
    volume_change
        by the union [mm³]
    """

    vertex: NDArray[np.float64]
    facet: NDArray[np.int64]
    merged_corners: int = 0
    dropped_facets: int = 0
    turned_facets: int = 0
    filled_holes: int = 0
    united_bodies: int = 0
    volume_change: float = 0.0


def repair_solid(vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> Repair:
    """Return a mesh with what can be repaired repaired; the rest is for `find_fault` to name."""
    was = len(facet)
    facet = _single(facet)
    vertex, facet, merged = _merge_near(vertex, facet)
    facet = _single(facet)
    dropped = was - len(facet)
    facet, turned = _turn_alike(facet)
    facet, filled = fill_holes(vertex, facet, NEAR)
    facet, inverted = _turn_outward(vertex, facet)
    turned = np.r_[turned, np.zeros(len(facet) - len(turned), bool)] ^ inverted
    done = Repair(vertex, facet, merged, dropped, int(turned[: was - dropped].sum()), filled)
    fault = find_fault(vertex, facet)
    if fault is None or fault.startswith("open"):
        return done
    section = extruded_section(vertex, facet)
    part = _parts(facet)
    united = unite_bodies(vertex, facet, part) if section is None else unite_section(
        section, float(vertex[:, 1].max())
    )  # fmt: skip
    if united is None:
        return done
    change = volume(*united) - volume(vertex, facet)
    bodies = len(np.unique(part))
    return done._replace(
        vertex=united[0], facet=united[1], united_bodies=bodies, volume_change=change
    )


def describe_repair(repair: Repair) -> str:
    """Return in words what was changed."""
    names = ("merged_corners", "dropped_facets", "turned_facets", "filled_holes")
    counts = {name.replace("_", " "): getattr(repair, name) for name in names}
    parts = [f"{name} {count}" for name, count in counts.items() if count]
    if repair.united_bodies:
        change = f"{repair.volume_change:.3g} mm³"
        parts.append(f"united bodies {repair.united_bodies}, volume changed by {change}")
    return ", ".join(parts)


def _single(facet: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return facets without those that have two equal corners, each once.

    Two that run against each other are left out where they close nothing, as a flap.
    """
    facet = facet[(facet != np.roll(facet, 1, axis=1)).all(axis=1)]
    first = facet.argmin(axis=1)
    rolled = np.take_along_axis(facet, (first[:, None] + np.arange(3)) % 3, axis=1)
    sense = np.where(rolled[:, 1] < rolled[:, 2], 1, -1)
    _, number = np.unique(np.sort(facet, axis=1), axis=0, return_inverse=True)
    number = number.ravel()
    net = np.bincount(number, sense)
    # The first facet of each kind that has the sense of the most.
    right = np.flatnonzero(sense * net[number] >= 0)
    _, place = np.unique(number[right], return_index=True)
    chosen = np.sort(right[place])
    _, _, owner, edge = _edges(facet[chosen])
    beside = np.bincount(edge)[edge]
    tight = np.bincount(owner, beside > 2, len(chosen)) > 0
    closing = ~tight & (np.bincount(owner, beside == 2, len(chosen)) > 0)
    return facet[chosen[(net[number[chosen]] != 0) | closing]]


def _edges(facet: NDArray[np.int64]) -> tuple[NDArray[np.int64], ...]:
    """Return start, end and facet of every edge, those of one edge side by side, and its number."""
    start, end = facet.ravel(), np.roll(facet, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    new = np.r_[True, (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0)]
    return start[order], end[order], order // 3, np.cumsum(new) - 1


def _merge_near(
    vertex: NDArray[np.float64], facet: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], int]:
    """Return a mesh in which corners of open edges that lie within `NEAR` are one."""
    from scipy.spatial import cKDTree

    start, end, _, number = _edges(facet)
    single = np.bincount(number)[number] == 1
    rim = np.unique(np.r_[start[single], end[single]])
    pairs = cKDTree(vertex[rim]).query_pairs(NEAR, output_type="ndarray") if len(rim) else None
    if pairs is None or len(pairs) == 0:
        return vertex, facet, 0
    _, group = joined(pairs.T, len(rim))
    _, first = np.unique(group, return_index=True)
    target = np.arange(len(vertex))
    target[rim] = rim[first[group]]
    return vertex, target[facet], int((target != np.arange(len(vertex))).sum())


def _neighbours(facet: NDArray[np.int64]) -> tuple[NDArray, NDArray, NDArray]:
    """Return the pairs of facets at edges of two, and whether they run alike there."""
    start, _, owner, number = _edges(facet)
    two = np.flatnonzero(np.bincount(number)[number] == 2)
    one, other = two[::2], two[1::2]
    return owner[one], owner[other], start[one] == start[other]


def _turn_alike(facet: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return facets that run against each other along their edges, and which were turned over.

    Each facet is two nodes, as it is and turned over; neighbours join the states that fit.
    """
    one, other, alike = _neighbours(facet)
    n = len(facet)
    links = np.stack([np.r_[one, one + n], np.r_[other + n * alike, other + n * ~alike]])
    _, part = joined(links, 2 * n)
    # Of a pair of mirrored parts the one that leaves more facets as they are.
    left = np.bincount(part[:n], minlength=part.max() + 1)
    turned = (left[part[n:]] > left[part[:n]]) | (
        (left[part[n:]] == left[part[:n]]) & (part[n:] < part[:n])
    )
    return np.where(turned[:, None], facet[:, ::-1], facet), turned


def _parts(facet: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return the part of each facet: what hangs together by edges of two facets."""
    one, other, _ = _neighbours(facet)
    return joined(np.stack([one, other]), len(facet))[1]


def _turn_outward(
    vertex: NDArray[np.float64], facet: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return facets of which every part outside all others looks outward, and which were turned.

    What lies within another part stays as it is to the outer one: a hole, or one more body.
    """
    part = _parts(facet)
    inside_out = np.full(len(facet), volume(vertex, facet) < 0)
    _, enclosed, _, odd = nesting(vertex, facet, part)
    wrong = ((enclosed < 0) != inside_out[0]) & ~odd
    turned = inside_out ^ wrong[np.unique(part, return_inverse=True)[1]]
    return np.where(turned[:, None], facet[:, ::-1], facet), turned
