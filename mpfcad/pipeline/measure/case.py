"""One film in one stack, and what was measured on it; measured figures are kept and found again."""

import json
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpfcad.backlight import Quantity, Stack, read_stack
from mpfcad.errors import ExportError, InputError
from mpfcad.export import check_manifest
from mpfcad.job import Job, read_job
from mpfcad.measure import Checkpoints, Lit, TraceRun, light_film
from mpfcad.pipeline.effort import (
    MEASURE_SETTINGS,
    TRACE_SETTINGS,
    available_threads,
    over_pitches,
)
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.store import Store, work_key

DEFAULT_STACK = "thesis-32in-mpf"
#: What can be measured, in the order of the page.
WHAT = ("contrast", "angular", "conoscope", "flux", "uniformity", "camera", "panel")
#: Of them what is measured under LEDs.
CELL_WHAT = ("contrast", "angular", "conoscope", "flux")


@dataclass(frozen=True, eq=False)
class Case:
    """A film in a stack, ready to trace.

    Attributes
    ----------
    name
        of the film, as the user named it
    film
        what the mesh is: its file, or words
    lit
        the mesh in its stack
    """

    name: str
    film: str
    lit: Lit


@dataclass(frozen=True)
class Measuring:
    """How a case is measured."""

    seed: int = 1
    effort: str = "standard"
    threads: int | None = None

    def run(self, progress: Progress, checkpoints: Any) -> TraceRun:
        """Return how to trace."""
        return TraceRun(
            self.seed, self.threads or available_threads(),
            TRACE_SETTINGS[self.effort].path_limit, checkpoints, progress.trace,
        )  # fmt: skip


def read_case(
    source: str,
    stack: str | None = None,
    thickness: float | None = None,
    offset: float = 0.0,
    *,
    alone: bool = False,
) -> Case:
    """Return the case of a mesh, an export folder, a job, or a preset (with a plain BEF in it).

    `stack`: a preset or stack file in place of the export's or job's own; `thickness` [mm] of the
    stack in place of its own; `offset` [mm] of a mesh's left edge from a lamp's axis; `alone`: of
    two printed films the first, the other's prisms bare.

    Raises
    ------
    InputError
        when there is no such thing, or it is wrong.
    """
    path = Path(source)
    if path.is_dir():
        return _read_export(path, stack, thickness, alone)
    if path.suffix == ".toml" and path.is_file():
        return job_case(read_job(path), path, stack, thickness, alone=alone)
    if path.is_file():
        placed = read_stack(stack or DEFAULT_STACK, thickness=thickness)
        return Case(path.stem, path.name, light_film(placed, path, offset))
    if path.suffix or path.name != source:
        raise InputError(
            f"{source}: no such file: expected a closed mesh in mm, a job, an export or a preset"
        )
    return plain_case(read_stack(source, thickness=thickness))


def baseline_case() -> Case:
    """Return a plain BEF in the conventional stack: what every case is compared with."""
    from mpfcad.pipeline.run.examine import BASELINE_PRESET

    return plain_case(read_stack(BASELINE_PRESET))


def write_plain(stack: Stack, mesh: Path) -> None:
    """Write the plain BEF that a stack is traced with."""
    from mpfcad.cad import write_stl
    from mpfcad.job.model import CadTable
    from mpfcad.pipeline.run.examine import baseline_film

    write_stl(baseline_film(stack), mesh, CadTable().angle_tolerance)


def plain_case(stack: Stack) -> Case:
    """Return a plain BEF, written to a file and read back, in a stack."""
    if not stack.has_slot:
        return Case("no film", "none", light_film(stack, None))
    with tempfile.TemporaryDirectory() as temporary:
        mesh = Path(temporary) / "bef.stl"
        write_plain(stack, mesh)
        return Case("BEF", "plain BEF", light_film(stack, mesh))


def _read_export(folder: Path, stack: str | None, thickness: float | None, alone: bool) -> Case:
    from mpfcad.backlight.stored import restore_stack
    from mpfcad.pipeline.plan.cell import with_crossed

    try:
        manifest = check_manifest(folder)
        if "verification.json" not in manifest["files"]:
            raise InputError(
                f"{folder}: holds no verification.json: expected an export of mpfcad run"
            )
        record = json.loads((folder / "verification.json").read_text("utf-8"))
    except ExportError as error:
        raise InputError(str(error)) from None
    own = restore_stack(record["job"]["stack"]).with_files_in(folder)
    placed = _placed(own, stack, thickness).with_prism(own.prism)
    across = folder / "film-crossed.3mf"
    if record.get("crossed") is not None and not alone:
        placed = with_crossed(placed, across)
    traced = record["provenance"]["traced"]
    file = folder / traced["file"]
    return Case(record["name"], file.name, light_film(placed, file, traced["offset_mm"]))


