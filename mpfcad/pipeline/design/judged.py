"""A traced map with how its contrast follows everything that is not known exactly, by traces."""

import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import STEP, Factor, Response, correlation, draw_steps
from mpfcad.design import Iteration
from mpfcad.measure import POINTS, TraceRun, luminance_over_pitch
from mpfcad.pipeline.confidence.find import Asked
from mpfcad.pipeline.confidence.runs import Runs, reading_of
from mpfcad.pipeline.confidence.variant import FULL, RESIN, TONE, Variants
from mpfcad.pipeline.design.kept_traces import trace_seed
from mpfcad.pipeline.design.work import DesignWork
from mpfcad.pipeline.effort import NO_GOAL
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad
from mpfcad.store import work_key

#: Draws that are traced, and paths of each.
DRAWN, _PATHS = 16, 500_000
#: Numbers of traces that no search has: of the film's own, and of the draws.
_OWN, _EACH = 1000, 1001
Change = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Judged:
    """A map, traced with its inputs changed.

    Attributes
    ----------
    one
        the map with its own trace
    factors, response
        inputs that are not known exactly; how the luminance follows them
    changes
        of each input of the resin: the curvature made of a curvature at `STEP` below and above
    drawn
        (DRAWN,) float64, contrasts traced with all inputs drawn
    paths
        spent on it
    """

    one: Iteration
    factors: list[Factor]
    response: Response
    changes: dict[str, tuple[Change, Change]]
    drawn: NDArray[np.float64]
    paths: int


def judge(work: DesignWork, one: Iteration, asked: Asked) -> Judged:
    """Return a map with what traces say of its contrast; from the store if they are there."""
    rows = np.array(one.rows)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        plan = work.plan_of(folder, rows)
        write_cad(plan, folder, ("stl",), SILENT)
        variants = Variants(plan, work.stack, folder, asked.table)
        factors = variants.factors()
        key = work_key("design", ["judged", work.inputs(), rows, asked])
        kept = work.store.read_json("design", key)
        if kept is None:
            kept = work.store.keep_json("design", key, _trace(work, one, variants, factors, asked))
        changes = {
            factor.name: (_change(variants, factor, -STEP), _change(variants, factor, STEP))
            for factor in factors
            if factor.name in (RESIN, TONE)
        }
    response = Response(**{name: np.array(value) for name, value in kept["response"].items()})
    return Judged(one, factors, response, changes, np.array(kept["drawn"]), kept["paths"])


def _trace(
    work: DesignWork, one: Iteration, variants: Variants, factors: list[Factor], asked: Asked
) -> dict[str, Any]:
    """Return the response and the contrasts of draws, fit for JSON.

    The film is traced anew: the search has chosen it by its trace, which flatters it.
    """
    seed, threads = work.design.seed, work.threads
    work.progress.stage(f"tracing {one.label} again")
    lit = variants.light({})
    limit = round(work.design.search.paths_million * 1e6)
    run = TraceRun(trace_seed(seed, _OWN), threads, limit, progress=work.progress.trace)
    luminance = luminance_over_pitch(lit, run, half_width_goal=NO_GOAL)
    runs = Runs(variants, factors, reading_of(luminance), asked.seed, threads, work.progress)
    response = runs.respond(asked.table.paths_million)
    runs.seed = trace_seed(seed, _EACH)
    blocks = max(2, round(_PATHS / (POINTS * 512)))
    steps = draws_of(factors, asked)[:DRAWN]
    work.progress.stage(f"tracing {one.label} with inputs drawn")
    as_stated = runs.trace(np.zeros(len(factors)), blocks)[0]
    # All share their random numbers: what the draw changes is known better than what it is.
    drawn = [response.start + runs.trace(z, blocks)[0] - as_stated for z in steps]
    curve = 1 + np.array(drawn) @ response.basis.T
    high, low = curve.max(axis=1), curve.min(axis=1)
    return {
        "response": {name: value.tolist() for name, value in asdict(response).items()},
        "drawn": ((high - low) / (high + low)).tolist(),
        "paths": luminance.paths + runs.paths,
    }


def draws_of(factors: list[Factor], asked: Asked) -> NDArray[np.float64]:
    """Return draws of the inputs in units of sigma, (draws, k); of the same inputs the same."""
    return draw_steps(factors, correlation(factors, asked.table.covariance_of()), asked.seed)


def _change(variants: Variants, factor: Factor, step: float) -> Change:
    """Return what curvature a print makes of a curvature with an input of the resin changed."""
    piece = variants.plan.piece
    assert piece is not None  # it has an input of the resin
    groove, size = piece.groove, float(factor.within(np.array(step))) * factor.sigma
    factors = np.broadcast_to(variants.resin_factor({factor.name: size}), piece.curvature.shape)
    order = np.argsort(piece.curvature)
    known, log = piece.curvature[order], np.log(factors[order])

    def change(curvature: NDArray[np.float64]) -> NDArray[np.float64]:
        fill = groove.fill_fraction(curvature) * np.exp(np.interp(curvature, known, log))
        return groove.curvature_of_fill(np.clip(fill, 0, FULL))

    return change
