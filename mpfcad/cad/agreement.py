"""Compare film.step with film.stl, both from disk, without the film they were made of."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.step_text import StepText, read_step_text
from mpfcad.cad.stl_check import read_facets
from mpfcad.errors import ExportError
from mpfcad.units import nm

#: Largest relative difference of the volumes: chords lie above the parabola.
VOLUME_TOLERANCE = 1e-4
#: Distance [mm] allowed besides what float32 coordinates force.
DISTANCE_TOLERANCE = 1 * nm


@dataclass(frozen=True)
class Agreement:
    """How far an STL file is from a STEP file of the same film.

    Attributes
    ----------
    distance_max
        largest distance [mm] of a corner of the STL from the nearest surface of the STEP
    distance_limit
        what it may be [mm], from the float32 coordinates of an STL of this size
    volume_difference
        |volume of the STL / volume of all bodies of the STEP - 1|
    """

    distance_max: float
    distance_limit: float
    volume_difference: float


def check_agreement(step: Path, stl: Path, step_volume: float) -> Agreement:
    """Return how well the two files agree; `step_volume` [mm³] is what OCCT found in the STEP.

    Every corner of the STL is compared with the parabolas and planes that the STEP states.

    Raises
    ------
    ExportError
        when they are not the same film.
    """
    corner, _ = read_facets(Path(stl))
    points = np.unique(corner.reshape(-1, 3), axis=0)
    distance = float(_distance(points, read_step_text(Path(step))).max())
    limit = float(np.spacing(np.float32(points[:, :2].max()))) + DISTANCE_TOLERANCE
    # The same sum as of every closed mesh, about its middle for the sake of rounding.
    a, b, c = np.moveaxis(corner - points.mean(axis=0), 1, 0)
    volume = float(np.sum(a * np.cross(b, c)) / 6)
    difference = abs(volume / step_volume - 1)
    if not (distance <= limit and difference <= VOLUME_TOLERANCE):
        raise ExportError(
            f"{Path(stl).name}: {distance:.3g} mm off {Path(step).name} (limit {limit:.3g} mm),"
            f" volume {difference:.3g} (limit {VOLUME_TOLERANCE:g})"
        )
    return Agreement(distance, limit, difference)


def _distance(points: NDArray[np.float64], step: StepText) -> NDArray[np.float64]:
    """Return each point's distance [mm] from the nearest surface along y, and from the nearer end.

    The larger of both: every corner of an extrusion lies at one of its ends, which alone says
    nothing about its cross-section.
    """
    normal = np.round(step.plane_normal, 9)
    levels = [np.unique(step.plane_point[np.abs(normal[:, i]) == 1, i]) for i in range(3)]
    ends = _to_nearest(points[:, 1], levels[1])
    best = np.minimum(*(_to_nearest(points[:, i], levels[i]) for i in (0, 2)))
    walls = np.abs(normal).max(axis=1) < 1
    if walls.any():
        anchor, direction = step.plane_point[walls], step.plane_normal[walls]
        best = np.minimum(best, _to_walls(points, anchor, direction))
    if len(step.vertex):
        best = np.minimum(best, _to_parabolas(points, step))
    return np.maximum(best, ends)


def _to_nearest(value: NDArray[np.float64], levels: NDArray[np.float64]) -> NDArray[np.float64]:
    if len(levels) == 0:
        return np.full(len(value), np.inf)
    after = np.clip(np.searchsorted(levels, value), 1, max(len(levels) - 1, 1))
    last = np.minimum(after, len(levels) - 1)
    return np.minimum(np.abs(value - levels[after - 1]), np.abs(value - levels[last]))


def _to_walls(
    points: NDArray[np.float64], anchor: NDArray[np.float64], normal: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the distance from the walls that start nearest to each point, to its left and right.

    A wall starts in a valley, where it is anchored, or at a contact point of a fused body.
    """
    best = np.full(len(points), np.inf)
    for rising in (True, False):
        chosen = (normal[:, 0] < 0) == rising
        order = np.argsort(anchor[chosen, 0], kind="stable")
        origin, direction = anchor[chosen][order], normal[chosen][order]
        if len(origin) == 0:
            continue
        after = np.searchsorted(origin[:, 0], points[:, 0])
        for index in (after - 1, after):
            wall = np.clip(index, 0, len(origin) - 1)
            off = np.einsum("ij,ij->i", points - origin[wall], direction[wall])
            best = np.minimum(best, np.abs(off))
    return best


def _to_parabolas(points: NDArray[np.float64], step: StepText) -> NDArray[np.float64]:
    """Return the distance from the parabola that is nearest in x, to first order."""
    _, first = np.unique(step.vertex[:, 0], return_index=True)
    vertex, curvature = step.vertex[first], step.curvature[first]
    after = np.clip(np.searchsorted(vertex[:, 0], points[:, 0]), 1, max(len(vertex) - 1, 1))
    best = np.full(len(points), np.inf)
    for index in (after - 1, np.minimum(after, len(vertex) - 1)):
        x = points[:, 0] - vertex[index, 0]
        rise = points[:, 2] - vertex[index, 2] - curvature[index] / 2 * x**2
        best = np.minimum(best, np.abs(rise) / np.hypot(1, curvature[index] * x))
    return best
