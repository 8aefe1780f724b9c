"""`trace_mesh`: any film mesh in a stack, the way `mpfcad trace` asks for it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.errors import InputError
from mpfcad.measure import Checkpoints, Estimator
from mpfcad.pipeline.effort import MEASURE_SETTINGS, TRACE_SETTINGS, available_threads, over_pitches
from mpfcad.pipeline.estimator import chosen_estimator, note_estimator
from mpfcad.pipeline.measure.case import Case, mesh_case
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.run.repair import repair_mesh
from mpfcad.store import Store

if TYPE_CHECKING:
    from mpfcad.backlight import Stack
    from mpfcad.measure import LuminanceResult


def _check_prism(prism: Path, stack: "Stack") -> None:
    """Refuse the file of a film without resin that is not there, or that no light would see."""
    if not stack.needs_prism:
        raise InputError(
            f"--prism: {prism}: in {stack.name} light does not see where the resin ends: expected "
            "resin that scatters or has a material of its own, or rough prisms"
        )
    if not prism.is_file():
        raise InputError(f"--prism: {prism}: no such file: expected the film without its resin")


def trace_mesh(
    mesh: Path | None,
    stack: str,
    thickness: float | None,
    offset: float,
    seed: int,
    effort: str,
    threads: int | None,
    progress: Progress = SILENT,
    prism: Path | None = None,
    repair: bool = False,
    confidence: bool = False,
    estimator: str = Estimator.auto.value,
) -> dict[str, Any]:
    """Trace any closed film mesh in a stack, or a stack that has none; return the figures.

    `thickness` is that of the stack [mm] (None: its own), `offset` the position of the mesh's left
    edge from a lamp's axis [mm]; `prism` the mesh without resin, where light sees it.
    With `repair` a mesh that is no solid is repaired into a file beside it, which is traced; with
    `confidence` also how likely the usual limits are met with every input's uncertainty.
    `estimator` is the way to trace a cell of LEDs.

    Raises
    ------
    InputError
        when the mesh is no closed film or the stack is wrong, or has no confidence.
    """
    from mpfcad.backlight import read_stack
    from mpfcad.export import sha256
    from mpfcad.measure import (
        TraceRun,
        luminance_over_cell,
        luminance_over_pitch,
        polarisation,
        screen_colour,
    )
    from mpfcad.pipeline.confidence.find import refuse_cell_confidence
    from mpfcad.record import (
        describe_cell,
        describe_colour,
        describe_luminance,
        describe_polarisation,
    )

    if mesh is not None and not mesh.is_file():
        raise InputError(f"{mesh}: no such file: expected a closed mesh in mm")
    backlight = read_stack(stack, thickness=thickness).with_prism(prism)
    if prism is not None:
        _check_prism(prism, backlight)
    setting = TRACE_SETTINGS[effort]
    repaired = None
    if repair and mesh is not None:
        mesh, repaired = repair_mesh(mesh, progress)
    progress.stage(f"tracing {mesh or stack}")
    if confidence:
        refuse_cell_confidence(backlight)
    case = mesh_case(mesh, backlight, offset)
    lit = case.lit
    way = chosen_estimator(estimator, lit)
    with Checkpoints(Store.open(progress.note)) as checkpoints:
        run = TraceRun(
            seed, threads or available_threads(), setting.path_limit, checkpoints, progress.trace,
            estimator=way,
        )  # fmt: skip
        goal = setting.half_width_goal
        if lit.is_cell:
            figures = describe_cell(luminance_over_cell(lit, run, half_width_goal=goal), seed)
            note_estimator(figures["estimator"], progress)
        else:
            found = luminance_over_pitch(lit, over_pitches(run, lit), half_width_goal=goal)
            figures = describe_luminance(found)
            if confidence:
                figures["confidence"] = _confidence(case, found, seed, run.threads, progress)
        if backlight.polarised:
            goal = MEASURE_SETTINGS[effort].polarisation
            figures["polarisation"] = describe_polarisation(polarisation(lit, run, goal))
        if backlight.bands is not None:
            goal = MEASURE_SETTINGS[effort].colour
            colour = screen_colour(lit, run, goal, directions=False)
            figures["colour"] = describe_colour(colour, backlight.bands.wavelength)
    film = {"file": mesh.name, "sha256": sha256(mesh)} if mesh else {"file": None, "sha256": None}
    for table in backlight.tables.values():
        progress.note(table.table.summary())
    for note in lit.notes:
        progress.note(note)
    tables = [
        {"file": t.name, "sha256": t.sha256, "notes": list(t.table.note)}
        for t in backlight.tables.values()
    ]
    traced: dict[str, Any] = {
        **film,
        "stack": str(stack),
        "notes": lit.notes,
        "tables": tables,
        "seed": seed,
    }
    if repaired:
        traced["repaired_from"] = repaired
    return {"schema": 1, "traced": traced, **figures}


def _confidence(
    case: Case, found: "LuminanceResult", seed: int, threads: int, progress: Progress
) -> dict[str, Any]:
    """Return how likely the limits are met by a film that was traced."""
    from mpfcad.pipeline.confidence.find import Asked, confidence_of
    from mpfcad.pipeline.confidence.runs import reading_of

    asked, subject = Asked.of(None, seed), case.subject()
    with case.variants(subject, asked) as variants:
        return confidence_of(
            variants, reading_of(found), found.contrast.value, asked, threads, progress
        )
