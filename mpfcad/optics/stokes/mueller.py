"""A plane layer known by its measured Mueller matrix in transmission."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.stokes.plane import refer_to_axis
from mpfcad.optics.stokes.state import depolarise, live_rows
from mpfcad.sound import refuse_unsound

#: The columns of such a layer in `Scene.parameter`; 16 for its matrix, row by row.
COSINE, SINE, MATRIX = range(3)
#: How far a measured matrix may be from a possible one, over its first entry.
_NOISE = 1e-6
_PAULI = np.array(
    [[[1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]], [[0, -1j], [1j, 0]]], complex
)


@dataclass(frozen=True, eq=False)
class MuellerLayer:
    """A thin layer that passes light by a matrix and reflects none, alike at all angles.

    Attributes
    ----------
    axis
        angle [rad] from y, anticlockwise seen from above, of the axis to which it refers
    matrix
        (4, 4) float64, of light that goes up; the way down follows by reciprocity
    """

    axis: float
    matrix: NDArray[np.float64]
    name: str = "layer"

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.axis", self.axis)
        refuse_unsound(f"{self.name}.matrix", self.matrix)
        refuse_active(self.name, self.matrix)

    def is_mirrored(self, period: float) -> bool:
        """Tell whether its mirror image does the same: no coupling of U and V with I and Q."""
        cross = np.abs(self.matrix[:2, 2:]).max() + np.abs(self.matrix[2:, :2]).max()
        return abs(math.sin(2.0 * self.axis)) < 1e-12 and cross == 0.0


def refuse_active(name: str, matrix: NDArray[np.float64]) -> None:
    """Refuse a Mueller matrix, (4, 4) float64, that no passive element can have.

    It is a mixture of Jones matrices where H = ¼ Σ mᵢⱼ σᵢ ⊗ σⱼ* has no negative eigenvalue (Cloude,
    "Group theory and polarisation algebra", 1986), and makes no light where m₀₀ + |m₀ₖ| and m₀₀ +
    |mₖ₀| are at most 1 (Gil and Bernabeu, 1985).

    Raises
    ------
    InputError
        saying which of these it breaks.
    """
    coherency = sum(
        matrix[i, j] * np.kron(_PAULI[i], _PAULI[j].conj()) for i in range(4) for j in range(4)
    )
    least = float(np.linalg.eigvalsh(coherency / 4).min())
    if not matrix[0, 0] >= 0 or least < -_NOISE * max(matrix[0, 0], 1e-300):
        raise InputError(
            f"{name}: Mueller matrix: no mixture of Jones matrices (eigenvalue {least:.3g}): "
            "expected none below 0"
        )
    for what, part in (("passes", matrix[0, 1:]), ("passes downward", matrix[1:, 0])):
        most = float(matrix[0, 0] + np.linalg.norm(part))
        if most > 1 + _NOISE:
            raise InputError(
                f"{name}: Mueller matrix: {what} {most:.4g} of some light: expected at most 1"
            )


@kernel
def mueller_passage(parameter, dx, dy, dz, light):
    """Change the state by the layer's matrix M; return the share of the weight that is left.

    A path downward meets light that goes up: its rows are multiplied by Q M Q from the right, Q =
    diag(1, 1, -1, 1), for they refer to the path's own direction; a path upward by Mᵀ.
    """
    refer_to_axis(light, parameter[COSINE], parameter[SINE], dx, dy, dz)
    up = dz > 0.0
    for i in range(live_rows(light)):
        one, q, u, v = light[i, 0], light[i, 1], light[i, 2], light[i, 3]
        for j in range(4):
            total = 0.0
            for k in range(4):
                row = one if k == 0 else q if k == 1 else u if k == 2 else v
                at = 4 * j + k if up else 4 * k + j
                sign = -1.0 if not up and (j == 2) != (k == 2) else 1.0
                total += sign * row * parameter[MATRIX + at]
            light[i, j] = total
    first = light[0, 0]
    if first <= 0.0:
        light[0, 0] = 1.0
        depolarise(light)
        return 0.0
    for i in range(live_rows(light)):
        for j in range(4):
            light[i, j] /= first
    return first
