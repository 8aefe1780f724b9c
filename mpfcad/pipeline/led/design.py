"""`run_led_design`: printed films for LEDs, found and traced from the files that are shipped."""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.export import canonical_json, export_folder, refuse_foreign, write_manifest, write_text
from mpfcad.film import CurvatureSeries
from mpfcad.job.led_design import MOULDED, LedConstraintTable, LedDesign
from mpfcad.measure import CellResult, Checkpoints, TraceRun, light_film, luminance_over_cell
from mpfcad.pipeline.effort import NO_GOAL, TRACE_SETTINGS, available_threads
from mpfcad.pipeline.kind.library import PieceGrooves
from mpfcad.pipeline.led.bound import least_contrast
from mpfcad.pipeline.led.film import (
    CROSSED,
    FILM,
    STACK,
    check_films,
    films_of,
    halftones_of,
    shown_films,
    write_films,
)
from mpfcad.pipeline.led.goal import GoalSearch, board_words, boards_of
from mpfcad.pipeline.led.job import job_tables, write_job
from mpfcad.pipeline.led.screen import describe_screen, find_screen, printed_tables
from mpfcad.pipeline.led.search import LedSearch
from mpfcad.pipeline.led.tolerance import find_tolerances
from mpfcad.pipeline.led.tried import Tried
from mpfcad.pipeline.plan.plan import read_job_stack
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.record.printing import PHOTOTOOL_ONLY
from mpfcad.store import Store

RECORD, PAGE, MAP = "design.json", "design.html", "curvature-cell.npz"


