"""A cell of LEDs traced one way or the other: blocks, rounds, and what they score in cd/m²."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.cell.estimator import Estimator
from mpfcad.measure.rounds import Lit, TraceRun, in_rounds

if TYPE_CHECKING:
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.engine import CellTally

#: Blocks of a first round at least.
LEAST_BLOCKS = 64


@dataclass(frozen=True, eq=False)
class CellTracer:
    """One way to trace a cell.

    Attributes
    ----------
    lit
        film and stack
    meter
        what looks at the cell
    estimator
        `forward` or `backward`
    """

    lit: Lit
    meter: "CellMeter"
    estimator: Estimator

    @property
    def unit(self) -> float:
        """Luminance [cd/m²] of a mean score of 1 a path."""
        is_luminance = self.estimator is Estimator.backward
        return 1.0 if is_luminance else cell_scale(self.lit, self.meter)

    def blocks(
        self, run: TraceRun, blocks: range, after: Callable[[], None] | None = None
    ) -> "CellTally":
        """Return the tally of numbered blocks of paths."""
        from mpfcad.optics.forward.chance import trace_chance
        from mpfcad.optics.forward.engine import trace_forward

        trace = trace_chance if self.estimator is Estimator.backward else trace_forward
        return trace(
            self.lit.scene, self.meter, len(blocks), seed=run.seed, first=blocks.start,
            threads=run.threads, after_block=after, spectral=self.lit.spectral,
        )  # fmt: skip

    def rounds(
        self, run: TraceRun, error_of: "Callable[[CellTally], float]", goal: float, figure: str
    ) -> "CellTally":
        """Return the tally of enough rounds that `error_of` it is at most `goal`, or the limit.

        Raises
        ------
        TraceError
            when more than 1e-6 of the light is lost, and no gate judges it.
        """
        from mpfcad.optics.engine import flow_count
        from mpfcad.optics.forward.engine import BLOCK, CellTally

        def add(tally: "CellTally", blocks: range, after: Callable[[], None] | None) -> "CellTally":
            return tally.plus(self.blocks(run, blocks, after))

        by = {} if self.estimator is Estimator.forward else {"estimator": self.estimator.value}
        shown = f"{figure}, from the meter" if by else figure
        return in_rounds(
            self.lit, run, {"meter": self.meter, **by},
            CellTally.empty(self.meter, flow_count(self.lit.scene, 0)), add, error_of, goal, shown,
            block=BLOCK, more=lambda done: max(LEAST_BLOCKS, done // 4),
        )  # fmt: skip

    def terms(self, tally: "CellTally") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return all coefficients (TERMS²,) [cd/m²] and their covariance."""
        from mpfcad.optics.forward.connection import TERMS
        from mpfcad.optics.forward.engine import BLOCK

        blocks, n = tally.blocks, TERMS * TERMS
        mean = tally.score[:n] / blocks
        covariance = (tally.outer / blocks - np.outer(mean, mean)) / (blocks - 1)
        # A term's mean square is ½ an axis where it is no constant.
        axis = np.where(np.arange(TERMS) > 0, 2.0, 1.0)
        factor = self.unit / BLOCK * np.outer(axis, axis).ravel()
        return factor * mean, covariance * np.outer(factor, factor)

    def map(self, tally: "CellTally") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the luminance of the bins and its standard error, (b, b) float64 [cd/m²]."""
        from mpfcad.optics.forward.connection import TERMS
        from mpfcad.optics.forward.engine import BLOCK

        blocks, bins = tally.blocks, self.meter.bins
        factor = self.unit * bins * bins / BLOCK
        mean = tally.score[TERMS * TERMS :] / blocks
        variance = np.maximum(0.0, tally.square / blocks - mean**2) / (blocks - 1)
        return factor * mean.reshape(bins, bins), factor * np.sqrt(variance).reshape(bins, bins)


def cell_scale(lit: Lit, meter: "CellMeter") -> float:
    """Return what turns the mean score of a path from the LEDs into a luminance [cd/m²].

    It is their flux over the cell's area, in mm².
    """
    element: Any = lit.elements[0]
    return float(element.flux / (meter.across * meter.along) * 1e6)


def topmost(lit: Lit) -> str:
    """Return the name of the topmost layer."""
    return (lit.stack.layers or ("none",))[-1]


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
            f"{lit.stack.name}: layers: {topmost(lit)}: LEDs are traced to a scattering "
            "sheet on top: expected a sheet with sigma above 0 as the last layer"
        )
