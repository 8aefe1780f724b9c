"""Normal luminance over a cell of LEDs, traced from the LEDs and connected at the top sheet."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.cell.series import CellSeries, fit_series
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, in_rounds

if TYPE_CHECKING:
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.engine import CellTally

#: Bins of the map along each axis.
BINS = 24
#: What ends the trace, as progress shows it.
FIGURE = "contrast ± {:.4f} (95 %)"
_LEAST_BLOCKS = 64


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
        traced from the LEDs
    accelerator
        how the meshes were traced
    is_mirrored
        whether sines were left out, for the cell is its own mirror image
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


def luminance_over_cell(
    lit: Lit, run: TraceRun | None = None, *, half_width_goal: float = 0.002
) -> CellResult:
    """Return the luminance over one cell of a film, or none, in a stack of LEDs.

    Traces rounds of paths until the 95 % half-width of the contrast reaches `half_width_goal` or
    the run's path limit is reached. The result does not depend on the number of threads.

    Raises
    ------
    InputError
        when the topmost layer is no sheet that scatters.
    TraceError
        when more than 1e-6 of the light is lost.
    """
    from mpfcad.optics.forward.connection import CellMeter

    run = run or TraceRun()
    refuse_sheetless(lit)
    period = lit.stack.period
    meter = CellMeter(lit.stack.acceptance, period.across, period.along, BINS)
    mirrored = _is_mirrored(lit)

    def half_width(tally: "CellTally") -> float:
        series = _series(lit, meter, tally, mirrored)
        found.append((series, series.contrast(run.seed)))
        return found[-1][1].half_width

    found: list[tuple[CellSeries, Estimate]] = []
    tally = cell_rounds(lit, meter, run, half_width, half_width_goal, FIGURE)
    series, contrast = found[-1]
    value, error = cell_map(lit, meter, tally)
    return CellResult(
        (period.across, period.along), series, contrast, series.mean, value, error,
        _energy(lit, _balance(lit, meter, run, tally)), tally.paths, lit.accelerator, mirrored,
    )  # fmt: skip


def can_connect(lit: Lit) -> bool:
    """Return whether paths from the LEDs can be joined with the meter at the topmost sheet."""
    from mpfcad.optics.forward import engine

    return engine.can_connect(lit.scene)


def refuse_sheetless(lit: Lit) -> None:
    """Raise unless paths from the LEDs can be joined with the meter.

    Raises
    ------
    InputError
        when the topmost layer is no sheet that scatters.
    """
    if not can_connect(lit):
        raise InputError(
            f"{lit.stack.name}: layers: {lit.stack.layers[-1]}: LEDs are traced to a scattering "
            "sheet on top: expected a sheet with sigma above 0 as the last layer"
        )


def compile_cell_tracer(lit: Lit) -> None:
    """Compile what `luminance_over_cell` traces with, once for all scenes, if it is not there."""
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.engine import trace_forward

    meter = CellMeter(lit.stack.acceptance, *lit.stack.period, BINS)
    trace_forward(lit.scene, meter, 1, spectral=lit.spectral)


def cell_rounds(
    lit: Lit,
    meter: "CellMeter",
    run: TraceRun,
    error_of: "Callable[[CellTally], float]",
    goal: float,
    figure: str,
) -> "CellTally":
    """Return the tally of enough rounds that `error_of` it is at most `goal`, or the path limit.

    Raises
    ------
    TraceError
        when more than 1e-6 of the light is lost, and no gate judges it.
    """
    from mpfcad.optics.engine import flow_count
    from mpfcad.optics.forward.engine import BLOCK, CellTally, trace_forward

    def add(tally: "CellTally", blocks: range, after: Callable[[], None] | None) -> "CellTally":
        part = trace_forward(
            lit.scene, meter, len(blocks), seed=run.seed, first=blocks.start, threads=run.threads,
            after_block=after, spectral=lit.spectral,
        )  # fmt: skip
        return tally.plus(part)

    return in_rounds(
        lit, run, {"meter": meter},
        CellTally.empty(meter, flow_count(lit.scene, 0)), add, error_of, goal, figure,
        block=BLOCK, more=lambda done: max(_LEAST_BLOCKS, done // 4),
    )  # fmt: skip


def cell_scale(lit: Lit, meter: "CellMeter") -> float:
    """Return what turns a path's mean score into a luminance [cd/m²]: flux over area, in mm²."""
    element: Any = lit.elements[0]
    return float(element.flux / (meter.across * meter.along) * 1e6)


