"""The flux that leaves the stack, its share of what the lamps emit, and where the rest goes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, trace_rounds
from mpfcad.measure.uniformity import middle

_FORWARD = "efficiency ± {:.5f} of itself"
_BACKWARD = "exitance ± {:.5f} of itself"
_ENERGY_BLOCKS = 256


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
        [lm] of the panel; with losses at its rim where the panel is finite
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
    from mpfcad.optics.base.recorder import FLOWS
    from mpfcad.optics.source import EYE, LAMPS, Source

    up = FLOWS.index("up")
    forward = trace_rounds(
        lit,
        Source(LAMPS, np.zeros(1), 0.0),
        run,
        lambda tally: float(tally.fraction_error[up] / tally.fraction[up]),
        error_goal,
        _FORWARD,
    )
    efficiency = Estimate.student(
        float(forward.fraction[up]), float(forward.fraction_error[up]), forward.fraction_freedom
    )
    # A meter of acceptance sine 1: kx, ky uniform over the unit disk, as Lambertian light arrives.
    stack = lit.stack
    place = (np.array([stack.period.across / 2]), stack.period.across)
    if lit.is_finite:
        place = (np.array([middle(lit)]), stack.panel_width)
    backward = trace_rounds(
        lit,
        Source(
            EYE, *place, acceptance=1.0, spot_along=stack.panel_length if lit.is_finite else 0.0
        ),
        run,
        lambda tally: float(tally.radiance_error[0] / tally.radiance[0]),
        error_goal,
        _BACKWARD,
    )
    emitted, area = stack.source.flux, stack.source.lit_area
    return FluxResult(
        efficiency,
        scaled(efficiency, emitted / area),
        Estimate.student(
            float(np.pi * backward.radiance[0]),
            float(np.pi * backward.radiance_error[0]),
            backward.radiance_freedom,
        ),
        scaled(efficiency, emitted),
        forward.total_paths + backward.total_paths,
    )


def scaled(estimate: Estimate, factor: float) -> Estimate:
    """Return an estimate times a positive number."""
    return Estimate(*(factor * v for v in vars(estimate).values()))


def energy_balance(lit: Lit, seed: int, threads: int) -> dict[str, Any]:
    """Return where the light goes, from a trace from the lamps or LEDs (`energy_shares`).

    In bands it is the light of the stack's one wavelength.
    """
    from mpfcad.optics.base.recorder import FLOWS
    from mpfcad.optics.engine import trace
    from mpfcad.optics.source import LAMPS, Source

    source = Source(LAMPS, np.zeros(1), 0.0)
    tally = trace(lit.scene, source, _ENERGY_BLOCKS, seed=seed, threads=threads)
    error = float(tally.fraction_error[FLOWS.index("roulette")])
    return energy_shares(lit, tally.fraction, error, tally.total_paths)


def energy_shares(lit: Lit, share: NDArray[np.float64], error: float, paths: int) -> dict[str, Any]:
    """Return where the light goes, in words, as shares of what lamps or LEDs emit.

    `share` (f,) float64 is as of `recorder.Tally.fraction`; `error` the standard error of the
    balance, that of the roulette's share.
    """
    from mpfcad.optics.base.recorder import FLOWS

    ends = dict(zip(FLOWS, map(float, share), strict=False))
    absorbed = {"lamps": ends["lamps"]}
    absorbed.update({name: ends[name] for name in ("walls", "rim") if ends[name] > 0})
    for element, part in zip(lit.elements, share[len(FLOWS) :], strict=True):
        if part > 0:
            absorbed[element.name] = absorbed.get(element.name, 0.0) + float(part)
    total = sum(absorbed.values())
    return {
        "in": 1.0,
        "out": ends["up"],
        "absorbed": total,
        "absorbed_by": absorbed,
        "lost": ends["lost"],
        "imbalance": 1.0 - ends["up"] - ends["down"] - total - ends["lost"],
        "imbalance_standard_error": error,
        "paths": paths,
    }