def run_led_design(
    design: LedDesign,
    design_file: Path,
    out: Path,
    *,
    effort: str = "standard",
    threads: int | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Find the map, write films, stack, map and record into `out`, and return the record.

    What the record states last is traced from the written files, to the half-width of `effort`.
    Tallies of the search and of the last trace are kept until `out` is on the disk, so that an
    interrupted design goes on; what tells its tolerances is kept trace by trace.

    Raises
    ------
    InputError
        when the design is wrong or `out` is something else; `out` is then as it was.
    """
    design_file, out = Path(design_file), Path(out)
    refuse_foreign(out.resolve(), "led-design")
    read_led_stack(design, design_file)
    with Checkpoints(Store.open(progress.note)) as checkpoints:
        work = _Work(design_file, threads or available_threads(), checkpoints, progress)
        return _ship(work, *_searched(work, design), out, effort)


@dataclass(frozen=True)
class _Work:
    """What a design is found with."""

    design_file: Path
    threads: int
    checkpoints: Checkpoints
    progress: Progress

    def base(self, design: LedDesign, folder: Path) -> str:
        """Return what a stack file in a folder extends."""
        if design.stack.file is None:
            return str(design.stack.preset)
        return os.path.relpath(self.design_file.parent / design.stack.file, folder)

    def trace(self, folder: Path, seed: int, paths: int, goal: float) -> CellResult:
        """Trace the films and the stack of a folder."""
        from mpfcad.backlight import read_stack

        run = TraceRun(seed, self.threads, paths, self.checkpoints, self.progress.trace)
        lit = light_film(read_stack(folder / STACK), folder / FILM)
        return luminance_over_cell(lit, run, half_width_goal=goal)

    def search(self, design: LedDesign) -> LedSearch:
        """Return the search of a board's map; each trial is traced from files of its own."""
        stack = read_led_stack(design, self.design_file)
        aim = design.goal.aim
        said = "" if aim == "contrast" else f", {board_words(aim, stack)}"

        def tried(chosen: CurvatureSeries) -> CellResult:
            with tempfile.TemporaryDirectory() as temporary:
                folder = Path(temporary)
                write_films(design, stack, self.base(design, folder), chosen, folder)
                self.progress.stage(f"tracing C = {chosen.coefficient[0, 0]:.3g} /mm{said}")
                paths = round(design.search.paths_million * 1e6)
                return self.trace(folder, design.seed, paths, NO_GOAL)

        return LedSearch(design, tried)


def _searched(work: _Work, design: LedDesign) -> tuple[LedDesign, LedSearch, dict[str, Any] | None]:
    """Return the design of the board that was chosen, its search, and what was asked of others."""
    if design.goal.aim == "contrast":
        _check(work, design)
        search = work.search(design)
        search.run()
        return design, search, None
    file = work.design_file
    stack = read_led_stack(design, file)
    boards = boards_of(design, str(file), (stack.panel_width, stack.panel_length))
    for board in boards:
        _check(work, board.design)
    target = design.goal.contrast_target
    goal = GoalSearch(boards, lambda board: work.search(board.design), target)
    chosen = goal.run()
    return boards[chosen].design, goal.searched[chosen], goal.describe(chosen, design.goal.aim)


def _check(work: _Work, design: LedDesign) -> None:
    """Refuse, before any trace, a board or films that no job makes: those tried first."""
    even = CurvatureSeries(np.array([design.search.uniform_per_mm[:1]]))
    films_of(design, read_led_stack(design, work.design_file), even)


def _ship(
    work: _Work,
    design: LedDesign,
    search: LedSearch,
    ranged: dict[str, Any] | None,
    out: Path,
    effort: str,
) -> dict[str, Any]:
    """Write the best map's files into `out`, trace them, and return the record."""
    from mpfcad.record import describe_cell
    from mpfcad.report.page.led_page import write_led_page

    file, progress = work.design_file, work.progress
    stack, best, base = read_led_stack(design, file), search.best, work.base(design, out)
    with export_folder(out, "led-design") as folder:
        films = write_films(design, stack, base, best.map, folder)
        progress.stage("checking " + " and ".join((FILM, CROSSED)[: len(films)]))
        check_films(films, folder)
        _write_map(folder / MAP, films[0])
        progress.stage(f"tracing {FILM} in {STACK}")
        seed = design.seed + 1
        found = _trace_shipped(work, design, folder, base, seed, effort)
        tables = job_tables(design, best.map)
        halftones = halftones_of(design, stack, best.map)
        used = np.concatenate([np.unique(film.shown) for film in films])
        if design.halftone is not None:
            used = np.array([design.halftone.curvature_per_mm])
        printing = find_screen(design, file, tables, used) if design.is_printed else None
        tables = printed_tables(design, tables, printing)
        bears = find_tolerances(design, file, stack, tables, work.threads, progress)
        record = {
            "schema": 1,
            "name": design.name,
            "design": design.document(),
            # The search asks no screen but by the limits of C; the job that is written does.
            "screen": PHOTOTOOL_ONLY if design.is_printed else None,
            "printing": describe_screen(design, printing),
            "range": ranged,
            "optical_distance_mm": _distance(stack),
            "height_over_pitch": _distance(stack) / max(stack.source.cell),
            "series_per_mm": best.map.coefficient.tolist(),
            **({"halftone": halftones} if halftones else {}),
            "films": [_describe_film(design, film) for film in films],
            "tried": [_describe_tried(one) for one in search.tried],
            "pilot": None if search.pilot is None else search.pilot.document(),
            "model_least": _describe_least(design.constraint, search),
            # What the traces tell of a halftone is no mould's.
            "mould": None if halftones else _describe_least(_of_mould(design), search),
            "effort": effort,
            "found": describe_cell(found, seed),
            "bears": bears,
        }
        write_text(folder / RECORD, canonical_json(record))
        write_job(folder / f"{design.name}.toml", design, file, base, tables)
        progress.stage(f"writing {PAGE}")
        write_led_page(folder / PAGE, record, shown_films(films, folder))
        write_manifest(folder, design.name, "led-design")
    return record


def _trace_shipped(
    work: _Work, design: LedDesign, folder: Path, base: str, seed: int, effort: str
) -> CellResult:
    """Trace a copy of the shipped films, whose stack's base is found from where it will lie."""
    setting = TRACE_SETTINGS[effort]
    with tempfile.TemporaryDirectory() as temporary:
        copy = Path(temporary)
        for name in (FILM, CROSSED):
            if (folder / name).is_file():
                (copy / name).write_bytes((folder / name).read_bytes())
        text = (folder / STACK).read_text("utf-8")
        (copy / STACK).write_text(text.replace(base, work.base(design, copy), 1), "utf-8")
        return work.trace(copy, seed, setting.path_limit, setting.half_width_goal)


def read_led_stack(design: LedDesign, design_file: Path) -> Stack:
    """Return the backlight of a design.

    Raises
    ------
    InputError
        when it is wrong, or tubes light it.
    """
    stack = read_job_stack(design, design_file)  # type: ignore[arg-type]
    if stack.period.along <= 0:
        raise InputError(f"{design_file}: stack: {stack.name}: tubes light it: expected LEDs")
    return stack


def _distance(stack: Stack) -> float:
    """Return the optical distance [mm]: reflector to plate, and the plate over its index."""
    return stack.thickness + stack["plate_thickness_mm"] / stack["plate_index"]


def _write_map(path: Path, kind: PieceGrooves) -> None:
    """Write the film's curvatures as its file holds them, at the pieces' middles."""
    film, (n, m) = kind.film, kind.shown.shape
    arrays: dict[str, Any] = {
        "position_across_mm": (np.arange(n) + 0.5) * film.groove.pitch,
        "position_along_mm": (np.arange(m) + 0.5) * film.length,
        "curvature_per_mm": kind.shown.T,
    }
    np.savez(path, **arrays)


def _describe_film(design: LedDesign, kind: PieceGrooves) -> dict[str, Any]:
    film, used = kind.film, kind.shown
    fill = np.asarray(film.groove.fill_fraction(used))
    known = design.is_printed
    return {
        "size_mm": list(film.size),
        "pieces": len(np.unique(film.chosen)),
        "places": list(film.chosen.shape),
        "curvature_min_per_mm": float(used.min()),
        "curvature_max_per_mm": float(used.max()),
        "fill_min": float(fill.min()) if known else None,
        "fill_mean": float(fill.mean()) if known else None,
        "fill_max": float(fill.max()) if known else None,
    }


def _of_mould(design: LedDesign) -> LedConstraintTable:
    """Return the limits of C that a mould has: none but those of the groove."""
    low, high = MOULDED
    most = min(high, design.film.groove.curvature_most(design.film.profile))
    update = {"curvature_min_per_mm": low, "curvature_max_per_mm": most}
    return design.constraint.model_copy(update=update)


def _describe_least(limit: LedConstraintTable, search: LedSearch) -> dict[str, Any]:
    """Return the best that the linear model has within limits, from the best map's trace."""
    least = least_contrast(limit, search.best, search.response)
    return {
        "lamp_mura_contrast": least.contrast,
        "series_per_mm": least.coefficient.tolist(),
        "response_mm": search.response.tolist(),
    }


def _describe_tried(one: Tried) -> dict[str, Any]:
    contrast = one.found.contrast
    return {
        "series_per_mm": one.map.coefficient.tolist(),
        "harmonic": one.harmonic.tolist(),
        "lamp_mura_contrast": {
            "value": contrast.value,
            "ci95": [contrast.low, contrast.high],
            "standard_error": contrast.standard_error,
        },
        "paths": one.found.paths,
    }
