"""`fit_backlight`: the values that measurements hold, a stack with covariance, page and record."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.fit import Datum, Figured, Found, Unknowns, rank_next, search_values
from mpfcad.fit.reading import PITCH, harmonics_of, luminance
from mpfcad.fit.search import View, later_lines
from mpfcad.job.fit import Fit
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.fit.case import FitCase, build_cases, read_backlight
from mpfcad.pipeline.fit.data import figured_of, read_data
from mpfcad.pipeline.fit.sought import ABSOLUTE, find_unknowns, needs_level
from mpfcad.pipeline.fit.stack_file import covariance_text, stack_text
from mpfcad.pipeline.fit.tracer import FitTracer, run_paths
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.record.fit import Fitted, describe_fit
from mpfcad.store import Store

PAGE, RECORD, COVARIANCE = "fit.html", "fit.json", "covariance.csv"
#: Standard errors of what is offered as a next measurement of each case: cosines of a curve, and
#: a mean luminance over that of the first case.
_COSINES, _CURVE_ERROR, _RATIO_ERROR = 4, 0.001, 0.005
#: A value without prior whose step is known no better than this is not held by the data.
_NOT_HELD = 30.0


def default_fit_out(fit: Fit) -> Path:
    """Return where a fit's results go unless told otherwise."""
    return Path("exports") / f"{fit.name}-fit"


@dataclass(frozen=True)
class FitSetting:
    """How a fit is traced: effort (None: the file's) and threads (None: all cores)."""

    effort: str | None = None
    threads: int | None = None


def fit_backlight(
    fit: Fit, file: Path, out: Path, setting: FitSetting | None = None, progress: Progress = SILENT
) -> dict[str, Any]:
    """Fit a backlight to measurements into the folder `out`, which appears whole or not at all.

    Traces are kept in the store: a fit that was stopped, or has got one more measurement, traces
    only what is new. The results do not depend on the number of threads.

    Raises
    ------
    InputError
        when the file, a case, a measurement or a covariance is wrong, or data are too few.
    """
    from mpfcad.report import write_fit_page

    refuse_foreign(out.resolve(), "fit")
    setting = setting or FitSetting()
    effort = setting.effort or fit.trace.effort
    stack = read_backlight(fit, file)
    data, notes = read_data(fit, file, stack.period.across)
    for note in notes:
        progress.note(note)
    with tempfile.TemporaryDirectory() as temporary:
        progress.stage("making the films")
        cases = build_cases(fit, file, stack, Path(temporary))
        unknowns, active = find_unknowns(fit, file, stack, cases)
        _check_level(file, fit)
        _check_count(file, data, unknowns)
        _check_reach(file, data, active)
        views = _views([d.figured for d in data])
        tracer = FitTracer(
            cases, unknowns, active, Store.open(progress.note),
            run_paths=run_paths(effort, len(views), len(unknowns.factors)), seed=fit.seed,
            threads=setting.threads or available_threads(),
        )  # fmt: skip
        found = search_values(tracer, views, data, unknowns, progress.stage)
        _check_held(file, found, unknowns)
        predictions, candidates = _asked(fit)
        more = [*predictions, *(figured for figured, _ in candidates)]
        found = later_lines(tracer, _views(more), found, unknowns, progress.stage)
    candidates += _usual(found, cases, data)
    fitted = Fitted(
        data, unknowns, found, predictions,
        rank_next(found.posterior, unknowns, found.lines, candidates, predictions),
    )  # fmt: skip
    record = describe_fit(fit.name, fitted) | {
        "fit": fit.document(),
        "effort": effort,
        "read": notes,
        "paths": tracer.paths,
    }
    with export_folder(out, "fit") as folder:
        _write(folder, out, fit, file, stack, record)
        write_fit_page(folder / PAGE, record)
        write_manifest(folder, fit.name, "fit")
    return record


def _write(
    folder: Path, out: Path, fit: Fit, file: Path, stack: Stack, record: dict[str, Any]
) -> None:
    write_text(folder / f"{fit.name}.toml", stack_text(fit, file, stack, record, out.resolve()))
    write_text(folder / COVARIANCE, covariance_text(record))
    write_text(folder / RECORD, canonical_json(record))


def _views(figures: list[Figured]) -> list[View]:
    """Return the views that figures need, each once, in order."""
    return list(dict.fromkeys(view for figured in figures for view in figured.views))


def _asked(fit: Fit) -> tuple[list[Figured], list[tuple[Figured, Any]]]:
    """Return what is to be predicted, and what could be measured with its covariance."""
    candidates = [(figured_of(one), np.array([[one.sigma**2]])) for one in fit.candidate]
    return [figured_of(one) for one in fit.predict], candidates


def _usual(found: Found, cases: dict[str, FitCase], data: list[Datum]) -> list[tuple[Figured, Any]]:
    """Return the measurements that any meter can do on the cases whose luminance was traced."""
    traced = [name for name in cases if (name, PITCH) in found.lines]
    offered: list[tuple[Figured, Any]] = []
    for name in traced:
        curve = Figured(
            f"luminance curve over the lamps: {name}", (name, PITCH), harmonics_of(_COSINES)
        )
        offered.append((curve, np.eye(_COSINES) * _CURVE_ERROR**2))
        if name != traced[0]:
            ratio = Figured(
                f"mean luminance: {name} over {traced[0]}", (name, PITCH), luminance,
                (traced[0], PITCH),
            )  # fmt: skip
            offered.append((ratio, np.array([[_RATIO_ERROR**2]])))
    return offered


def _check_level(file: Path, fit: Fit) -> None:
    asked = [("candidate", one) for one in fit.candidate] + [("predict", p) for p in fit.predict]
    for table, one in asked:
        if one.of in ABSOLUTE and one.over is None and not needs_level(fit):
            raise InputError(
                f"{file}: {table}: {one.case}: {one.of}: no measurement states an absolute "
                "luminance or flux: expected one, or over"
            )


def _check_count(file: Path, data: list[Datum], unknowns: Unknowns) -> None:
    measured = sum(len(d.value) for d in data if d.side == 0)
    free = [name for name, one in zip(unknowns.names, unknowns.is_free, strict=True) if one]
    # A luminance that no measurement states in cd/m² stays as it is.
    if len(free) > 1 and measured < len(free):
        raise InputError(
            f"{file}: {measured} measured numbers for {len(free)} values without prior "
            f"({', '.join(free)}): expected as many, or a prior (sigma)"
        )


def _check_reach(file: Path, data: list[Datum], active: dict[str, NDArray[np.bool_]]) -> None:
    for datum in data:
        cases = [view[0] for view in datum.figured.views]
        if not any(active[case].any() for case in cases):
            raise InputError(
                f"{file}: measurement: {datum.name}: case.{cases[0]} has none of the values sought "
                "(its override fixes them): expected a case that has one"
            )


def _check_held(file: Path, found: Found, unknowns: Unknowns) -> None:
    left = np.sqrt(np.diag(found.posterior.covariance))
    for factor, size, is_free, scales in zip(
        unknowns.factors, left, unknowns.is_free, unknowns.is_scale, strict=True
    ):
        if is_free and not scales and size > _NOT_HELD:
            raise InputError(
                f"{file}: {factor.name}: without prior, and the measurements do not hold it: "
                "expected one that does, or a prior (sigma)"
            )
