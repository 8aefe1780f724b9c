"""The confidence in a job's verdict: traces with inputs changed together, and what follows."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import (
    Factor,
    Response,
    correlation,
    draw_steps,
    likely_contrast,
    rank_measurements,
    shares_of_variance,
)
from mpfcad.errors import InputError
from mpfcad.measure import Estimate, LuminanceResult
from mpfcad.pipeline.confidence.runs import Runs, reading_of
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import Progress


@contextmanager
def variants_of(plan: Plan, folder: Path) -> Iterator[Variants]:
    """Give the job's scenes with its inputs changed; `folder` holds the meshes as shipped."""
    with tempfile.TemporaryDirectory() as temporary:
        for path in folder.glob("*.stl"):
            shutil.copy(path, temporary)
        inside = Path(temporary)
        stack = plan.stack.with_files_in(inside)
        yield Variants(plan, stack, inside, plan.job.confidence_table)


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
    with variants_of(plan, folder) as variants:
        factors = variants.factors()
        runs = Runs(variants, factors, reading_of(luminance), plan.job.seed, threads, progress)
        response = runs.respond(table.paths_million)
    return _describe(plan, luminance, response, factors, runs.paths, variants.left_out())


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
    share = shares_of_variance(response, between)
    order = sorted(range(len(factors)), key=lambda i: (-share[i], factors[i].name))
    return {
        **describe_likely(plan, response, steps),
        "contrast_as_stated": luminance.contrast.value,
        "inputs": [
            {
                **describe_factor(factors[i]),
                "share_of_variance": float(share[i]),
                **describe_effect(factors[i], response, i),
                "standard_error": [
                    float(v) for v in np.sqrt(np.diag(response.slope_covariance[i]))
                ],
            }
            for i in order
        ],
        "measure_next": rank_measurements(
            response, factors, steps, job.gates.contrast_marginal, job.seed
        ),
        "left_out": left_out,
        "paths": paths,
        "draws": len(steps),
    }


def describe_likely(plan: Plan, response: Response, steps: NDArray[np.float64]) -> dict[str, Any]:
    """Return how likely each limit is met over steps (n, k) of the inputs, fit for JSON."""
    gates = plan.job.gates
    limits = {"pass": gates.contrast_pass, "marginal": gates.contrast_marginal}
    likely = {
        name: likely_contrast(response, steps, limit, plan.job.seed)
        for name, limit in limits.items()
    }
    return {
        "probability": {
            name: {"limit": limits[name], **_describe_estimate(one.probability)}
            for name, one in likely.items()
        },
        "contrast": _describe_estimate(likely["marginal"].contrast),
    }


def describe_factor(factor: Factor) -> dict[str, Any]:
    """Return an input as it is stated, fit for JSON."""
    return {
        "name": factor.name,
        "value": factor.value,
        "sigma": factor.sigma,
        "source": factor.source,
    }


def describe_effect(factor: Factor, response: Response, number: int) -> dict[str, Any]:
    """Return an input's ends, and what one sigma of it does to the curve, fit for JSON."""
    low, high = (float(end) if np.isfinite(end) else None for end in (factor.low, factor.high))
    bend = response.bend[number]
    return {
        "low": low,
        "high": high,
        "effect_of_sigma": [float(v) for v in response.slope[number]],
        "second_order": [float(v) for v in bend] if bend.any() else [],
    }


def _describe_estimate(estimate: Estimate) -> dict[str, Any]:
    """Return value and 95 % interval, fit for JSON."""
    return {"value": estimate.value, "ci95": [estimate.low, estimate.high]}
