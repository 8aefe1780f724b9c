"""The confidence in a job's verdict: traces with inputs changed together, and what follows."""

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import (
    STEP,
    Factor,
    Response,
    correlation,
    draw_steps,
    factorial_steps,
    fit_slopes,
    likely_contrast,
    rank_measurements,
    shares_of_variance,
)
from mpfcad.errors import InputError
from mpfcad.measure import POINTS, Estimate, HarmonicFit, LuminanceResult, fit_harmonics
from mpfcad.measure.contrast.fit import basis
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import Progress

#: A curved input's two runs and the middle have so many times the paths of a factorial run.
_CURVED = 6
_FINE = 128
_POSITION = np.linspace(0, 1, POINTS)


def find_confidence(
    folder: Path,
    plan: Plan,
    luminance: LuminanceResult,
    threads: int,
    progress: Progress,
) -> dict[str, Any]:
    """Return how likely the contrast meets the job's limits, in outside names.

    `folder` holds film.stl and the meshes that the stack needs; `luminance` is its trace.

    Raises
    ------
    InputError
        when the job's backlight has no endless pitch, or a covariance names what is no input.
    """
    table = plan.job.confidence_table
    if plan.stack.extent != "pitch" or plan.stack.period.along != 0:
        raise InputError(
            f"confidence: stack {plan.stack.name}, extent {plan.stack.extent}: expected tubes and "
            'extent = "pitch"'
        )
    with tempfile.TemporaryDirectory() as temporary:
        for path in folder.glob("*.stl"):
            shutil.copy(path, temporary)
        inside = Path(temporary)
        variants = Variants(plan, plan.stack.with_files_in(inside), inside, table)
        factors = variants.factors()
        runs = _Runs(variants, factors, _reading(luminance), plan.job.seed, threads, progress)
        response = runs.respond(table.paths_million)
    return _describe(plan, luminance, response, factors, runs.paths, variants.left_out())


