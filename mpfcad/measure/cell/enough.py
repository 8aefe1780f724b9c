"""Whether a trace of a cell of LEDs can be read: light found often enough, nothing finer than that.

A figure that would look right and be wrong is refused.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.cell.estimator import Estimator
from mpfcad.measure.cell.series import CellSeries
from mpfcad.measure.cell.tracer import CellTracer

if TYPE_CHECKING:
    from mpfcad.optics.forward.engine import CellTally

#: So many paths from the meter have to find light: of fewer the noise is not normal.
LEAST_LIT = 2000
#: The map may differ from the series by so many σ of noise.
_SIGMA = 5.0


def refuse_rare(tracer: CellTracer, tally: "CellTally", limit: int, goal: float) -> bool:
    """Return whether a tally can be read: paths from the LEDs always find light.

    Raises
    ------
    InputError
        when paths from the meter find so little that they are too few at the path limit, too.
    """
    if tracer.estimator is Estimator.forward or tally.lit >= LEAST_LIT:
        return True
    most = tally.lit + 3 * math.sqrt(tally.lit) + 3
    if most / tally.paths * max(limit, tally.paths + 1) >= LEAST_LIT:
        return False
    share = max(tally.lit, 3) / tally.paths
    # A contrast's half-width is about 2 √(2/n) of n paths that find light.
    words = f", ± {goal:g} about {8 / (share * goal**2):.0e}" if goal > 0 else ""
    raise InputError(
        f"{tracer.lit.stack.name}: {tally.lit} of {tally.paths / 1e6:.2g} million paths from the "
        f"meter find an LED: a contrast takes {LEAST_LIT} that do, {LEAST_LIT / share:.0e} paths"
        f"{words}: expected larger LEDs, or a scattering sheet on top"
    )


def refuse_fine(
    name: str, series: CellSeries, luminance: NDArray[np.float64], error: NDArray[np.float64],
    half_width: float,
) -> None:  # fmt: skip
    """Raise where the map (b, b) shows what is too fine for the series: LEDs seen as they are.

    The bins' squares beyond the series, less their noise, have the variance 2 Σ V². Bins of few
    grooves hold more of one groove's bright part than others do, which is as fine and no LED: of
    a film over a 4 mm cell 0.008 of the mean. So it is for stacks without a scattering top.

    Raises
    ------
    InputError
        when that is more than noise, and more than the contrast's half-width.
    """
    bins, variance = len(luminance), error**2
    rest = (luminance - series.bin_means(bins)) ** 2
    kept = 1 - len(series.coefficient) / bins**2
    beyond = float(rest.sum() - kept * variance.sum())
    noise = math.sqrt(2 * float(np.sum(variance**2)))
    if beyond <= _SIGMA * noise:
        return
    share = math.sqrt(beyond) / bins / float(series.coefficient[0])
    if share > half_width:
        raise InputError(
            f"{name}: the light changes within a twelfth of the cell by {share:.2g} of its mean "
            "(root mean square): the LEDs are seen as they are, and have no contrast of a series: "
            "expected a plate or sheet that scatters over them"
        )
