"""Which way a cell of LEDs is traced: a short trace of both tells which needs less work.

Work is counted, not timed: how many times an element is passed, or a ray from the LEDs is joined
with the meter. So the same inputs choose the same on every machine.
"""

from typing import TYPE_CHECKING

import numpy as np

from mpfcad.measure.cell.estimator import Choice, Estimator
from mpfcad.measure.cell.series import LEAST
from mpfcad.measure.cell.tracer import CellTracer, can_connect, refuse_sheetless, topmost
from mpfcad.measure.rounds import Lit, TraceRun

if TYPE_CHECKING:
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.engine import CellTally

#: Blocks of each way. They are numbered as none of the trace that follows.
_PILOT = range(1 << 30, (1 << 30) + 16)
#: So many paths from the meter have to find light, or their scatter is not known.
_LEAST_LIT = 400


def choose(lit: Lit, meter: "CellMeter", run: TraceRun) -> Choice:
    """Return which way a cell is traced: as asked for, as it can be, or with less work.

    Raises
    ------
    InputError
        when paths from the LEDs are asked for, and the topmost layer is no sheet that scatters.
    """
    if run.estimator is Estimator.forward:
        refuse_sheetless(lit)
    if run.estimator is not Estimator.auto:
        return Choice(run.estimator, "asked for")
    if not can_connect(lit):
        reason = f"the topmost layer, {topmost(lit)}, is no sheet that scatters"
        return Choice(Estimator.backward, reason)
    return _less_work(lit, meter, run)


def _less_work(lit: Lit, meter: "CellMeter", run: TraceRun) -> Choice:
    forward, backward = (
        CellTracer(lit, meter, way) for way in (Estimator.forward, Estimator.backward)
    )
    tallies = forward.blocks(run, _PILOT), backward.blocks(run, _PILOT)
    found = tallies[1].lit
    if found < _LEAST_LIT:
        return Choice(
            Estimator.forward, f"{found} of {tallies[1].paths} paths from the meter find light"
        )
    mean = forward.terms(tallies[0])[0][0]
    work = {
        tracer.estimator: _work(tracer, tally, mean)
        for tracer, tally in zip((forward, backward), tallies, strict=True)
    }
    best, other = sorted(work, key=lambda way: work[way])
    reason = f"{other.value} takes {work[other] / work[best]:.3g} times the work"
    return Choice(best, reason, tuple(work.items()))


def _work(tracer: CellTracer, tally: "CellTally", mean: float) -> float:
    """Return the work until the low harmonics have together a variance of the mean's square."""
    from mpfcad.optics.forward.connection import TERMS

    _, covariance = tracer.terms(tally)
    harmonic = (np.stack(np.divmod(np.arange(TERMS * TERMS), TERMS)) + 1) // 2
    low = harmonic.any(axis=0) & (harmonic <= LEAST).all(axis=0)
    variance = float(np.diag(covariance)[low].sum()) / mean**2
    return variance * tally.passed
