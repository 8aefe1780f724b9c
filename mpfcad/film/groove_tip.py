"""Tips rounded by a circle inside the material that touches the surfaces on both sides."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Newton steps; the circle is found to the last digits in five.
STEPS = 30


@dataclass(frozen=True, eq=False)
class Flank:
    """A surface beside a tip: it lies slope·u - curvature/2·u² below the tip at distance u."""

    slope: NDArray[np.float64]
    curvature: NDArray[np.float64]

    def take(self, index: NDArray[np.int64]) -> "Flank":
        """Return the flanks with these indices."""
        return Flank(self.slope[index], self.curvature[index])


def round_tips(
    left: Flank, right: Flank, radius: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where the circle of `radius` [mm] touches, and its centre.

    The first array, (n, 2), is the distance [mm] across of the touching points left and right of
    the tip; the second, (n, 2), the centre (x, z) from the tip. Both touching points send their
    normal of length `radius` to the same centre: two equations, solved by Newton's method.
    """
    # As if both flanks were straight: the angles of the two slopes meet in the circle.
    angle = (np.arctan(left.slope), np.arctan(right.slope))
    tangent = radius * np.tan((angle[0] + angle[1]) / 2)
    reach = np.stack([tangent * np.cos(angle[0]), tangent * np.cos(angle[1])], axis=1)
    for _ in range(STEPS):
        (xa, za, dxa, dza), (xb, zb, dxb, dzb) = (
            _centre(flank, reach[:, side], radius, sign)
            for side, (flank, sign) in enumerate(((left, -1.0), (right, 1.0)))
        )
        gap_x, gap_z = xa - xb, za - zb
        determinant = -dxa * dzb + dxb * dza
        step = (
            np.stack([(-gap_x * dzb + gap_z * dxb), (dxa * gap_z - dza * gap_x)], axis=1)
            / np.where(np.abs(determinant) > 1e-300, determinant, 1.0)[:, None]
        )
        reach = np.maximum(reach - step, 0.0)
        if np.abs(step).max() < 1e-15:
            break
    xa, za, _, _ = _centre(left, reach[:, 0], radius, -1.0)
    return reach, np.stack([xa, za], axis=1)


def _centre(
    flank: Flank, reach: NDArray[np.float64], radius: float, sign: float
) -> tuple[NDArray[np.float64], ...]:
    """Return the centre (x, z) of the circle that touches at `reach`, and its derivatives."""
    slope = flank.slope - flank.curvature * reach
    size = np.hypot(1.0, slope)
    x = sign * (reach - radius * slope / size)
    z = -(flank.slope * reach - flank.curvature / 2 * reach**2) - radius / size
    turn = -flank.curvature / size**3
    return x, z, sign * (1 - radius * turn), -slope + radius * slope * turn
