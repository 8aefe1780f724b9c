"""Normal luminance over a cell of LEDs, traced from the LEDs or from the meter."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.cell.enough import refuse_fine, refuse_rare
from mpfcad.measure.cell.estimator import Choice, Estimator
from mpfcad.measure.cell.pilot import choose
from mpfcad.measure.cell.series import CellSeries, fit_series
from mpfcad.measure.cell.tracer import LEAST_BLOCKS, CellTracer, can_connect
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.flux import energy_balance, energy_shares
from mpfcad.measure.rounds import Lit, TraceRun

if TYPE_CHECKING:
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.engine import CellTally

#: Bins of the map along each axis.
BINS = 24
#: What ends the trace, as progress shows it.
FIGURE = "contrast ± {:.4f} (95 %)"
#: Blocks of a trace that is one of many: enough for the size of its noise.
_FEW_BLOCKS = 8


@dataclass(frozen=True, eq=False)
class CellResult:
    """Luminance over a cell and what follows from it.

    Attributes
    ----------
    size
        of the cell [mm] along x and y
    series
        the Fourier series
    contrast, mean_luminance
        lamp-Mura contrast over the cell; mean [cd/m²]
    luminance, standard_error
        (BINS, BINS) float64 [cd/m²], the map: rows along x, columns along y, LED in the middle
    energy
        shares of the LEDs' light: in = 1, out, absorbed (and by element), lost
    paths
        traced from the LEDs or from the meter
    accelerator
        how the meshes were traced
    is_mirrored
        whether sines were left out, for the cell is its own mirror image
    choice
        which way it was traced, and why
    paths_to_goal
        paths that the goal of the contrast takes, by error ∝ 1/√paths, where the trace ended
        before; else None
    """

    size: tuple[float, float]
    series: CellSeries
    contrast: Estimate
    mean_luminance: Estimate
    luminance: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    energy: dict[str, Any]
    paths: int
    accelerator: str
    is_mirrored: bool
    choice: Choice
    paths_to_goal: int | None = None


def luminance_over_cell(
    lit: Lit, run: TraceRun | None = None, *, half_width_goal: float = 0.002
) -> CellResult:
    """Return the luminance over one cell of a film, or none, in a stack of LEDs.

    Traces rounds of paths until the 95 % half-width of the contrast reaches `half_width_goal` or
    the run's path limit is reached. The result does not depend on the number of threads.

    Raises
    ------
    InputError
        when paths from the meter find too little light, the light changes within less than the
        series follows, or the LEDs are to be traced to a sheet on top and there is none.
    TraceError
        when more than 1e-6 of the light is lost.
    """
    from mpfcad.optics.forward.connection import CellMeter

    run = run or TraceRun()
    period = lit.stack.period
    meter = CellMeter(lit.stack.acceptance, period.across, period.along, BINS)
    choice = choose(lit, meter, run)
    tracer, mirrored = CellTracer(lit, meter, choice.estimator), _is_mirrored(lit)
    read: dict[int, tuple[CellSeries, Estimate]] = {}

    def half_width(tally: "CellTally") -> float:
        if not refuse_rare(tracer, tally, run.path_limit, half_width_goal):
            return 1.0  # of a contrast: nothing is known
        series = _series(tracer, tally, mirrored)
        read[tally.blocks] = series, series.contrast(run.seed)
        return read[tally.blocks][1].half_width

    tally = tracer.rounds(run, half_width, half_width_goal, FIGURE)
    series, contrast = read[tally.blocks]
    value, error = tracer.map(tally)
    if not can_connect(lit):  # under a sheet that scatters, what is so fine is the grooves' own
        refuse_fine(lit.stack.name, series, value, error, contrast.half_width)
    return CellResult(
        (period.across, period.along), series, contrast, series.mean, value, error,
        _energy(tracer, run, tally), tally.paths, lit.accelerator, mirrored, choice,
        _paths_to_goal(tally.paths, contrast.half_width, half_width_goal),
    )  # fmt: skip


def compile_cell_tracer(lit: Lit) -> None:
    """Compile what `luminance_over_cell` traces with, once for all scenes, if it is not there."""
    from mpfcad.optics.forward.connection import CellMeter

    meter = CellMeter(lit.stack.acceptance, *lit.stack.period, BINS)
    ways = [Estimator.forward] if can_connect(lit) else []
    for way in (*ways, Estimator.backward):
        CellTracer(lit, meter, way).blocks(TraceRun(), range(1))


def trace_terms(
    lit: Lit, order: NDArray[np.int64], paths: float, seed: int, threads: int,
    estimator: Estimator,
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:  # fmt: skip
    """Return terms (n, 2) of a cell's series (`CellSeries.order`) from about so many paths.

    Coefficients (n,) [cd/m²], their covariance (n, n), and the paths that were traced. `estimator`
    is that of the cell's own trace (`CellResult.choice`).
    """
    from mpfcad.optics.forward.connection import TERMS, CellMeter
    from mpfcad.optics.forward.engine import BLOCK

    meter = CellMeter(lit.stack.acceptance, *lit.stack.period, BINS)
    blocks = max(_FEW_BLOCKS, round(paths / BLOCK))
    tracer = CellTracer(lit, meter, estimator)
    tally = tracer.blocks(TraceRun(seed=seed, threads=threads), range(blocks))
    coefficient, covariance = tracer.terms(tally)
    chosen = order @ (TERMS, 1)
    return coefficient[chosen], covariance[np.ix_(chosen, chosen)], tally.paths


def _series(tracer: CellTracer, tally: "CellTally", mirrored: bool) -> CellSeries:
    from mpfcad.optics.forward.connection import TERMS

    return fit_series(*tracer.terms(tally), tally.blocks, TERMS, mirrored)


def _is_mirrored(lit: Lit) -> bool:
    """Return whether LEDs and all above them are their own mirror images at x = 0 and y = 0."""
    period = min(lit.stack.period)
    if not all(element.is_mirrored(period) for element in lit.elements):
        return False
    return bool(getattr(lit.stack.source, "is_mirrored", False))


def _paths_to_goal(paths: int, half_width: float, goal: float) -> int | None:
    if goal <= 0 or half_width <= goal:
        return None
    return round(paths * (half_width / goal) ** 2)


def _energy(tracer: CellTracer, run: TraceRun, tally: "CellTally") -> dict[str, Any]:
    """Return where the LEDs' light goes, as shares of what they emit."""
    from mpfcad.optics.base.recorder import FLOWS

    if tracer.estimator is Estimator.backward:
        return energy_balance(tracer.lit, run.seed, run.threads)
    tally = _balance(tracer.lit, tracer.meter, run, tally)
    mean = tally.flow / tally.blocks
    error = np.sqrt(np.maximum(0.0, tally.flow2 / tally.blocks - mean**2) / (tally.blocks - 1))
    error *= tally.blocks / tally.paths
    roulette = float(error[FLOWS.index("roulette")])
    return energy_shares(tracer.lit, tally.flow / tally.paths, roulette, tally.paths)


def _balance(lit: Lit, meter: "CellMeter", run: TraceRun, tally: "CellTally") -> "CellTally":
    """Return the tally whose flows are light: in bands one of the stack's one wavelength."""
    from mpfcad.optics.forward.engine import trace_forward

    if lit.spectral is None:
        return tally
    return trace_forward(lit.scene, meter, LEAST_BLOCKS, seed=run.seed, threads=run.threads)
