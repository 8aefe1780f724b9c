"""The confidence in a job's verdict: traces with inputs changed together, and what follows."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
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
from mpfcad.job import ConfidenceTable, GateTable, Job
from mpfcad.measure import CellResult, Estimate, LuminanceResult
from mpfcad.pipeline.confidence.cell_runs import CellRuns
from mpfcad.pipeline.confidence.cell_variant import cell_variants_of
from mpfcad.pipeline.confidence.runs import Reading, Runs, reading_of
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import Progress


@dataclass(frozen=True)
class Asked:
    """What a confidence is asked with: widths of film and print, limits, and a seed."""

    table: ConfidenceTable
    gates: GateTable
    seed: int

    @classmethod
    def of(cls, job: Job | None, seed: int | None = None) -> "Asked":
        """Return what a job asks with, or the usual without one; `seed` in place of the job's."""
        if job is None:
            return cls(ConfidenceTable(), GateTable(), 1 if seed is None else seed)
        return cls(job.confidence_table, job.gates, job.seed if seed is None else seed)


def refuse_confidence(stack: Stack) -> None:
    """Raise where it is not found how a curve, or the light over a cell, follows the inputs.

    Raises
    ------
    InputError
        when the panel has a rim, or light is in bands, whose derivatives are not traced.
    """
    if stack.bands is not None:
        raise InputError(f"confidence: stack {stack.name}: light.bands: expected one wavelength")
    if stack.extent != "pitch":
        raise InputError(
            f'confidence: stack {stack.name}, extent {stack.extent}: expected extent = "pitch"'
        )


def refuse_cell_confidence(stack: Stack) -> None:
    """Raise for LEDs, too, where a command finds the confidence of rows of tubes alone.

    Raises
    ------
    InputError
        as `refuse_confidence`, and when LEDs light the stack.
    """
    refuse_confidence(stack)
    if stack.period.along > 0:
        raise InputError(
            f"confidence: stack {stack.name}: LEDs light it: expected tubes, or `mpfcad run JOB "
            "--confidence`"
        )


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
    luminance: LuminanceResult | CellResult,
    threads: int,
    progress: Progress,
) -> dict[str, Any]:
    """Return how likely the contrast meets the job's limits, in outside names.

    `folder` holds the film as it was traced and the meshes that the stack needs; `luminance` is its
    trace.

    Raises
    ------
    InputError
        when the job's backlight has a rim or bands, or a covariance names what is no input.
    """
    refuse_confidence(plan.stack)
    asked = Asked.of(plan.job)
    if isinstance(luminance, CellResult):
        with cell_variants_of(plan, folder) as cell:
            over = CellRuns(cell, cell.factors(), luminance, asked.seed, threads, progress)
            return _likely(over, cell.left_out(), luminance.contrast.value, asked)
    with variants_of(plan, folder) as variants:
        return confidence_of(
            variants, reading_of(luminance), luminance.contrast.value, asked, threads, progress
        )


def confidence_of(
    variants: Variants,
    reading: Reading,
    contrast: float,
    asked: Asked,
    threads: int,
    progress: Progress,
) -> dict[str, Any]:
    """Return how likely a film's contrast meets the limits, in outside names.

    `reading` and `contrast` are of its own trace, as stated.

    Raises
    ------
    InputError
        when a covariance names what is no input.
    """
    runs = Runs(variants, variants.factors(), reading, asked.seed, threads, progress)
    return _likely(runs, variants.left_out(), contrast, asked)


def _likely(runs: Runs, left_out: list[str], contrast: float, asked: Asked) -> dict[str, Any]:
    factors = runs.factors
    response = runs.respond(asked.table.paths_million)
    between = correlation(factors, asked.table.covariance_of())
    steps = draw_steps(factors, between, asked.seed)
    share = shares_of_variance(response, between)
    order = sorted(range(len(factors)), key=lambda i: (-share[i], factors[i].name))
    return {
        **describe_likely(asked, response, steps),
        "contrast_as_stated": contrast,
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
        "measure_next": rank_measurements(response, factors, steps, asked.gates.contrast_marginal),
        "left_out": left_out,
        "paths": runs.paths,
        "draws": len(steps),
    }


def describe_likely(asked: Asked, response: Response, steps: NDArray[np.float64]) -> dict[str, Any]:
    """Return how likely each limit is met over steps (n, k) of the inputs, fit for JSON."""
    gates = asked.gates
    limits = {"pass": gates.contrast_pass, "marginal": gates.contrast_marginal}
    likely = {
        name: likely_contrast(response, steps, limit, asked.seed) for name, limit in limits.items()
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
