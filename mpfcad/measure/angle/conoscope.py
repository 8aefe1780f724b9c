"""The conoscopic map: luminance over all viewing directions, averaged over a lamp pitch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.angle.direction import trace_directions
from mpfcad.measure.estimate import Estimate, estimate_sum
from mpfcad.measure.rounds import Lit, TraceRun

_STEP = np.radians(5)
#: Rings of the map [rad]: 0 … 80° are shown, 85° is there for the integral.
POLAR = np.arange(18) * _STEP
AZIMUTH = np.radians(np.arange(0, 360, 15))


@dataclass(frozen=True, eq=False)
class ConoscopeResult:
    """Luminance over direction.

    Attributes
    ----------
    polar, azimuth
        (18,), (24,) float64 [rad]; azimuth 0 is across the lamps, 90° along them
    luminance, standard_error
        (18, 24) float64 [cd/m²]; the normal stands once for all azimuths
    exitance
        [lm/m²], ∫ L cos θ dΩ over the hemisphere
    paths
        backward paths traced
    """

    polar: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    exitance: Estimate
    paths: int


def conoscope(lit: Lit, run: TraceRun, error_goal: float) -> ConoscopeResult:
    """Return the conoscopic map of a film in its stack.

    `error_goal`: standard error of a point over the largest luminance, root mean square.
    """
    rings, spokes = len(POLAR) - 1, len(AZIMUTH)
    polar = np.concatenate([[0.0], np.repeat(POLAR[1:], spokes)])
    azimuth = np.concatenate([[0.0], np.tile(AZIMUTH, rings)])
    tally = trace_directions(lit, run, polar, azimuth, error_goal)

    def on_map(values: NDArray) -> NDArray:
        return np.vstack([np.full(spokes, values[0]), values[1:].reshape(rings, spokes)])

    luminance, error = on_map(tally.radiance), on_map(tally.own_error)
    # The normal has weight 0.
    weight = np.concatenate([[0.0], np.repeat(exitance_weight()[1:], spokes)])
    exitance = estimate_sum(weight, tally.radiance, tally.own_error, tally.blocks, own=True)
    return ConoscopeResult(POLAR, AZIMUTH, luminance, error, exitance, tally.total_paths)


def exitance_weight() -> NDArray[np.float64]:
    """Return the weights of the rings' points in ∫ L cos θ dΩ, (18,) float64 [sr].

    Simpson's rule over θ = 0, 5 … 90°, where L cos θ sin θ is 0 at both ends, and the mean over
    the azimuths. For L = 1 it gives π within 2e-5.
    """
    simpson = np.where(np.arange(len(POLAR)) % 2, 4.0, 2.0) * _STEP / 3
    return simpson * np.cos(POLAR) * np.sin(POLAR) * 2 * np.pi / len(AZIMUTH)
