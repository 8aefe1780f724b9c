"""A coarse look at all viewing directions in one short trace: for the report of every run.

`angular_luminance` and `conoscope` measure the same to a goal, with finer steps.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.angle.direction import trace_directions
from mpfcad.measure.rounds import Lit, TraceRun

#: Rings and spokes of the map [rad].
POLAR = np.radians(np.arange(0, 81, 10))
AZIMUTH = np.radians(np.arange(0, 360, 22.5))
#: Polar angles of the cuts [rad]; every other one is the map's.
CUT = np.radians(np.arange(-80, 81, 5))
#: A trace of eight blocks: about 2 % of what the contrast of the standard effort takes.
PATHS_A_DIRECTION = 8 * 512


@dataclass(frozen=True, eq=False)
class Survey:
    """Luminance over direction, averaged over a lamp pitch.

    Attributes
    ----------
    luminance, standard_error
        (9, 16) float64 [cd/m²] over `POLAR` and `AZIMUTH`, 0 across the lamps; the normal stands
        once for all azimuths
    across, along
        (33, 2) float64 [cd/m²], luminance and its standard error over `CUT`
    freedom
        degrees of freedom of a standard error
    paths
        backward paths traced
    """

    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    across: NDArray[np.float64]
    along: NDArray[np.float64]
    freedom: float
    paths: int


def survey_directions(lit: Lit, run: TraceRun) -> Survey | None:
    """Return the luminance over direction; None where `run.path_limit` is below the survey's paths.

    Not of LEDs: along them one row of places is not the mean of all.
    """
    polar, azimuth = _directions()
    if lit.is_cell or run.path_limit < len(polar) * PATHS_A_DIRECTION:
        return None
    tally = trace_directions(lit, run, polar, azimuth, np.inf)
    found = np.stack([tally.radiance, tally.own_error], axis=1)
    rings, spokes = len(POLAR) - 1, len(AZIMUTH)
    on_map = found[1 : 1 + rings * spokes].reshape(rings, spokes, 2)
    on_map = np.concatenate([np.broadcast_to(found[0], (1, spokes, 2)), on_map])
    between = found[1 + rings * spokes :].reshape(4, -1, 2)
    cuts = [
        _cut(on_map[:, side], on_map[:, side + spokes // 2], between[turn], between[turn + 2])
        for turn, side in ((0, 0), (1, spokes // 4))
    ]
    return Survey(
        on_map[..., 0], on_map[..., 1], cuts[0], cuts[1], tally.blocks - 1.0, tally.total_paths
    )


def _directions() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the normal, the map's directions, and on four half planes those between its rings."""
    rings, between = POLAR[1:], (POLAR[1:] + POLAR[:-1]) / 2
    polar = [np.zeros(1), np.repeat(rings, len(AZIMUTH)), np.tile(between, 4)]
    quarter = np.arange(4) * np.pi / 2
    azimuth = [np.zeros(1), np.tile(AZIMUTH, len(rings)), np.repeat(quarter, len(between))]
    return np.concatenate(polar), np.concatenate(azimuth)


def _cut(
    right: NDArray[np.float64],
    left: NDArray[np.float64],
    right_between: NDArray[np.float64],
    left_between: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return one plane's values from -80° to 80°: rings and what lies between them in turn."""

    def half(rings: NDArray[np.float64], between: NDArray[np.float64]) -> NDArray[np.float64]:
        joined = np.empty((len(rings) + len(between), 2))
        joined[::2], joined[1::2] = rings, between
        return joined

    return np.concatenate([half(left, left_between)[:0:-1], half(right, right_between)])
