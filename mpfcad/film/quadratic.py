"""A curve through many points as the fewest pieces, straight or parabolic, within a tolerance."""

import numpy as np
from numpy.typing import NDArray

#: Cost of a straight piece, and of a parabola: as few pieces as can be, of those as many straight.
_STRAIGHT, _CURVED = 100, 101


def fewest_pieces(
    point: NDArray[np.float64], tolerance: float, kept: tuple[int, ...] = ()
) -> NDArray[np.float64]:
    """Return the corners of the fewest pieces, (k, 3) float64 [mm, mm, 1/mm].

    Columns: x, z and the curvature d²z/dx² of the piece to the right (0: straight; the last
    corner's is 0). Each piece runs through points of the curve and leaves none of those between
    by more than `tolerance`. The shortest way over all pairs of points (dynamic programming).

    point: (n, 2) float64 [mm], x increasing; tolerance [mm]; `kept` are points that stay corners.
    """
    n = len(point)
    cost = np.full(n, np.iinfo(np.int64).max)
    cost[0] = 0
    before, bend = np.zeros(n, np.int64), np.zeros(n)
    for end in range(1, n):
        first = max(at for at in (0, *kept) if at < end)
        for start in range(end - 1, first - 1, -1):
            found = _bend(point[start : end + 1], tolerance)
            if found is None:
                continue
            total = cost[start] + (_CURVED if found else _STRAIGHT)
            if total < cost[end]:
                cost[end], before[end], bend[end] = total, start, found
    corner = [n - 1]
    while corner[-1]:
        corner.append(int(before[corner[-1]]))
    order = np.array(corner[::-1])
    return np.column_stack([point[order], np.append(bend[order[1:]], 0.0)])


def _bend(point: NDArray[np.float64], tolerance: float) -> float | None:
    """Return the curvature of one piece through both ends that leaves no point: 0, or the best."""
    x, z = point[1:-1].T
    (x0, z0), (x1, z1) = point[0], point[-1]
    off = z - (z0 + (z1 - z0) * (x - x0) / (x1 - x0))
    if not len(off) or np.abs(off).max() <= tolerance:
        return 0.0
    bow = (x - x0) * (x - x1) / 2
    bend = float(bow @ off / (bow @ bow))
    return bend if np.abs(off - bend * bow).max() <= tolerance else None


def bow_area(x: NDArray[np.float64], bend: NDArray[np.float64]) -> float:
    """Return by how much less area [mm²] lies under curved pieces than under their chords.

    x: (k,) float64 [mm], corners; bend: (k-1,) float64 [1/mm] of the pieces between them. ΣCΔx³/12.
    """
    return float(np.sum(bend * np.diff(x) ** 3) / 12)
