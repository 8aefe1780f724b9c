"""Compare film.step with film.stl, both from disk, where curvature varies along the grooves."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.agreement import Agreement, agreement_of, distance_limit, to_walls
from mpfcad.cad.check.mesh_check import join_corners, read_facets
from mpfcad.cad.check.step.text import read_step_text
from mpfcad.errors import ExportError

_PATCH = re.compile(
    rb"B_SPLINE_SURFACE(?:_WITH_KNOTS\('',|\()2,([12]),\(([#\d,()]*)\),\.UNSPECIFIED[^;]*?"
    rb"(?:RATIONAL_B_SPLINE_SURFACE\(\(\(([^)]*)\)[^;]*)?;"
)


@dataclass(frozen=True, eq=False)
class Patches:
    """The patches of a STEP file: `points` (m, 3, 3, 3) [mm], across and along; weights (m, 3)."""

    points: NDArray[np.float64]
    weights: NDArray[np.float64]

    def height_error(self, place: NDArray[np.float64], room: float) -> NDArray[np.float64]:
        """Return |z - the patch's height| [mm] at places (k, 3); inf where none is there.

        Every patch runs evenly in y, and at each y from side to side of its groove's middle;
        `room` [mm] is how far beside one a place may lie.
        """
        centre, groove = np.unique(np.round(self.points[:, 1, 0, 0], 9), return_inverse=True)
        order = np.lexsort([self.points[:, 0, 0, 1], groove])
        points, weights, groove = self.points[order], self.weights[order], groove[order]
        low, high = points[:, 0, 0, 1], points[:, 0, 2, 1]
        size = 2 * high.max() + 1
        edge = (centre[1:] + centre[:-1]) / 2
        own = np.searchsorted(edge, place[:, 0])
        key = own * size + place[:, 1]
        index = np.maximum(np.searchsorted(groove * size + low, key, side="right") - 1, 0)
        patch, weight = points[index], weights[index]
        along = np.clip((place[:, 1] - low[index]) / (high - low)[index], 0, 1)
        share = _bernstein(along) * weight
        share /= share.sum(axis=1, keepdims=True)
        line = np.einsum("kb,kabi->kai", share, patch)
        reach = line[:, 2, 0] - line[:, 1, 0]
        local = place[:, 0] - line[:, 1, 0]
        across = np.divide(local, reach, out=np.zeros_like(local), where=reach > 0)
        height = np.einsum("ka,ka->k", _bernstein((np.clip(across, -1, 1) + 1) / 2), line[..., 2])
        inside = (groove[index] == own) & (place[:, 1] <= high[index] + room)
        inside &= np.abs(local) <= reach + room
        return np.where(inside, np.abs(place[:, 2] - height), np.inf)


def _bernstein(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the three Bernstein polynomials of degree 2, (k, 3)."""
    return np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2], axis=1)


def read_patches(path: Path) -> Patches:
    """Return the patches of degree 2 across and 1 or 2 along in a STEP file.

    Raises
    ------
    ExportError
        when there is none.
    """
    text = path.read_bytes()
    points = dict(re.findall(rb"(#\d+)=CARTESIAN_POINT\('',\(([^)]*)\)\)", text))
    control, weights = [], []
    for degree, rows, row in _PATCH.findall(text):
        places = [
            [float(part) for part in points[key].split(b",")] for key in re.findall(rb"#\d+", rows)
        ]
        patch = np.array(places).reshape(3, int(degree) + 1, 3)
        if degree == b"1":
            patch = np.stack([patch[:, 0], patch.mean(axis=1), patch[:, 1]], axis=1)
        control.append(patch)
        weights.append([float(part) for part in row.split(b",")] if row else [1.0] * 3)
    if not control:
        raise ExportError(f"{path.name}: holds no patches")
    return Patches(np.array(control), np.array(weights))


def check_field_agreement(
    step: Path, stl: Path, step_volume: float, volume_limit: float
) -> Agreement:
    """Return how well the two files agree; `step_volume` [mm³] is what OCCT found in the STEP.

    Every corner of the STL's top has to lie on a patch or a wall that the STEP states.

    Raises
    ------
    ExportError
        when a file cannot be read.
    """
    corner, _ = read_facets(Path(stl))
    place, _ = join_corners(corner)
    found = read_step_text(Path(step))
    walls = (np.abs(found.plane_normal[:, [0, 2]]) > 1e-9).all(axis=1)
    off = read_patches(Path(step)).height_error(place, distance_limit(place))
    if walls.any():
        anchor, normal = (
            part[walls][:, [0, 2]] for part in (found.plane_point, found.plane_normal)
        )
        off = np.minimum(off, to_walls(place[:, [0, 2]], anchor, normal))
    distance = float(np.minimum(off, np.abs(place[:, 2])).max())
    names = Path(step).name, Path(stl).name
    return agreement_of(names, corner, place, distance, step_volume, volume_limit)