def trace_terms(
    lit: Lit, order: NDArray[np.int64], paths: float, seed: int, threads: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return terms (n, 2) of a cell's series (`CellSeries.order`) from about so many paths.

    Coefficients (n,) [cd/m²], their covariance (n, n), and the paths that were traced.
    """
    from mpfcad.optics.forward.connection import TERMS, CellMeter
    from mpfcad.optics.forward.engine import BLOCK, trace_forward

    meter = CellMeter(lit.stack.acceptance, *lit.stack.period, BINS)
    blocks = max(_LEAST_BLOCKS, round(paths / BLOCK))
    tally = trace_forward(
        lit.scene, meter, blocks, seed=seed, threads=threads, spectral=lit.spectral
    )
    coefficient, covariance = _terms(lit, meter, tally)
    chosen = order @ (TERMS, 1)
    return coefficient[chosen], covariance[np.ix_(chosen, chosen)], tally.paths


def _series(lit: Lit, meter: "CellMeter", tally: "CellTally", mirrored: bool) -> CellSeries:
    from mpfcad.optics.forward.connection import TERMS

    return fit_series(*_terms(lit, meter, tally), tally.blocks, TERMS, mirrored)


def _terms(
    lit: Lit, meter: "CellMeter", tally: "CellTally"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return all coefficients (TERMS²,) [cd/m²] and their covariance."""
    from mpfcad.optics.forward.connection import TERMS
    from mpfcad.optics.forward.engine import BLOCK

    blocks, n = tally.blocks, TERMS * TERMS
    mean = tally.score[:n] / blocks
    covariance = (tally.outer / blocks - np.outer(mean, mean)) / (blocks - 1)
    # A term's mean square is ½ an axis where it is no constant.
    axis = np.where(np.arange(TERMS) > 0, 2.0, 1.0)
    factor = cell_scale(lit, meter) / BLOCK * np.outer(axis, axis).ravel()
    return factor * mean, covariance * np.outer(factor, factor)


def cell_map(
    lit: Lit, meter: "CellMeter", tally: "CellTally"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the luminance of the meter's bins and its standard error, (b, b) float64 [cd/m²]."""
    from mpfcad.optics.forward.connection import TERMS
    from mpfcad.optics.forward.engine import BLOCK

    blocks, bins = tally.blocks, meter.bins
    factor = cell_scale(lit, meter) * bins * bins / BLOCK
    mean = tally.score[TERMS * TERMS :] / blocks
    variance = np.maximum(0.0, tally.square / blocks - mean**2) / (blocks - 1)
    return factor * mean.reshape(bins, bins), factor * np.sqrt(variance).reshape(bins, bins)


def _is_mirrored(lit: Lit) -> bool:
    """Return whether LEDs and all above them are their own mirror images at x = 0 and y = 0."""
    period = min(lit.stack.period)
    if not all(element.is_mirrored(period) for element in lit.elements):
        return False
    return bool(getattr(lit.stack.source, "is_mirrored", False))


def _balance(lit: Lit, meter: "CellMeter", run: TraceRun, tally: "CellTally") -> "CellTally":
    """Return the tally whose flows are light: in bands one of the stack's one wavelength."""
    from mpfcad.optics.forward.engine import trace_forward

    if lit.spectral is None:
        return tally
    return trace_forward(lit.scene, meter, _LEAST_BLOCKS, seed=run.seed, threads=run.threads)


def _energy(lit: Lit, tally: "CellTally") -> dict[str, Any]:
    """Return where the LEDs' light goes, as shares of what they emit."""
    from mpfcad.optics.base.recorder import FLOWS

    share = tally.flow / tally.paths
    mean = tally.flow / tally.blocks
    error = np.sqrt(np.maximum(0.0, tally.flow2 / tally.blocks - mean**2) / (tally.blocks - 1))
    error *= tally.blocks / tally.paths
    absorbed = {"lamps": float(share[FLOWS.index("lamps")])}
    for element, part in zip(lit.elements, share[len(FLOWS) :], strict=True):
        if part > 0:
            absorbed[element.name] = absorbed.get(element.name, 0.0) + float(part)
    total = sum(absorbed.values())
    up, down, lost = (float(share[FLOWS.index(name)]) for name in ("up", "down", "lost"))
    return {
        "in": 1.0,
        "out": up,
        "absorbed": total,
        "absorbed_by": absorbed,
        "lost": lost,
        "imbalance": 1.0 - up - down - total - lost,
        "imbalance_standard_error": float(error[FLOWS.index("roulette")]),
        "paths": tally.paths,
    }
