"""Normal luminance over the central lamp pitch, traced from a mesh on disk."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.contrast import contrast_of_harmonics
from mpfcad.measure.contrast.fit import HarmonicFit, fit_harmonics
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, trace_rounds

if TYPE_CHECKING:
    from mpfcad.optics.base.recorder import Tally
    from mpfcad.optics.element import Element
    from mpfcad.optics.scene import Scene

#: Points over the pitch: 0 and 1 above lamps, 0.5 between (Hsieh, MPF thesis).
POINTS = 33
#: What ends the trace, as progress shows it.
FIGURE = "contrast ± {:.4f} (95 %)"
_ENERGY_BLOCKS = 256


@dataclass(frozen=True, eq=False)
class LuminanceResult:
    """Luminance over a lamp pitch and what follows from it.

    Attributes
    ----------
    position_pitch
        (33,) float64, in lamp pitches from a lamp's axis
    luminance, standard_error
        (33,) float64 [cd/m²], each point averaged over the meter's spot
    freedom
        degrees of freedom of a point's standard error
    fit
        the Fourier series through them
    contrast, mean_luminance
        lamp-Mura contrast; mean [cd/m²] over the pitch
    energy
        shares of the lamps' light from a forward trace: in = 1, out, absorbed (and by element),
        lost
    paths
        backward paths traced
    accelerator
        how the meshes were traced: one of `tile.ACCELERATORS`, or each way that was taken
    """

    position_pitch: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    freedom: float
    fit: HarmonicFit
    contrast: Estimate
    mean_luminance: Estimate
    energy: dict[str, object]
    paths: int
    accelerator: str


def luminance_over_pitch(
    lit: Lit, run: TraceRun | None = None, *, half_width_goal: float = 0.002
) -> LuminanceResult:
    """Return the luminance over one lamp pitch of a film in its stack.

    Traces rounds of paths until the 95 % half-width of the contrast reaches `half_width_goal` or
    the run's path limit is reached. The result does not depend on the number of threads.

    Raises
    ------
    TraceError
        when more than 1e-6 of the paths are lost.
    """
    from mpfcad.optics.source import EYE, Source

    run = run or TraceRun()
    stack = lit.stack
    position = np.linspace(0, 1, POINTS)
    source = Source(
        EYE, position * stack.period.across, stack["meter_spot_mm"], acceptance=stack.acceptance
    )

    def read(tally: "Tally") -> tuple[HarmonicFit, Estimate]:
        fit = fit_harmonics(position, tally.radiance, tally.radiance_error, tally.blocks)
        return fit, contrast_of_harmonics(fit, run.seed)

    tally = trace_rounds(
        lit, source, run, lambda tally: read(tally)[1].half_width, half_width_goal, FIGURE
    )
    fit, contrast = read(tally)
    return LuminanceResult(
        position,
        tally.radiance,
        tally.radiance_error,
        tally.radiance_freedom,
        fit,
        contrast,
        fit.mean,
        _energy(lit.scene, lit.elements, run.seed, run.threads),
        tally.total_paths,
        lit.accelerator,
    )


def _energy(
    scene: "Scene", elements: "list[Element]", seed: int, threads: int
) -> dict[str, object]:
    """Return where the lamps' light goes, from a forward trace, as shares of what they emit."""
    from mpfcad.optics.base.recorder import FLOWS
    from mpfcad.optics.engine import trace
    from mpfcad.optics.source import LAMPS, Source

    tally = trace(
        scene, Source(LAMPS, np.zeros(1), 0.0), _ENERGY_BLOCKS, seed=seed, threads=threads
    )
    share = dict(zip(FLOWS, map(float, tally.fraction), strict=False))
    error = dict(zip(FLOWS, map(float, tally.fraction_error), strict=False))
    absorbed = {"lamps": share["lamps"]}
    absorbed.update({name: share[name] for name in ("walls", "rim") if share[name] > 0})
    for element, part in zip(elements, tally.fraction[len(FLOWS) :], strict=True):
        if part > 0:
            absorbed[element.name] = absorbed.get(element.name, 0.0) + float(part)
    total = sum(absorbed.values())
    return {
        "in": 1.0,
        "out": share["up"],
        "absorbed": total,
        "absorbed_by": absorbed,
        "lost": share["lost"],
        "imbalance": 1.0 - share["up"] - share["down"] - total - share["lost"],
        "imbalance_standard_error": error["roulette"],
        "paths": tally.total_paths,
    }
