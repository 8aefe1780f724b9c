"""Compare film.step with film.stl, both from disk, without the film they were made of."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import read_facets
from mpfcad.cad.check.step.text import StepText, read_step_text
from mpfcad.gate import Gate
from mpfcad.units import nm, um

#: Largest relative difference of the volumes: chords lie above the parabola.
VOLUME_LIMIT = 1e-4
#: Distance [mm] allowed besides what float32 coordinates force.
DISTANCE_TOLERANCE = 1 * nm


@dataclass(frozen=True)
class Agreement:
    """How far an STL file is from a STEP file of the same film.

    Attributes
    ----------
    distance_max
        largest distance [mm] of a corner of the STL from the nearest surface of the STEP
    volume_difference
        |volume of the STL / volume of all bodies of the STEP - 1|
    gates
        both against their limits; that of the distance follows from the float32 coordinates of an
        STL of this size
    """

    distance_max: float
    volume_difference: float
    gates: tuple[Gate, ...]


def check_agreement(
    step: Path, stl: Path, step_volume: float, volume_limit: float = VOLUME_LIMIT
) -> Agreement:
    """Return how well the two files agree; `step_volume` [mm³] is what OCCT found in the STEP.

    Every corner of the STL is compared with the planes, parabolas, circles and patches that the
    STEP states. `volume_limit` is the largest relative difference of the volumes.

    Raises
    ------
    ExportError
        when a file cannot be read.
    """
    corner, _ = read_facets(Path(stl))
    points = np.unique(corner.reshape(-1, 3), axis=0)
    distance = float(_distance(points, read_step_text(Path(step))).max())
    names = Path(step).name, Path(stl).name
    return agreement_of(names, corner, points, distance, step_volume, volume_limit)


def distance_limit(points: NDArray[np.float64]) -> float:
    """Return how far [mm] corners of an STL of this size may be from the STEP."""
    return float(np.spacing(np.float32(points[:, :2].max()))) + DISTANCE_TOLERANCE


def agreement_of(
    names: tuple[str, str],
    corner: NDArray[np.float64],
    points: NDArray[np.float64],
    distance: float,
    step_volume: float,
    volume_limit: float,
) -> Agreement:
    """Return the agreement of files (STEP, STL) of these names.

    corner: (t, 3, 3) float64 [mm], facets of the STL; points: (v, 3) their distinct corners, the
    farthest of which is `distance` [mm] off.
    """
    # The same sum as of every closed mesh, about its middle for the sake of rounding.
    a, b, c = np.moveaxis(corner - points.mean(axis=0), 1, 0)
    volume = float(np.sum(a * np.cross(b, c)) / 6)
    difference = abs(volume / step_volume - 1)
    detail = f"{names[1]}: off {names[0]}"
    limit = distance_limit(points)
    gates = (
        Gate("step_mesh_distance_um", distance / um, limit / um, detail=detail),
        Gate("step_mesh_volume_difference", difference, volume_limit, detail=detail),
    )
    return Agreement(distance, difference, gates)


def _distance(points: NDArray[np.float64], step: StepText) -> NDArray[np.float64]:
    """Return each point's distance [mm] from the nearest surface, and from the nearest end.

    The larger of both, for an extrusion: each of its corners lies at one of its two ends, which
    alone says nothing about its cross-section.
    """
    normal = np.round(step.plane_normal, 9)
    levels = [np.unique(step.plane_point[np.abs(normal[:, i]) == 1, i]) for i in range(3)]
    flat = [_to_nearest(points[:, i], levels[i]) for i in range(3)]
    drawn = [_to_drawn(points, step, axis) for axis in (0, 1)]
    if np.isfinite(drawn[1]).any() or len(step.patch):
        return np.minimum.reduce([*flat, *drawn, _to_patches(points, step.patch)])
    return np.maximum(np.minimum.reduce([flat[0], flat[2], drawn[0]]), flat[1])


def _to_drawn(points: NDArray[np.float64], step: StepText, axis: int) -> NDArray[np.float64]:
    """Return the distance from the nearest surface whose profile runs along `axis` (0: x, 1: y)."""
    best = np.full(len(points), np.inf)
    place = points[:, [axis, 2]]
    walls = (np.abs(step.plane_normal[:, axis]) > 1e-9) & (
        np.abs(step.plane_normal[:, 1 - axis]) < 1e-9
    )
    walls &= np.abs(step.plane_normal).max(axis=1) < 1 - 1e-9
    if walls.any():
        anchor, normal = (
            part[walls][:, [axis, 2]] for part in (step.plane_point, step.plane_normal)
        )
        best = np.minimum(best, to_walls(place, anchor, normal))
    along = np.abs(step.normal[:, 1 - axis]) > 1 - 1e-9
    for up in (True, False):
        chosen = along & ((step.curvature > 0) == up)
        if chosen.any():
            vertex, start = step.vertex[chosen][:, [axis, 2]], step.low[chosen, axis]
            off = _to_parabolas(place, vertex, start, step.curvature[chosen])
            best = np.minimum(best, off)
    if axis == 0 and len(step.radius):
        best = np.minimum(best, _to_circles(place, step.centre[:, [0, 2]], step.radius))
    return best


def _to_nearest(value: NDArray[np.float64], levels: NDArray[np.float64]) -> NDArray[np.float64]:
    if len(levels) == 0:
        return np.full(len(value), np.inf)
    before, after = _neighbours(levels, value)
    return np.minimum(np.abs(value - levels[before]), np.abs(value - levels[after]))


def _neighbours(
    place: NDArray[np.float64], value: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the last of the sorted places before each value, and the first after it."""
    after = np.searchsorted(place, value)
    last = len(place) - 1
    return np.clip(after - 1, 0, last), np.minimum(after, last)


