"""A point of a sweep under tubes: its film where it lies on the panel, traced over a lamp pitch."""

import math
import tempfile
from pathlib import Path
from typing import Any

from mpfcad.backlight import Quantity
from mpfcad.pipeline.confidence.find import Asked, confidence_of
from mpfcad.pipeline.confidence.runs import reading_of
from mpfcad.pipeline.confidence.subject import GivenFilm
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.effort import NO_GOAL
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad
from mpfcad.pipeline.run.stack_mesh import write_stack_meshes
from mpfcad.units import deg


def local_shift(plan: Plan, coordinate: dict[str, Any]) -> float:
    """Return the film's shift against the lamps [mm] where it is largest on the panel.

    Shift as it is; stretch and a wrong lamp pitch grow from the panel's middle to its sides; a
    rotated film's phase drifts along the lamps, to y tan(rotation) at their ends. The turn of the
    grooves themselves is left out: its cosine is 1 within 1e-5 up to 0.25°.
    """
    stack = plan.stack
    shift = coordinate.get("shift_mm", 0.0)
    shift += coordinate.get("stretch_percent", 0.0) / 100 * stack.panel_width / 2
    shift += coordinate.get("lamp_pitch_error_mm", 0.0) * (stack.source.count - 1) / 2
    shift += math.tan(coordinate.get("rotation_deg", 0.0) * deg) * stack.panel_length / 2
    return shift


def trace_tube_point(
    plan: Plan, coordinate: dict[str, Any], half_width: float, path_limit: int, threads: int
) -> dict[str, Any]:
    """Return the luminance where the film's shift against the tubes is largest, in outside names.

    With the job's `[confidence]` also how likely its contrast is within the limit.
    """
    from mpfcad.measure import TraceRun, light_film, luminance_over_pitch
    from mpfcad.record import describe_luminance

    job, stack, shift = plan.job, plan.stack, local_shift(plan, coordinate)
    error = coordinate.get("lamp_pitch_error_mm", 0.0)
    if error:
        wrong = Quantity(stack.period.across + error, "given", "axis of the sweep")
        stack = stack.with_values({"lamp_pitch_mm": wrong})
    offset = plan.offset + shift
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_cad(plan, folder, ("stl",), SILENT)
        write_stack_meshes(plan, folder, SILENT)
        lit = light_film(stack.with_files_in(folder), folder / "film.stl", offset)
        run = TraceRun(seed=job.seed, threads=threads, path_limit=path_limit)
        found = luminance_over_pitch(lit, run, half_width_goal=half_width or NO_GOAL)
        said = {"local_shift_mm": shift, **describe_luminance(found)}
        if not job.wants_confidence:
            return said
        own = GivenFilm(offset, plan.angle_tolerance, plan.piece, plan.drawn, plan.process)
        likely = confidence_of(
            Variants(own, stack, folder, job.confidence_table), reading_of(found),
            found.contrast.value, Asked.of(job), threads, SILENT,
        )  # fmt: skip
    return {**said, "confidence": likely}
