"""How a particle scatters: a measured or computed phase function, tabulated for drawing cosines.

A row holds the cosines at equal steps of the cumulative probability (the inverse CDF); between them
is drawn linearly. Row -1 stands for Henyey and Greenstein's function, drawn in closed form.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import henyey_greenstein_cosine

#: Steps of the cumulative probability in a row.
STEPS = 2048


def phase_quantiles(
    cosine: NDArray[np.float64], density: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the cosines at equal steps of the cumulative probability, (STEPS+1,) float64.

    `cosine` (m,) float64 ascends from -1 to 1, `density` (m,) float64 is the phase function there,
    in any unit; between the points it is linear.
    """
    part = np.diff(cosine) * (density[1:] + density[:-1]) / 2
    total = np.concatenate(([0.0], np.cumsum(part)))
    return np.interp(np.linspace(0, total[-1], STEPS + 1), total, cosine)


def phase_table(rows: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the rows of a scene, (r, STEPS+1) float64; one that is never drawn from if none."""
    return np.array(rows) if rows else np.zeros((1, STEPS + 1))


@kernel
def scattering_cosine(phase, row, asymmetry, u):
    """Return the cosine of one scattering drawn by u in [0, 1)."""
    if row < 0:
        return henyey_greenstein_cosine(asymmetry, u)
    place = u * (phase.shape[1] - 1)
    i = int(place)
    return phase[row, i] + (place - i) * (phase[row, i + 1] - phase[row, i])
