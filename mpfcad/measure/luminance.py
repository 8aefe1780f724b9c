"""Normal luminance over whole lamp pitches, traced from a mesh on disk."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.contrast import contrast_of_curve, contrasts_of_pitches
from mpfcad.measure.contrast.curve import CurveFit, fit_curve
from mpfcad.measure.contrast.fit import HarmonicFit, fit_harmonics
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.judged import Judged, judged_pitches
from mpfcad.measure.meter import POINTS, Spot, pitch_positions, refuse_dark
from mpfcad.measure.rounds import Lit, TraceRun, Trail, trace_rounds

if TYPE_CHECKING:
    from mpfcad.optics.base.recorder import Tally

#: What ends the trace, as progress shows it.
FIGURE = "contrast ± {:.4f} (95 %)"
_ENERGY_BLOCKS = 256


@dataclass(frozen=True, eq=False)
class LuminanceResult:
    """Luminance over the middle's lamp pitch and what follows from it.

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
    curve
        what is read: the curve over this pitch, or on a finite panel over all of them
    central
        number of this pitch among the curve's
    contrast, mean_luminance
        lamp-Mura contrast, of the worst judged pitch of a finite panel; mean [cd/m²] over this
        pitch
    pitches
        the contrast of each pitch of a finite panel; empty without end
    judged
        which of them are judged; None without end
    spot
        of the meter
    energy
        shares of the lamps' light from a forward trace: in = 1, out, absorbed (and by element),
        lost
    paths
        backward paths traced
    accelerator
        how the meshes were traced: one of `tile.ACCELERATORS`, or each way that was taken
    convergence
        (r, 4) float64, after each round: paths, contrast and the ends of its 95 % interval
    """

    position_pitch: NDArray[np.float64]
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    freedom: float
    fit: HarmonicFit
    curve: CurveFit
    central: int
    contrast: Estimate
    mean_luminance: Estimate
    pitches: tuple[Estimate, ...]
    judged: Judged | None
    spot: Spot
    energy: dict[str, object]
    paths: int
    accelerator: str
    convergence: NDArray[np.float64]

    @property
    def worst(self) -> int | None:
        """Number of the judged pitch of most contrast; None without end."""
        if self.judged is None:
            return None
        judged = range(self.judged.first, self.judged.stop)
        return max(judged, key=lambda i: self.pitches[i].value)

    @property
    def where(self) -> str:
        """Where on a finite panel the contrast was found, in words; empty without end."""
        if self.judged is None or self.worst is None:
            return ""
        return self.judged.words(self.worst)

    @property
    def central_curve(self) -> NDArray[np.float64]:
        """The curve at the 33 points of the middle's pitch, (33,) float64 [cd/m²]."""
        readings = self.curve.curve[self.curve.window[self.central]]
        return readings[:: (len(readings) - 1) // (POINTS - 1)]


def luminance_over_pitch(
    lit: Lit, run: TraceRun | None = None, *, half_width_goal: float = 0.002
) -> LuminanceResult:
    """Return the luminance over one lamp pitch of a film in its stack, and its contrast.

    On a finite panel every pitch from the first lamp to the last is measured, and the contrast is
    that of the worst within the rim. Traces rounds of paths until the 95 % half-width of the
    contrast reaches `half_width_goal` or the run's path limit is reached. The result does not
    depend on the number of threads.

    Raises
    ------
    InputError
        when a pitch of a finite panel has no light, or none lies within the rim.
    TraceError
        when more than 1e-6 of the paths are lost.
    """
    from mpfcad.optics.source import EYE, Source

    run = run or TraceRun()
    stack = lit.stack
    position = pitch_positions(stack)
    judged = judged_pitches(stack, position)
    part = slice(None) if judged is None else slice(judged.first, judged.stop)
    source = Source(
        EYE, position * stack.period.across, lit.spot.width, acceptance=stack.acceptance
    )

    def read(tally: "Tally") -> tuple[CurveFit, Estimate]:
        refuse_dark(stack.name, position, tally.radiance)
        found = tally.radiance, tally.radiance_error, tally.blocks
        if tally.blocks not in known:
            curve = fit_curve(position, *found, periodic=not lit.is_finite, blurred=blurred)
            within = replace(curve, window=curve.window[part])
            known[tally.blocks] = curve, contrast_of_curve(within, run.seed)
        return known[tally.blocks]

    known: dict[int, tuple[CurveFit, Estimate]] = {}
    blurred = lit.is_blurred
    trail = Trail(lambda tally: _ends(read(tally)[1]))
    tally = trace_rounds(
        lit, source, run, lambda tally: read(tally)[1].half_width, half_width_goal, FIGURE,
        trail=trail,
    )  # fmt: skip
    curve, contrast = read(tally)
    start = int(np.argmin(np.abs(position)))
    central = slice(start, start + POINTS)
    luminance, error = tally.radiance[central], tally.radiance_error[central]
    number = start // (POINTS - 1)
    return LuminanceResult(
        position[central],
        luminance,
        error,
        tally.radiance_freedom,
        fit_harmonics(position[central], luminance, error, tally.blocks),
        curve,
        number,
        contrast,
        curve.mean(number),
        tuple(contrasts_of_pitches(curve, run.seed)) if lit.is_finite else (),
        judged,
        lit.spot,
        _energy(lit, run.seed, run.threads),
        tally.total_paths,
        lit.accelerator,
        np.array(trail.rows),
    )


def _ends(estimate: Estimate) -> tuple[float, float, float]:
    return estimate.value, estimate.low, estimate.high


def _energy(lit: Lit, seed: int, threads: int) -> dict[str, object]:
    """Return where the lamps' light goes, from a forward trace, as shares of what they emit.

    In bands it is the light of the stack's one wavelength.
    """
    from mpfcad.optics.base.recorder import FLOWS
    from mpfcad.optics.engine import trace
    from mpfcad.optics.source import LAMPS, Source

    tally = trace(
        lit.scene, Source(LAMPS, np.zeros(1), 0.0), _ENERGY_BLOCKS, seed=seed, threads=threads
    )
    share = dict(zip(FLOWS, map(float, tally.fraction), strict=False))
    error = dict(zip(FLOWS, map(float, tally.fraction_error), strict=False))
    absorbed = {"lamps": share["lamps"]}
    absorbed.update({name: share[name] for name in ("walls", "rim") if share[name] > 0})
    for element, part in zip(lit.elements, tally.fraction[len(FLOWS) :], strict=True):
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
