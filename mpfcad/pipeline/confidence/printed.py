"""The contrast of the film as printed: what the process does not know of it, traced.

Three runs with less resin, as it is, and more (five where large and small apertures go apart),
each a share of the film's own trace, with common random numbers. The curve's harmonics follow in
second order, as for the confidence in everything (`find`).
"""

from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.confidence import Response, draw_steps
from mpfcad.measure import CellResult, LuminanceResult
from mpfcad.pipeline.confidence.cell_runs import CellRuns
from mpfcad.pipeline.confidence.cell_variant import cell_variants_of
from mpfcad.pipeline.confidence.find import (
    Asked,
    describe_effect,
    describe_factor,
    describe_likely,
    variants_of,
)
from mpfcad.pipeline.confidence.reprint import Reprints
from mpfcad.pipeline.confidence.runs import Runs, reading_of
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import Progress

#: Paths of each run over those of the film's own trace.
_SHARE = 0.2


def find_printed(
    folder: Path,
    plan: Plan,
    luminance: LuminanceResult | CellResult,
    threads: int,
    progress: Progress,
) -> dict[str, Any] | None:
    """Return the contrast over what the process does not know of its print, in outside names.

    None where the process states no width, or the print does not set the film's resin, or the
    backlight has no endless pitch. Under LEDs all films have more or less resin together.
    """
    if isinstance(luminance, CellResult):
        return _find_cell(folder, plan, luminance, threads, progress)
    if plan.stack.extent != "pitch" or plan.stack.period.along != 0:
        return None
    with variants_of(plan, folder) as shipped:
        variants = Reprints.of(shipped)
        factors = variants.print_factors()
        if not factors:
            return None
        progress.stage("tracing the film with less and more resin")
        runs = Runs(variants, factors, reading_of(luminance), plan.job.seed, threads, progress)
        response = runs.respond_alone(_SHARE * luminance.paths)
    return _describe(plan, runs, response)


def _find_cell(
    folder: Path, plan: Plan, luminance: CellResult, threads: int, progress: Progress
) -> dict[str, Any] | None:
    with cell_variants_of(plan, folder) as variants:
        factors = variants.print_factors()
        if not factors:
            return None
        progress.stage("tracing the films with less and more resin")
        runs = CellRuns(variants, factors, luminance, plan.job.seed, threads, progress)
        response = runs.respond_alone(_SHARE * luminance.paths)
    return _describe(plan, runs, response)


def _describe(plan: Plan, runs: Runs, response: Response) -> dict[str, Any]:
    factors = runs.factors
    steps = draw_steps(factors, np.eye(len(factors)), plan.job.seed)
    return {
        **describe_likely(Asked.of(plan.job), response, steps),
        "inputs": [
            {**describe_factor(factor), **describe_effect(factor, response, number)}
            for number, factor in enumerate(factors)
        ],
        "paths": runs.paths,
    }
