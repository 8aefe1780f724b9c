"""Closes flat holes of a mesh."""

import numpy as np
from numpy.typing import NDArray


def fill_holes(
    vertex: NDArray[np.float64], facet: NDArray[np.int64], flat: float
) -> tuple[NDArray[np.int64], int]:
    """Return a mesh's facets with those that close its flat holes, and how many it had.

    A hole is flat when its corners lie within `flat` [mm] of a plane; others stay open. Holes of
    one plane are closed together: one within another leaves a ring.
    """
    from manifold3d import triangulate

    planes: list[tuple[NDArray, NDArray, list[NDArray]]] = []
    loops = _loops(facet, len(vertex))
    # The outer one of a plane first: it says which way is outward.
    for loop in sorted(loops, key=lambda loop: -np.linalg.norm(_normal(vertex[loop]))):
        for origin, normal, members in planes:
            if np.abs((vertex[loop] - origin) @ normal).max() <= flat:
                members.append(loop)
                break
        else:
            normal, origin = _normal(vertex[loop]), vertex[loop].mean(axis=0)
            size = np.linalg.norm(normal)
            if size and np.abs((vertex[loop] - origin) @ normal).max() <= flat * size:
                planes.append((origin, normal / size, [loop]))
    filled = [facet]
    for origin, normal, members in planes:
        across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        across /= np.linalg.norm(across)
        axes = np.stack([across, np.cross(normal, across)], axis=1)
        outline = [(vertex[loop] - origin) @ axes for loop in members]
        filled.append(np.concatenate(members)[np.asarray(triangulate(outline), np.int64)])
    return np.concatenate(filled), sum(len(members) for _, _, members in planes)


def _normal(point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the doubled area of a closed line as a vector (Newell's formula)."""
    moved = point - point.mean(axis=0)
    return np.cross(moved, np.roll(moved, -1, axis=0)).sum(axis=0)


def _loops(facet: NDArray[np.int64], count: int) -> list[NDArray[np.int64]]:
    """Return the lines of corners around the holes, as the facets that close them would run."""
    start, end = facet.ravel(), np.roll(facet, -1, axis=1).ravel()
    key, back = start * count + end, end * count + start
    alone = ~np.isin(key, back)
    # Where two holes share a corner, which line goes on where is not known.
    after: dict[int, int] = {}
    shared = set()
    for a, b in zip(end[alone].tolist(), start[alone].tolist(), strict=True):
        if a in after:
            shared.add(a)
        after[a] = b
    loops = []
    while after:
        first = corner = next(iter(after))
        loop = []
        while corner in after:
            loop.append(corner)
            corner = after.pop(corner)
        if corner == first and len(loop) > 2 and not shared.intersection(loop):
            loops.append(np.array(loop))
    return loops
