"""A curvature map as a cosine series over the lamp pitch: smooth, and the same on both sides.

C(u) = Σ c_k cos 2πku, u from a lamp's axis in pitches. The map that is made runs straight between
its rows, so constraints that hold at the rows hold everywhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Rows of the map that is written, over one lamp pitch.
ROWS = 131
#: Curvatures are kept this far [1/mm] inside their range, more than rounding takes.
MARGIN = 1e-5


@dataclass(frozen=True)
class Constraint:
    """What a map may be.

    Attributes
    ----------
    curvature_min, curvature_max
        range of C [1/mm]
    change_max
        largest change of C per length [1/mm per mm]
    harmonics
        highest k of the series
    """

    curvature_min: float
    curvature_max: float
    change_max: float
    harmonics: int = 4


def cosine_basis(position: ArrayLike, harmonics: int) -> NDArray[np.float64]:
    """Return cos 2πku at positions u in pitches, (n, harmonics+1) float64."""
    return np.cos(2 * np.pi * np.outer(np.asarray(position, float), np.arange(harmonics + 1)))


def row_position() -> NDArray[np.float64]:
    """Return the rows' positions, (ROWS,) float64 in pitches."""
    return np.linspace(0, 1, ROWS)


def limits(constraint: Constraint, pitch: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (A, b) with A c ≤ b for every series c that keeps the constraints; `pitch` in mm."""
    rows = cosine_basis(row_position()[: ROWS // 2 + 1], constraint.harmonics)
    step = np.diff(rows, axis=0)
    change = constraint.change_max * pitch / (ROWS - 1) - MARGIN
    bound = [
        np.full(len(rows), constraint.curvature_max - MARGIN),
        np.full(len(rows), -constraint.curvature_min - MARGIN),
        np.full(len(step), change),
        np.full(len(step), change),
    ]
    return np.concatenate([rows, -rows, step, -step]), np.concatenate(bound)


def project(
    position: ArrayLike, curvature: ArrayLike, constraint: Constraint, pitch: float
) -> NDArray[np.float64]:
    """Return the series within the constraints that is nearest to C at positions u (largest gap).

    A linear programme: the least t with |Σ c_k cos 2πku - C(u)| ≤ t.
    """
    from scipy.optimize import linprog

    curvature = np.asarray(curvature, float)
    basis = cosine_basis(position, constraint.harmonics)
    matrix, bound = limits(constraint, pitch)
    gap = np.ones((len(curvature), 1))
    free = np.zeros((len(matrix), 1))
    result = linprog(
        np.append(np.zeros(basis.shape[1]), 1.0),
        A_ub=np.block([[basis, -gap], [-basis, -gap], [matrix, free]]),
        b_ub=np.concatenate([curvature, -curvature, bound]),
        bounds=[(None, None)] * basis.shape[1] + [(0, None)],
        method="highs",
    )
    return rounded(result.x[:-1])


def rounded(series: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a series in steps of 1e-7 /mm, which stays within the `MARGIN`."""
    return np.round(series, 7) + 0.0


def series_rows(series: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows of a series' map: positions in pitches and C [1/mm], (ROWS,) float64."""
    position = row_position()
    half = cosine_basis(position[: ROWS // 2 + 1], len(series) - 1) @ series
    return position, np.concatenate([half, half[: ROWS // 2][::-1]])
