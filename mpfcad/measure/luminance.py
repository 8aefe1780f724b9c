"""Normal luminance over whole lamp pitches, traced from a mesh on disk."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.contrast import contrast_of_curve, contrasts_of_pitches
from mpfcad.measure.contrast.curve import CurveFit, fit_curve
from mpfcad.measure.contrast.fit import HarmonicFit, fit_harmonics
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.flux import energy_balance
from mpfcad.measure.glow import Glow, can_glow, find_glow
from mpfcad.measure.judged import Judged, judged_pitches
from mpfcad.measure.meter import POINTS, Spot, pitch_positions, refuse_dark
from mpfcad.measure.rounds import (
    LEAST_PATHS,
    Lit,
    TraceRun,
    Trail,
    relative_error,
    trace_rounds,
)

if TYPE_CHECKING:
    from mpfcad.optics.base.recorder import Tally
    from mpfcad.optics.source import Source

#: What ends the trace, as progress shows it.
FIGURE = "contrast ± {:.4f} (95 %)"
#: The contrast's half-width of a smooth curve, over the points' relative error.
_HALF_WIDTH = 0.8
#: From so many times the paths of a first round a table is asked for.
_MANY = 3.0


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
        backward paths that the figures rest on, a table's among them; without those that only tell
        how many are needed
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
        when more than 1e-6 of the light is lost.
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

    reader = _Reader(lit, source, run.seed, part)
    tally = reader.trace(run, half_width_goal)
    curve, contrast = reader.read(tally)
    shape_error, mean_error = reader.shared(tally)
    start = int(np.argmin(np.abs(position)))
    central = slice(start, start + POINTS)
    luminance = tally.radiance[central]
    error = np.sqrt(tally.radiance_error**2 + shape_error**2 + mean_error**2)[central]
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
        curve.mean(number).widened(mean_error),
        tuple(contrasts_of_pitches(curve, run.seed)) if lit.is_finite else (),
        judged,
        lit.spot,
        energy_balance(lit, run.seed, run.threads),
        tally.total_paths + reader.table_paths,
        lit.accelerator,
        np.array(reader.rows),
    )


class _Reader:
    """The trace of a meter's points and what is read off it: curve and contrast."""

    def __init__(self, lit: Lit, source: "Source", seed: int, part: slice) -> None:
        self._lit, self._source, self._seed, self._part = lit, source, seed, part
        self._position = pitch_positions(lit.stack)
        self._glow: Glow | None = None
        self._known: dict[int, tuple[CurveFit, Estimate]] = {}
        self._trail = Trail(lambda tally: _ends(self.read(tally)[1]))

    def trace(self, run: TraceRun, goal: float) -> "Tally":
        """Return the tally of a trace to a half-width of the contrast, the fastest way."""
        # What is known to end before a table is worth it needs no round to tell.
        if run.path_limit <= _MANY * LEAST_PATHS or not can_glow(self._lit):
            return self._round(run, goal)
        first = TraceRun(run.seed, run.threads, LEAST_PATHS, judged=run.judged)
        tally = self._round(first, goal)
        half_width = self.read(tally)[1].half_width
        times = run.path_limit / tally.total_paths
        if goal > 0:
            # Of few paths the half-width tells badly how many are needed.
            expected = min(half_width, _HALF_WIDTH * relative_error(tally))
            times = min(times, (expected / goal) ** 2)
        if times > _MANY:
            self._glow = find_glow(self._lit, self._source, run, tally, times * tally.blocks)
        if self._glow is None:
            return self._round(run, goal, tally)
        self._known.clear()
        most = max(run.path_limit - self._glow.paths, run.path_limit // 2)
        return self._round(replace(run, path_limit=most), goal)

    def _round(self, run: TraceRun, goal: float, begun: "Tally | None" = None) -> "Tally":
        return trace_rounds(
            self._glow.lit if self._glow else self._lit, self._source, run,
            lambda tally: self.read(tally)[1].half_width, goal, FIGURE, trail=self._trail,
            begun=begun,
        )  # fmt: skip

    def read(self, tally: "Tally") -> tuple[CurveFit, Estimate]:
        """Return the curve and its contrast, of the worst judged pitch."""
        position = self._position
        refuse_dark(self._lit.stack.name, position, tally.radiance)
        if tally.blocks not in self._known:
            error = np.hypot(tally.radiance_error, self.shared(tally)[0])
            curve = fit_curve(
                position, tally.radiance, error, tally.blocks,
                periodic=not self._lit.is_finite, blurred=self._lit.is_blurred,
            )  # fmt: skip
            within = replace(curve, window=curve.window[self._part])
            self._known[tally.blocks] = curve, contrast_of_curve(within, self._seed)
        return self._known[tally.blocks]

    def shared(self, tally: "Tally") -> tuple[NDArray[np.float64], float]:
        """Return the errors [cd/m²] of what points share: at each (p,), and of the mean."""
        if self._glow is None:
            return np.zeros(len(tally.score)), 0.0
        return self._glow.errors(tally)

    @property
    def table_paths(self) -> int:
        """Paths that end on no point."""
        return self._glow.paths if self._glow else 0

    @property
    def rows(self) -> list[tuple[float, ...]]:
        """After each round: all paths, contrast and ends of its interval."""
        return [(paths + self.table_paths, *ends) for paths, *ends in self._trail.rows]


def _ends(estimate: Estimate) -> tuple[float, float, float]:
    return estimate.value, estimate.low, estimate.high