def job_case(
    job: Job,
    job_file: Path,
    stack: str | None = None,
    thickness: float | None = None,
    *,
    alone: bool = False,
) -> Case:
    """Return the film of a job, written to a file and read back, without the rest of its export.

    `stack`, `thickness` and `alone` as in `read_case`; file names in the job are taken from beside
    `job_file`, which need not exist.

    Raises
    ------
    InputError
        when the job or a file it names is wrong.
    """
    from mpfcad.pipeline.kind import kind_of
    from mpfcad.pipeline.plan.cell import with_crossed
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.run.make import write_cad
    from mpfcad.pipeline.run.stack_mesh import write_stack_meshes

    plan = read_plan(job, job_file)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        traced = kind_of(plan.drawn, plan.job.cad).run_formats[-1]
        write_cad(plan, folder, (traced,), SILENT)
        write_stack_meshes(plan, folder, SILENT)
        own = plan.stack.with_files_in(folder)
        placed = _placed(own, stack, thickness).with_prism(own.prism)
        if plan.crossed is not None and not alone:
            placed = with_crossed(placed, folder / plan.crossed.file("film", traced))
        mesh = folder / plan.file("film", traced)
        return Case(job.name, job_file.name, light_film(placed, mesh, plan.offset))


def _placed(own: Stack, stack: str | None, thickness: float | None) -> Stack:
    """Return the stack asked for, or the film's own."""
    if stack is not None:
        return read_stack(stack, thickness=thickness)
    if thickness is None:
        return own
    return own.with_values({"thickness_mm": Quantity(thickness, "given", "given by the user")})


def measure_case(
    case: Case, what: Iterable[str], measuring: Measuring, progress: Progress
) -> dict[str, Any]:
    """Return what was measured on a case, by its name in `WHAT`.

    A figure that an earlier call has found for the same mesh, stack, seed and effort is not traced
    again: the result is the same bit for bit.
    """
    found = {}
    for note in (*(t.table.summary() for t in case.lit.stack.tables.values()), *case.lit.notes):
        progress.note(note)
    for name in what:
        progress.stage(f"{case.name} in {case.lit.stack.name}: {name}")
        found[name] = _measured(case, name, measuring, progress)
    return found


def _measured(case: Case, name: str, measuring: Measuring, progress: Progress) -> dict[str, Any]:
    from mpfcad.record import MEASUREMENT_SCHEMA

    store = Store.open(progress.note)
    what = {"what": name, "seed": measuring.seed, "effort": measuring.effort}
    key = work_key("figure", {**case.lit.case, **what, "schema": MEASUREMENT_SCHEMA})
    kept = store.read_json("figure", key)
    if kept is not None:
        return kept
    with Checkpoints(store) as checkpoints:
        run = measuring.run(progress, checkpoints)
        return store.keep_json("figure", key, _MEASURE[name](case.lit, run, measuring.effort))


def _contrast(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import luminance_over_cell, luminance_over_pitch
    from mpfcad.record import describe_cell, describe_contrast

    goal = TRACE_SETTINGS[effort].half_width_goal
    if lit.is_cell:
        return describe_cell(luminance_over_cell(lit, run, half_width_goal=goal), run.seed)
    found = luminance_over_pitch(lit, over_pitches(run, lit), half_width_goal=goal)
    return describe_contrast(found, run.seed)


def _angular(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import angular_luminance
    from mpfcad.record import describe_angular

    return describe_angular(angular_luminance(lit, run, MEASURE_SETTINGS[effort].direction))


def _conoscope(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import conoscope
    from mpfcad.record import describe_conoscope

    return describe_conoscope(conoscope(lit, run, MEASURE_SETTINGS[effort].conoscope))


def _flux(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import output_flux
    from mpfcad.record import describe_flux

    return describe_flux(output_flux(lit, run, MEASURE_SETTINGS[effort].flux))


def _uniformity(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import screen_uniformity
    from mpfcad.record import describe_uniformity

    return describe_uniformity(screen_uniformity(lit, run, MEASURE_SETTINGS[effort].screen))


def _camera(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import camera_image
    from mpfcad.record import describe_camera

    return describe_camera(camera_image(lit, run, MEASURE_SETTINGS[effort].pixel))


def _panel(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import panel_luminance
    from mpfcad.record import describe_panel

    return describe_panel(panel_luminance(lit, run, MEASURE_SETTINGS[effort].cell))


_MEASURE: dict[str, Callable[[Lit, TraceRun, str], dict[str, Any]]] = {
    "contrast": _contrast,
    "angular": _angular,
    "conoscope": _conoscope,
    "flux": _flux,
    "uniformity": _uniformity,
    "camera": _camera,
    "panel": _panel,
}
