"""How long to trace, in three words."""

import os
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mpfcad.measure import Lit, TraceRun

#: A half-width that no trace reaches: it goes on to its path limit.
NO_GOAL = -1.0


@dataclass(frozen=True)
class TraceSetting:
    """When a trace ends: at `half_width_goal` of the contrast (95 %), or at `path_limit` paths.

    The limit is that of one lamp pitch: a finite panel has it for each that is measured.
    """

    half_width_goal: float
    path_limit: int

    def document(self) -> dict[str, Any]:
        """Return the setting as it stands in verification.json."""
        return asdict(self)


def available_threads() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def over_pitches(run: "TraceRun", lit: "Lit") -> "TraceRun":
    """Return how to trace luminance over all pitches of a panel: each has the limit of one."""
    from mpfcad.measure.meter import pitch_count

    return replace(run, path_limit=run.path_limit * pitch_count(lit.stack))


TRACE_SETTINGS = {
    "quick": TraceSetting(half_width_goal=0.004, path_limit=4_000_000),
    "standard": TraceSetting(half_width_goal=0.002, path_limit=40_000_000),
    "final": TraceSetting(half_width_goal=0.0007, path_limit=400_000_000),
}


@dataclass(frozen=True)
class MeasureSetting:
    """Standard errors at which the measures besides contrast end.

    Attributes
    ----------
    direction, conoscope
        of a direction's luminance over the largest, root mean square
    flux
        of efficiency and exitance, relative
    screen
        of a screen point's luminance over the mean
    pixel
        of a pixel of the camera image over the mean
    cell
        of a cell of the panel's map over the mean
    polarisation
        of Q/I
    colour
        of u' and v' of a point, root mean square
    """

    direction: float
    conoscope: float
    flux: float
    screen: float
    pixel: float
    cell: float
    polarisation: float
    colour: float


MEASURE_SETTINGS = {
    "quick": MeasureSetting(0.010, 0.03, 0.003, 0.005, 0.015, 0.04, 0.001, 0.001),
    "standard": MeasureSetting(0.005, 0.01, 0.001, 0.002, 0.006, 0.015, 0.0003, 0.0003),
    "final": MeasureSetting(0.002, 0.004, 0.0005, 0.0007, 0.003, 0.005, 0.0001, 0.0001),
}