@dataclass(frozen=True, eq=False)
class _Reading:
    """What is read off a luminance over the pitch: relative coefficients of a fixed basis."""

    gain: NDArray[np.float64]
    fine: NDArray[np.float64]
    start: NDArray[np.float64]
    covariance: NDArray[np.float64]

    def read(self, luminance: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coefficients over the mean, (m,)."""
        found = self.gain @ luminance
        return found[1:] / found[0]

    def spread(self, luminance: NDArray[np.float64], error: NDArray[np.float64]) -> NDArray:
        """Return the coefficients' covariance for points with such errors, (m, m)."""
        mean = float((self.gain @ luminance)[0])
        part = self.gain[1:] * (error / mean)
        return part @ part.T


def _reading(result: LuminanceResult) -> _Reading:
    """Return harmonics as many as the film's own curve has, or its points where it is sharp."""
    value, error = result.luminance, result.standard_error
    if result.curve.is_sharp:
        mean = np.full((1, POINTS), 1 / POINTS)
        gain = np.vstack([mean, np.eye(POINTS) - mean])
        fine = np.eye(POINTS)
    else:
        fit: HarmonicFit = fit_harmonics(_POSITION, value, np.full(POINTS, error.mean()), np.inf)
        gain = fit.gain
        fine = basis(np.arange(_FINE) / _FINE, fit.harmonics)[:, 1:]
    reading = _Reading(gain, fine, np.zeros(0), np.zeros((0, 0)))
    return _Reading(gain, fine, reading.read(value), reading.spread(value, error))


class _Runs:
    """Traces with inputs changed, all with the same random numbers."""

    def __init__(
        self,
        variants: Variants,
        factors: list[Factor],
        reading: _Reading,
        seed: int,
        threads: int,
        progress: Progress,
    ) -> None:
        self.variants, self.factors, self.reading = variants, factors, reading
        self.seed, self.threads, self.progress = seed, threads, progress
        self.paths = 0

    def respond(self, paths_million: float) -> Response:
        """Return how the curve follows the inputs, from about so many paths in the factorial."""
        steps = factorial_steps(len(self.factors))
        steps = np.stack([f.within(steps[:, i]) for i, f in enumerate(self.factors)], axis=1)
        blocks = max(2, round(paths_million * 1e6 / (len(steps) * POINTS * 512)))
        found = []
        for number, row in enumerate(steps, 1):
            self.progress.stage(f"confidence: run {number} of {len(steps)} with inputs changed")
            found.append(self._trace(row, blocks)[0])
        slope, slope_covariance = fit_slopes(steps, np.array(found))
        bend = np.zeros_like(slope)
        bend_covariance = np.zeros_like(slope_covariance)
        curved = [i for i, f in enumerate(self.factors) if f.is_curved]
        if curved:
            self.progress.stage("confidence: second order of the resin")
            middle = self._trace(np.zeros(len(self.factors)), _CURVED * blocks)
            for i in curved:
                bend[i], bend_covariance[i] = self._bend(i, middle, _CURVED * blocks)
        return Response(
            self.reading.start, self.reading.covariance, slope, slope_covariance, bend,
            bend_covariance, self.reading.fine,
        )  # fmt: skip

    def _bend(self, number: int, middle: tuple[NDArray, NDArray], blocks: int) -> tuple:
        """Return the second order b of y = y0 + a z + b z² through three runs, and its covariance.

        The runs share their random numbers, so errors taken as independent are too large.
        """
        step = np.zeros(len(self.factors))
        ends = []
        for sign in (-1.0, 1.0):
            step[number] = float(self.factors[number].within(np.array(sign * STEP)))
            ends.append((step[number], *self._trace(step, blocks)))
        (low, below, below_spread), (high, above, above_spread) = ends
        span = high - low
        weight = np.array([1 / (high * span), -1 / (low * span)])
        bend = weight[0] * (above - middle[0]) + weight[1] * (below - middle[0])
        spread = weight[0] ** 2 * above_spread + weight[1] ** 2 * below_spread
        return bend, spread + weight.sum() ** 2 * middle[1]

    def _trace(self, steps: NDArray[np.float64], blocks: int) -> tuple[NDArray, NDArray]:
        """Return the coefficients of a run and their covariance."""
        from mpfcad.optics.engine import trace
        from mpfcad.optics.source import EYE, Source

        lit = self.variants.light(dict(zip(self.factors, steps.tolist(), strict=True)))
        stack = lit.stack
        source = Source(
            EYE, _POSITION * stack.period.across, lit.spot.width, acceptance=stack.acceptance
        )
        tally = trace(lit.scene, source, blocks, seed=self.seed, threads=self.threads)
        self.paths += tally.total_paths
        spread = self.reading.spread(tally.radiance, tally.radiance_error)
        return self.reading.read(tally.radiance), spread


def _describe(
    plan: Plan,
    luminance: LuminanceResult,
    response: Response,
    factors: list[Factor],
    paths: int,
    left_out: list[str],
) -> dict[str, Any]:
    job, table = plan.job, plan.job.confidence_table
    between = correlation(factors, table.covariance_of())
    steps = draw_steps(factors, between, job.seed)
    limits = {"pass": job.gates.contrast_pass, "marginal": job.gates.contrast_marginal}
    likely = {
        name: likely_contrast(response, steps, limit, job.seed) for name, limit in limits.items()
    }
    share = shares_of_variance(response, between)
    order = sorted(range(len(factors)), key=lambda i: (-share[i], factors[i].name))
    return {
        "probability": {
            name: {"limit": limits[name], **_plain(one.probability)} for name, one in likely.items()
        },
        "contrast": _plain(likely["marginal"].contrast),
        "contrast_as_stated": luminance.contrast.value,
        "inputs": [
            {
                "name": factors[i].name,
                "value": factors[i].value,
                "sigma": factors[i].sigma,
                "source": factors[i].source,
                "share_of_variance": float(share[i]),
                "effect_of_sigma": [float(v) for v in response.slope[i]],
                "standard_error": [
                    float(v) for v in np.sqrt(np.diag(response.slope_covariance[i]))
                ],
            }
            for i in order
        ],
        "measure_next": rank_measurements(response, factors, steps, limits["marginal"], job.seed),
        "left_out": left_out,
        "paths": paths,
        "draws": len(steps),
    }


def _plain(estimate: Estimate) -> dict[str, Any]:
    return {"value": estimate.value, "ci95": [estimate.low, estimate.high]}
