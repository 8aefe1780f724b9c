"""Traces of films under LEDs with inputs changed: the terms of the cell's Fourier series.

A cell that is its own mirror image has cosines alone. What keeps it so moves cosines alone; a print
that is moved along an axis moves sines along it in first order, and cosines in second.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import Factor, Response
from mpfcad.measure import POINTS, CellResult, trace_terms
from mpfcad.pipeline.confidence.cell_variant import MOVES, CellVariants
from mpfcad.pipeline.confidence.runs import CURVED, Reading, Runs
from mpfcad.pipeline.progress import Progress

#: Places along each side of the cell where the light is read.
_FINE = 24
#: Paths of a block of a trace over a pitch.
_PITCH_BLOCK = POINTS * 512


class CellRuns(Runs):
    """Traces of a plan under LEDs with inputs changed, all with the same random numbers."""

    variants: CellVariants

    def __init__(
        self,
        variants: CellVariants,
        factors: list[Factor],
        found: CellResult,
        seed: int,
        threads: int,
        progress: Progress,
    ) -> None:
        moves = [MOVES[f.name] for f in factors if f.name in MOVES]
        self.order = found.series.order
        if moves and found.is_mirrored:
            self.order = np.concatenate([self.order, sines(self.order)])
        self.is_mirrored, self.estimator = found.is_mirrored, found.choice.estimator
        super().__init__(
            variants, factors, _reading(found, self.order), seed, threads, progress
        )  # fmt: skip

    def respond(self, paths_million: float) -> Response:
        """Return how the light follows the inputs: curved ones alone, the others in a factorial."""
        shape = (len(self.factors), len(self.reading.start))
        slope, slope_covariance = np.zeros(shape), np.zeros((*shape, shape[1]))
        curved = [f.is_curved for f in self.factors]
        plain = [i for i, bent in enumerate(curved) if not bent]
        blocks = self._factorial(plain, paths_million, slope, slope_covariance)
        self.progress.stage("confidence: resin and registration")
        bend, bend_covariance, own, own_covariance = self._bends(shape, CURVED * blocks)
        slope[curved], slope_covariance[curved] = own[curved], own_covariance[curved]
        first, second = self._masks()
        return self._response(
            *_kept(slope, slope_covariance, first), *_kept(bend, bend_covariance, second)
        )

    def _masks(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which terms each input can move in first order, and in second, (k, m)."""
        shape = (len(self.factors), len(self.order) - 1)
        if not self.is_mirrored:
            return np.ones(shape, bool), np.ones(shape, bool)
        even = _is_even(self.order[1:])
        cosines = np.broadcast_to(even.all(axis=1), shape)
        slope = cosines.copy()
        for number, factor in enumerate(self.factors):
            if factor.name in MOVES:
                axis = MOVES[factor.name].axis
                slope[number] = ~even[:, axis] & even[:, 1 - axis]
        return slope, cosines

    def _reach(self, number: int) -> float:
        return self.variants.reach(self.factors[number])

    def trace(self, steps: NDArray[np.float64], blocks: int) -> tuple[NDArray, NDArray]:
        """Return the coefficients of a run over its mean, and their covariance."""
        lit = self.variants.light(dict(zip(self.factors, steps.tolist(), strict=True)))
        value, covariance, traced = trace_terms(
            lit, self.order, blocks * _PITCH_BLOCK, self.seed, self.threads, self.estimator
        )
        self.paths += traced
        return value[1:] / value[0], covariance[1:, 1:] / value[0] ** 2


def _is_even(order: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which of the terms' factors along x and y are no sines, (n, 2)."""
    return (order % 2 == 1) | (order == 0)


def sines(order: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the terms with a sine along one axis, of as many harmonics as a series, (n, 2)."""
    last = int((order.max() + 1) // 2) * 2
    every = np.stack(np.divmod(np.arange((last + 1) ** 2), last + 1), axis=1)
    return every[_is_even(every).sum(axis=1) == 1]


def _kept(
    effect: NDArray[np.float64], covariance: NDArray[np.float64], mask: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return effects and covariances with what cannot be at 0."""
    return np.where(mask, effect, 0.0), covariance * mask[:, :, None] * mask[:, None, :]


def _reading(found: CellResult, order: NDArray[np.int64]) -> Reading:
    """Return the cell's own coefficients over their mean, others 0, and where light is read."""
    series, own = found.series, len(found.series.coefficient) - 1
    fine = np.arange(_FINE) / _FINE
    u, v = (part.ravel() for part in np.meshgrid(fine, fine, indexing="ij"))
    mean = series.coefficient[0]
    start, covariance = np.zeros(len(order) - 1), np.zeros((len(order) - 1,) * 2)
    start[:own] = series.coefficient[1:] / mean
    covariance[:own, :own] = series.covariance[1:, 1:] / mean**2
    basis = replace(series, order=order).at(u, v)[:, 1:]
    return Reading(np.zeros((0, 0)), basis, start, covariance, False)
