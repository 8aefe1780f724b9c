"""The flux that leaves the stack and its share of what the lamps emit, traced both ways."""

from dataclasses import dataclass

import numpy as np

from mpfcad.measure.contrast import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, trace_rounds

_FORWARD = "efficiency ± {:.5f} of itself"
_BACKWARD = "exitance ± {:.5f} of itself"


@dataclass(frozen=True)
class FluxResult:
    """Light out of the screen over all directions.

    Attributes
    ----------
    efficiency
        flux out over flux that the lamps' surfaces emit, traced from the lamps
    exitance, exitance_backward
        [lm/m²] of the screen: efficiency times the lamps' emission over the screen's area; and from
        the luminances seen over the whole hemisphere, traced backward
    flux
        [lm] of the panel, without losses at its rim
    paths
        both ways
    """

    efficiency: Estimate
    exitance: Estimate
    exitance_backward: Estimate
    flux: Estimate
    paths: int

    @property
    def disagreement(self) -> float:
        """Forward minus backward exitance in standard errors of the difference."""
        forward, backward = self.exitance, self.exitance_backward
        error = np.hypot(forward.standard_error, backward.standard_error)
        return float((forward.value - backward.value) / error)


def output_flux(lit: Lit, run: TraceRun, error_goal: float) -> FluxResult:
    """Return flux and efficiency of a film in its stack, each to a relative standard error."""
    from mpfcad.optics.engine import EYE, LAMPS, Source
    from mpfcad.optics.recorder import FLOWS

    up = FLOWS.index("up")
    forward = trace_rounds(
        lit,
        Source(LAMPS, np.zeros(1), 0.0),
        run,
        lambda tally: float(tally.fraction_error[up] / tally.fraction[up]),
        error_goal,
        _FORWARD,
    )
    efficiency = Estimate.normal(float(forward.fraction[up]), float(forward.fraction_error[up]))
    # A meter of acceptance sine 1: kx, ky uniform over the unit disk, as Lambertian light arrives.
    pitch = lit.stack.lamp_pitch
    backward = trace_rounds(
        lit,
        Source(EYE, np.array([pitch / 2]), pitch, acceptance=1.0),
        run,
        lambda tally: float(tally.radiance_error[0] / tally.radiance[0]),
        error_goal,
        _BACKWARD,
    )
    emission = lamp_emission(lit)
    area = lit.stack.lamp_count * pitch * lit.stack.panel_length * 1e-6
    return FluxResult(
        efficiency,
        scaled(efficiency, emission),
        Estimate.normal(
            float(np.pi * backward.radiance[0]), float(np.pi * backward.radiance_error[0])
        ),
        scaled(efficiency, emission * area),
        forward.total_paths + backward.total_paths,
    )


def lamp_emission(lit: Lit) -> float:
    """Return the flux the lamps emit over the area they light, π L · 2π r / pitch [lm/m²]."""
    stack = lit.stack
    tube = 2 * np.pi * stack["lamp_radius_mm"] / stack.lamp_pitch
    return float(np.pi * stack["lamp_luminance_cd_m2"] * tube)


def scaled(estimate: Estimate, factor: float) -> Estimate:
    """Return an estimate times a positive number."""
    return Estimate(*(factor * v for v in vars(estimate).values()))
