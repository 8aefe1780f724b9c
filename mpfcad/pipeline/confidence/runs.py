"""Traces of a job with inputs changed, and what is read off each luminance over the pitch."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import (
    STEP,
    Factor,
    Response,
    factorial_steps,
    fit_slopes,
    shrink_each,
)
from mpfcad.measure import POINTS, HarmonicFit, Lit, LuminanceResult, fit_harmonics
from mpfcad.measure.contrast.fit import basis
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.progress import Progress

if TYPE_CHECKING:
    from mpfcad.optics.score.tally import SlopeTally
    from mpfcad.optics.source import Source

#: A curved input's two runs and the middle have so many times the paths of a factorial run.
CURVED = 6
#: The trace that tells the smooth inputs' slopes has so much of the paths of all factorial runs.
_SMOOTH = 0.5
_FINE = 128
_POSITION = np.linspace(0, 1, POINTS)


@dataclass(frozen=True, eq=False)
class Reading:
    """What is read off a luminance over the pitch: relative coefficients of a fixed basis.

    Harmonics, or where the curve `is_sharp` its points.
    """

    gain: NDArray[np.float64]
    fine: NDArray[np.float64]
    start: NDArray[np.float64]
    covariance: NDArray[np.float64]
    is_sharp: bool

    def read(self, luminance: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coefficients over the mean, (m,)."""
        found = self.gain @ luminance
        return found[1:] / found[0]

    def slopes(self, tally: "SlopeTally") -> tuple[NDArray, NDArray]:
        """Return the coefficients' derivatives by v values, (v, m), and covariances (v, m, m)."""
        mean = float((self.gain @ tally.light)[0])
        found = self.read(tally.light)
        # A coefficient's gain over the mean: what a point's light moves it by.
        part = (self.gain[1:] - np.outer(found, self.gain[0])) / mean
        slope, scale = tally.slope @ part.T, tally.slope @ self.gain[0] / mean
        # The derivative follows the noise of the light, too, over which it is taken.
        by_light = -slope[:, :, None] * self.gain[0] / mean - scale[:, None, None] * part
        rows = np.stack([by_light, np.broadcast_to(part, by_light.shape)])
        return slope, np.einsum("avip,vpab,bvjp->vij", rows, tally.covariance, rows)

    def spread(self, luminance: NDArray[np.float64], error: NDArray[np.float64]) -> NDArray:
        """Return the coefficients' covariance for points with such errors, (m, m)."""
        mean = float((self.gain @ luminance)[0])
        part = self.gain[1:] * (error / mean)
        return part @ part.T


def reading_of(result: LuminanceResult) -> Reading:
    """Return harmonics as many as the film's own curve has, or its points where it is sharp."""
    return reading_of_points(
        result.luminance, result.standard_error, is_sharp=result.curve.is_sharp
    )


def reading_of_points(
    value: NDArray[np.float64], error: NDArray[np.float64], *, is_sharp: bool
) -> Reading:
    """Return what `reading_of` does, of the points' luminance and standard error, (POINTS,)."""
    if is_sharp:
        mean = np.full((1, POINTS), 1 / POINTS)
        gain = np.vstack([mean, np.eye(POINTS) - mean])
        fine = np.eye(POINTS)
    else:
        fit: HarmonicFit = fit_harmonics(_POSITION, value, np.full(POINTS, error.mean()), np.inf)
        gain = fit.gain
        fine = basis(np.arange(_FINE) / _FINE, fit.harmonics)[:, 1:]
    reading = Reading(gain, fine, np.zeros(0), np.zeros((0, 0)), is_sharp)
    return Reading(gain, fine, reading.read(value), reading.spread(value, error), is_sharp)