def to_walls(
    points: NDArray[np.float64], anchor: NDArray[np.float64], normal: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the distance from the walls that start nearest to each point, to its left and right.

    A wall starts in a valley, where it is anchored, or at a contact point of a fused body.
    """
    best = np.full(len(points), np.inf)
    for rising in (True, False):
        chosen = (normal[:, 0] < 0) == rising
        if not chosen.any():
            continue
        _, first = np.unique(np.round(anchor[chosen, 0], 9), return_index=True)
        origin, direction = anchor[chosen][first], normal[chosen][first]
        for wall in _neighbours(origin[:, 0], points[:, 0]):
            off = np.einsum("ij,ij->i", points - origin[wall], direction[wall])
            best = np.minimum(best, np.abs(off))
    return best


def _to_parabolas(
    points: NDArray[np.float64],
    vertex: NDArray[np.float64],
    start: NDArray[np.float64],
    curvature: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the distance from the parabolas drawn from a start near each point, to first order."""
    _, first = np.unique(np.round(start, 9), return_index=True)
    start, vertex, curvature = start[first], vertex[first], curvature[first]
    best = np.full(len(points), np.inf)
    for index in _neighbours(start, points[:, 0]):
        x = points[:, 0] - vertex[index, 0]
        rise = points[:, 1] - vertex[index, 1] - curvature[index] / 2 * x**2
        best = np.minimum(best, np.abs(rise) / np.hypot(1, curvature[index] * x))
    return best


def _to_circles(
    points: NDArray[np.float64], centre: NDArray[np.float64], radius: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the distance from the circles that are nearest in x."""
    order = np.argsort(centre[:, 0], kind="stable")
    centre, radius = centre[order], radius[order]
    best = np.full(len(points), np.inf)
    for index in _neighbours(centre[:, 0], points[:, 0]):
        off = np.linalg.norm(points - centre[index], axis=1) - radius[index]
        best = np.minimum(best, np.abs(off))
    return best


def _to_patches(points: NDArray[np.float64], patch: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the height [mm] over or below the patch that a point lies in, seen from above.

    Patches stand in rows and columns, their control points at equal distances: x and y run evenly
    with the patch's two parameters.
    """
    if len(patch) == 0:
        return np.full(len(points), np.inf)
    low = patch[:, 0, 0]
    start = [np.unique(low[:, axis]) for axis in (0, 1)]
    cell = [_neighbours(start[axis], points[:, axis])[0] for axis in (0, 1)]
    number = np.full([len(line) for line in start], -1)
    number[tuple(np.searchsorted(start[axis], low[:, axis]) for axis in (0, 1))] = np.arange(
        len(patch)
    )
    own = patch[number[cell[0], cell[1]]]
    span = own[:, 2, 2, :2] - own[:, 0, 0, :2]
    u = (points[:, :2] - own[:, 0, 0, :2]) / span
    weight = np.stack([(1 - u) ** 2, 2 * u * (1 - u), u**2], axis=-1)
    height = np.einsum("ni,nj,nij->n", weight[:, 0], weight[:, 1], own[..., 2])
    return np.abs(points[:, 2] - height)
