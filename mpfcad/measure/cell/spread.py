"""Point spread function of the LEDs of a cell: the normal luminance that each alone makes.

Light adds up, so the luminance of any LEDs that shine together is the sum of their maps.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.cell.tracer import refuse_sheetless
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.rounds import Lit, TraceRun, in_rounds

if TYPE_CHECKING:
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.spread import SpreadTally

#: Bins of a map along each axis of a cell.
BINS = 8
#: What ends the trace, as progress shows it.
_FIGURE = "a bin of the LED's own cell ± {:.4f} of their mean"
#: Cells on either side that a map may hold, the fewest beside which hardly any light leaves.
_REACHES = (3, 6, 12)
_BESIDE = 0.002
#: Of a cell that holds many LEDs the maps become too many.
MOST_LEDS = 16
_PILOT_BLOCKS = 4
_LEAST_BLOCKS = 32


@dataclass(frozen=True, eq=False)
class SpreadResult:
    """What each LED of a cell adds to the normal luminance.

    Attributes
    ----------
    size
        of the cell [mm] along x and y
    position
        (l, 2) float64 [mm], the LEDs, in the cell about x = y = 0
    batch
        (g, l, n, b, n, b) float64 [cd/m²], of each of g equal parts of the paths and each LED: over
        n cells across, the LED's own in the middle, b bins of each, and the same along
    beside
        (g, ) float64, share of the light that leaves beside these n × n cells
    paths
        traced from the LEDs
    """

    size: tuple[float, float]
    position: NDArray[np.float64]
    batch: NDArray[np.float64]
    beside: NDArray[np.float64]
    paths: int

    @property
    def reach(self) -> int:
        """Cells on either side of the LED's own."""
        return self.batch.shape[2] // 2

    @property
    def bins(self) -> int:
        """Bins of a cell along each axis."""
        return self.batch.shape[3]

    def map_of(self, led: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return an LED's luminance and its standard error, (n·b, n·b) float64 [cd/m²]."""
        side = self.batch.shape[2] * self.bins
        part = self.batch[:, led].reshape(len(self.batch), side, side)
        return part.mean(axis=0), part.std(axis=0, ddof=1) / math.sqrt(len(part))

    def share(self) -> NDArray[np.float64]:
        """Return the share of the light that leaves in each cell, (g, l, n, n) float64."""
        light = self.batch.sum(axis=(3, 5))
        whole = light.sum(axis=(2, 3), keepdims=True) / (1 - self.beside[:, None, None, None])
        return light / np.where(whole > 0, whole, 1.0)

    def uniform(self) -> NDArray[np.float64]:
        """Return the luminance over a cell while all LEDs shine, (g, b, b) float64 [cd/m²].

        What left beside the maps is spread evenly.
        """
        cell = self.batch.sum(axis=(1, 2, 4))
        return cell + self.haze()[:, None, None]

    def haze(self) -> NDArray[np.float64]:
        """Return the luminance (g,) of what left beside the maps while all LEDs shine."""
        mean = self.batch.sum(axis=(1, 2, 4)).mean(axis=(1, 2))
        return mean * self.beside / (1 - self.beside)

    def radius(self, led: int, share: float) -> Estimate | None:
        """Return the radius [mm] about an LED within which such a share of its light leaves.

        Straight between the bins' distances; None where the maps do not reach so far.
        """
        side = self.batch.shape[2] * self.bins
        place = (np.arange(side) + 0.5) / self.bins - self.reach - 0.5
        across, along = place * self.size[0], place * self.size[1]
        x, y = np.meshgrid(across, along, indexing="ij")
        away = np.hypot(x - self.position[led, 0], y - self.position[led, 1]).ravel()
        far, ring = np.unique(np.round(away, 6), return_inverse=True)
        maps = self.batch[:, led].reshape(len(self.batch), -1)
        light = np.array([np.bincount(ring, part, len(far)) for part in maps])

        def read(weight: NDArray[np.float64]) -> float:
            part = np.cumsum(weight @ light) / (weight @ light.sum(axis=1))
            part *= 1 - float(weight @ self.beside) / float(weight.sum())
            return float(np.interp(share, part, far, right=math.nan))

        found = jackknife(read, len(light))
        return None if math.isnan(found.value) or math.isnan(found.low) else found


def jackknife(read: Callable[[NDArray[np.float64]], float], count: int) -> Estimate:
    """Return a figure of equal batches with its interval, by leaving each out in turn.

    `read` gives the figure of batches with weights (g,). The figure is that of all; its error
    is √((g-1)/g Σ (f_i - mean f)²), of g - 1 degrees of freedom (Tukey, "Bias and confidence in
    not-quite large samples", 1958).
    """
    whole = read(np.ones(count))
    left = np.array([read(1.0 - np.eye(count)[i]) for i in range(count)])
    error = math.sqrt((count - 1) / count * float(np.sum((left - left.mean()) ** 2)))
    return Estimate.student(whole, error, count - 1.0)


def ratio_of(over: NDArray[np.float64], under: NDArray[np.float64]) -> Estimate | None:
    """Return Σ over / Σ under of batches (g,) with its interval; None of nothing."""
    if np.count_nonzero(under) < 2:
        return None
    return jackknife(lambda weight: float(weight @ over) / float(weight @ under), len(over))


def led_spread(lit: Lit, run: TraceRun, error_goal: float) -> SpreadResult:
    """Return the point spread function of each LED of a cell of a film, or none, in a stack.

    Traces rounds of paths until a bin of the LEDs' own cells has the relative standard error
    `error_goal` (root mean square), or the run's path limit is reached. The result does not depend
    on the number of threads.

    Raises
    ------
    InputError
        when the topmost layer is no sheet that scatters, or too many LEDs are traced together.
    TraceError
        when more than 1e-6 of the light is lost.
    """
    from mpfcad.optics.forward.engine import BLOCK
    from mpfcad.optics.forward.spread import BATCHES, SpreadTally, trace_spread

    refuse_sheetless(lit)
    count = len(lit.scene.led)
    if count > MOST_LEDS:
        raise InputError(
            f"{lit.stack.name}: source: {count} LEDs are traced together: each has a map of its "
            f"own: expected at most {MOST_LEDS}: fewer in the cell, or less repeat"
        )
    meter = _meter(lit, run)

    def add(tally: "SpreadTally", blocks: range, after: Callable[[], None] | None) -> "SpreadTally":
        return trace_spread(
            lit.scene, meter, tally, blocks, seed=run.seed, threads=run.threads, after_block=after
        )

    tally = in_rounds(
        lit, run, {"meter": meter}, SpreadTally.empty(lit.scene, meter), add,
        lambda tally: _error(_result(lit, meter, tally)), error_goal, _FIGURE, block=BLOCK,
        more=lambda done: -(-max(_LEAST_BLOCKS, done // 4) // BATCHES) * BATCHES,
    )  # fmt: skip
    return _result(lit, meter, tally)


def _meter(lit: Lit, run: TraceRun) -> "CellMeter":
    """Return a meter whose maps reach so far that hardly any light leaves beside them."""
    from mpfcad.optics.forward.connection import CellMeter
    from mpfcad.optics.forward.spread import SpreadTally, trace_spread

    period = lit.stack.period
    meter = CellMeter(lit.stack.acceptance, period.across, period.along, BINS, _REACHES[-1])
    empty, blocks = SpreadTally.empty(lit.scene, meter), range(_PILOT_BLOCKS)
    pilot = trace_spread(lit.scene, meter, empty, blocks, seed=run.seed, threads=run.threads)
    whole, maps = pilot.score[:, 0].sum(), pilot.score[:, 1:].sum(axis=0)
    cells = maps.reshape(-1, 2 * meter.reach + 1, BINS, 2 * meter.reach + 1, BINS).sum(
        axis=(0, 2, 4)
    )
    for reach in _REACHES[:-1]:
        kept = slice(meter.reach - reach, meter.reach + reach + 1)
        if 1 - cells[kept, kept].sum() / whole <= _BESIDE:
            return meter._replace(reach=reach)
    return meter


def _result(lit: Lit, meter: "CellMeter", tally: "SpreadTally") -> SpreadResult:
    element: Any = lit.elements[0]
    n, b, batches = 2 * meter.reach + 1, meter.bins, len(tally.score)
    whole, maps = tally.score[:, 0], tally.score[:, 1:]
    scale = element.flux / (meter.across * meter.along) * b * b * 1e6 * batches / tally.paths
    batch = scale * maps.reshape(batches, len(lit.scene.led), n, b, n, b)
    return SpreadResult(
        (meter.across, meter.along), np.asarray(element.position), batch,
        1 - maps.sum(axis=1) / whole, tally.paths,
    )  # fmt: skip


def _error(found: SpreadResult) -> float:
    """Return the standard error of the bins of the LEDs' own cells over their mean."""
    own = found.batch[:, :, found.reach, :, found.reach]
    variance = own.var(axis=0, ddof=1) / len(own)
    return float(np.sqrt(variance.mean()) / own.mean())