class Runs:
    """Traces with inputs changed, all with the same random numbers."""

    def __init__(
        self,
        variants: Variants,
        factors: list[Factor],
        reading: Reading,
        seed: int,
        threads: int,
        progress: Progress,
    ) -> None:
        self.variants, self.factors, self.reading = variants, factors, reading
        self.seed, self.threads, self.progress = seed, threads, progress
        self.paths = 0

    def respond(self, paths_million: float) -> Response:
        """Return how the curve follows the inputs, from about so many paths in the factorial.

        Smooth ones, by which the paths of one trace tell the derivative, are in no factorial.
        """
        shape = (len(self.factors), len(self.reading.start))
        slope, slope_covariance = np.zeros(shape), np.zeros((*shape, shape[1]))
        smooth = self._smooth(slope, slope_covariance, paths_million)
        rest = [i for i in range(len(self.factors)) if i not in smooth]
        blocks = self._factorial(rest, paths_million, slope, slope_covariance)
        self.progress.stage("confidence: second order of the resin")
        bend, bend_covariance, _, _ = self._bends(slope.shape, CURVED * blocks)
        return self._response(slope, slope_covariance, bend, bend_covariance)

    def _factorial(
        self,
        rest: list[int],
        paths_million: float,
        slope: NDArray[np.float64],
        covariance: NDArray[np.float64],
    ) -> int:
        """Put the slopes and covariances of some inputs, and return the blocks of a run."""
        runs = factorial_steps(len(rest))
        steps = np.zeros((len(runs), len(self.factors)))
        for column, i in enumerate(rest):
            steps[:, i] = self.factors[i].within(runs[:, column])
        blocks = self._blocks(paths_million / len(steps))
        if rest:
            found = []
            for number, row in enumerate(steps, 1):
                self.progress.stage(f"confidence: run {number} of {len(steps)} with inputs changed")
                found.append(self.trace(row, blocks)[0])
            slope[rest], covariance[rest] = fit_slopes(steps[:, rest], np.array(found))
        return blocks

    def _smooth(
        self, slope: NDArray[np.float64], covariance: NDArray[np.float64], paths_million: float
    ) -> set[int]:
        """Put the smooth inputs' slopes and covariances, and return which they are."""
        from mpfcad.optics.score.columns import Columns
        from mpfcad.optics.score.engine import trace_slopes

        lit = self.variants.light({})
        columns = Columns.of(lit.scene)
        along = [self.variants.direction(factor, columns) for factor in self.factors]
        smooth = [i for i, row in enumerate(along) if row is not None]
        if smooth:
            self.progress.stage("confidence: slopes by what changes no geometry")
            tally = trace_slopes(
                lit.scene, self._meter(lit), self._blocks(_SMOOTH * paths_million),
                np.array([along[i] for i in smooth]), seed=self.seed, threads=self.threads,
            )  # fmt: skip
            self.paths += tally.paths * POINTS
            slope[smooth], covariance[smooth] = self.reading.slopes(tally)
        return set(smooth)

    @staticmethod
    def _blocks(paths_million: float) -> int:
        """Return as many blocks as have about so many paths, two at least."""
        return max(2, round(paths_million * 1e6 / (POINTS * 512)))

    @staticmethod
    def _meter(lit: Lit) -> "Source":
        """Return the meter over a pitch."""
        from mpfcad.optics.source import EYE, Source

        position = _POSITION * lit.stack.period.across
        return Source(EYE, position, lit.spot.width, acceptance=lit.stack.acceptance)

    def respond_alone(self, paths: float) -> Response:
        """Return how the curve follows the inputs, each changed alone, in runs of so many paths."""
        blocks = self._blocks(paths / 1e6)
        shape = (len(self.factors), len(self.reading.start))
        bend, bend_covariance, slope, slope_covariance = self._bends(shape, blocks)
        if not self.reading.is_sharp:
            bend, bend_covariance = shrink_each(bend, bend_covariance)
            slope, slope_covariance = shrink_each(slope, slope_covariance)
        return self._response(slope, slope_covariance, bend, bend_covariance)

    def _response(
        self,
        slope: NDArray[np.float64],
        slope_covariance: NDArray[np.float64],
        bend: NDArray[np.float64],
        bend_covariance: NDArray[np.float64],
    ) -> Response:
        reading = self.reading
        return Response(
            reading.start, reading.covariance, slope, slope_covariance, bend, bend_covariance,
            reading.fine,
        )  # fmt: skip

    def _bends(self, shape: tuple[int, int], blocks: int) -> tuple[NDArray, ...]:
        """Return second and first order of the curved inputs, each with its covariance, else 0."""
        curved = [i for i, f in enumerate(self.factors) if f.is_curved]
        bend, slope = np.zeros(shape), np.zeros(shape)
        bend_covariance, slope_covariance = (
            np.zeros((*shape, shape[1])),
            np.zeros((*shape, shape[1])),
        )
        if curved:
            middle = self.trace(np.zeros(len(self.factors)), blocks)
            for i in curved:
                bend[i], bend_covariance[i], slope[i], slope_covariance[i] = self._bend(
                    i, middle, blocks
                )
        return bend, bend_covariance, slope, slope_covariance

    def _bend(
        self, number: int, middle: tuple[NDArray, NDArray], blocks: int
    ) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """Return b and a of y = y0 + a z + b z² through three runs, each with its covariance.

        The runs share their random numbers, so errors taken as independent are too large.
        """
        step = np.zeros(len(self.factors))
        ends = []
        for sign in (-1.0, 1.0):
            reach = sign * self._reach(number)
            step[number] = float(self.factors[number].within(np.array(reach)))
            ends.append((step[number], *self.trace(step, blocks)))
        (low, below, below_spread), (high, above, above_spread) = ends
        span = high - low
        found = []
        for one, other in (
            (1 / (high * span), -1 / (low * span)),
            (-low / (high * span), high / (low * span)),
        ):
            found.append(one * (above - middle[0]) + other * (below - middle[0]))
            found.append(
                one**2 * above_spread + other**2 * below_spread + (one + other) ** 2 * middle[1]
            )
        return found[0], found[1], found[2], found[3]

    def _reach(self, number: int) -> float:
        """Return how far a curved input is changed, in units of its sigma."""
        return STEP

    def trace(self, steps: NDArray[np.float64], blocks: int) -> tuple[NDArray, NDArray]:
        """Return the coefficients (m,) of a run with inputs at steps (k,) of their sigma.

        And their covariance (m, m).
        """
        from mpfcad.measure.rounds import trace_lit

        lit = self.variants.light(dict(zip(self.factors, steps.tolist(), strict=True)))
        tally = trace_lit(lit, self._meter(lit), blocks, seed=self.seed, threads=self.threads)
        self.paths += tally.total_paths
        spread = self.reading.spread(tally.radiance, tally.radiance_error)
        return self.reading.read(tally.radiance), spread
