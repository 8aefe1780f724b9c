"""What is measured on a case, by name; measured figures are kept and found again."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mpfcad.measure import Checkpoints, Estimator, Lit, TraceRun
from mpfcad.pipeline.confidence.find import Asked, confidence_of
from mpfcad.pipeline.confidence.runs import reading_of_points
from mpfcad.pipeline.effort import (
    MEASURE_SETTINGS,
    TRACE_SETTINGS,
    available_threads,
    over_pitches,
)
from mpfcad.pipeline.estimator import chosen_estimator, note_estimator
from mpfcad.pipeline.measure.case import Case
from mpfcad.pipeline.progress import Progress
from mpfcad.pipeline.psf import describe_psf
from mpfcad.store import Store, work_key

#: What can be measured, in the order of the page.
WHAT = (
    "contrast", "angular", "conoscope", "flux", "uniformity", "camera", "panel", "polarisation",
    "colour", "psf",
)  # fmt: skip
#: Of them what is measured under LEDs, and there alone.
CELL_WHAT = (
    "contrast", "angular", "conoscope", "flux", "camera", "polarisation", "colour", "psf",
)  # fmt: skip
ONLY_CELL = ("psf",)
#: Of them what is not measured of light in bands.
UNBANDED = ("flux", "psf")


@dataclass(frozen=True)
class Measuring:
    """How a case is measured."""

    seed: int = 1
    effort: str = "standard"
    threads: int | None = None
    estimator: str = Estimator.auto.value

    def run(self, lit: Lit, progress: Progress, checkpoints: Any) -> TraceRun:
        """Return how to trace a film in its stack."""
        return TraceRun(
            self.seed, self.threads or available_threads(),
            TRACE_SETTINGS[self.effort].path_limit, checkpoints, progress.trace,
            estimator=chosen_estimator(self.estimator, lit),
        )  # fmt: skip


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
    what |= {"estimator": measuring.estimator}
    key = work_key("figure", {**case.lit.case, **what, "schema": MEASUREMENT_SCHEMA})
    kept = store.read_json("figure", key)
    if kept is not None:
        return kept
    with Checkpoints(store) as checkpoints:
        run = measuring.run(case.lit, progress, checkpoints)
        found = store.keep_json("figure", key, _MEASURE[name](case.lit, run, measuring.effort))
    note_estimator(found.get("estimator"), progress)
    return found


def case_confidence(
    case: Case, contrast: dict[str, Any], measuring: Measuring, progress: Progress
) -> dict[str, Any]:
    """Return how likely a case's contrast meets its limits, in outside names; kept like figures.

    `contrast` is what was measured of it.

    Raises
    ------
    InputError
        when a covariance names what is no input.
    """
    subject = case.subject()
    asked = Asked.of(subject.job, measuring.seed)
    store = Store.open(progress.note)
    # What the film's own trace has said is an input; effort and paths are in it.
    of_film = [case.lit.case, subject.piece, subject.process, subject.angle_tolerance]
    key = work_key("figure", ["confidence", *of_film, asked, contrast])
    kept = store.read_json("figure", key)
    if kept is not None:
        return kept
    points = contrast["luminance"]
    reading = reading_of_points(
        np.array(points["luminance_cd_m2"]), np.array(points["standard_error_cd_m2"]),
        is_sharp=not contrast["curve"]["smoothed"],
    )  # fmt: skip
    with case.variants(subject, asked) as variants:
        found = confidence_of(
            variants, reading, contrast["lamp_mura_contrast"]["value"], asked,
            measuring.threads or available_threads(), progress,
        )  # fmt: skip
    return store.keep_json("figure", key, found)


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


def _polarisation(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import polarisation
    from mpfcad.record import describe_polarisation

    return describe_polarisation(polarisation(lit, run, MEASURE_SETTINGS[effort].polarisation))


def _colour(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    from mpfcad.measure import screen_colour
    from mpfcad.record import describe_colour

    assert lit.stack.bands is not None  # refused before
    found = screen_colour(lit, run, MEASURE_SETTINGS[effort].colour)
    return describe_colour(found, lit.stack.bands.wavelength)


def _psf(lit: Lit, run: TraceRun, effort: str) -> dict[str, Any]:
    return describe_psf(lit, run, MEASURE_SETTINGS[effort].pixel)


_MEASURE: dict[str, Callable[[Lit, TraceRun, str], dict[str, Any]]] = {
    "contrast": _contrast,
    "angular": _angular,
    "conoscope": _conoscope,
    "flux": _flux,
    "uniformity": _uniformity,
    "camera": _camera,
    "panel": _panel,
    "polarisation": _polarisation,
    "psf": _psf,
    "colour": _colour,
}
