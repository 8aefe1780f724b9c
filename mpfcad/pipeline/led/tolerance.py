"""What a design for LEDs bears: its contrast with films out of place, other resin, binned LEDs."""

from pathlib import Path
from typing import Any

from mpfcad.backlight import Stack
from mpfcad.job.led_design import LedDesign
from mpfcad.pipeline.point.thickness_limit import outcome
from mpfcad.pipeline.point.trace import POINT, Point, describe_coordinate, trace_point
from mpfcad.pipeline.progress import Progress
from mpfcad.store import Store

#: Shift of a film that is tried unless the design says, as a share of the LEDs' pitch.
_SHIFT = 0.04
#: Cells traced together where LEDs differ.
_REPEAT = 2.0


def departures(design: LedDesign, stack: Stack) -> list[dict[str, float]]:
    """Return the departures that are tried, each as the coordinate of a sweep's point."""
    table = design.tolerance
    shift = table.shift_mm
    if shift is None:
        shift = float(f"{_SHIFT * min(stack.source.cell):.2g}")
    axes = ["shift_x_mm", "shift_y_mm"]
    if design.films == 2:
        axes = ["crossed_shift_x_mm", "crossed_shift_y_mm", "board_shift_x_mm"]
    found = [{axis: shift} for axis in axes if shift > 0]
    axis, off = "resin_percent", table.resin_percent
    if not design.is_printed:
        axis, off = "curvature_error_per_mm", table.curvature_per_mm
    if off > 0:
        found += [{axis: sign * off} for sign in (1.0, -1.0)]
    if table.flux_percent > 0:
        spread = table.flux_percent / 100
        found.append({"stack.override.led_flux_spread": spread, "led_repeat": _REPEAT})
    return found


def find_tolerances(
    design: LedDesign,
    design_file: Path,
    stack: Stack,
    job: dict[str, Any],
    threads: int,
    progress: Progress,
) -> list[dict[str, Any]]:
    """Return each departure with its contrast, traced from files; finished ones are kept.

    `job` is the document of the job that was found, its files named from beside `design_file`.
    `outcome` holds the contrast's interval against the design's target.
    """
    table, store, found = design.tolerance, Store.open(progress.note), []
    for coordinate in departures(design, stack):
        document = _with_overrides(job, coordinate)
        limit = round(table.paths_million * 1e6)
        point = Point(coordinate, document, str(design_file), table.half_width, limit)
        progress.stage(f"tracing {describe_coordinate(coordinate)}")
        key = point.key()
        result = store.read_json(POINT, key)
        if result is None:
            result = store.keep_json(POINT, key, trace_point(point, threads))
        contrast = result["lamp_mura_contrast"]
        found.append(
            {
                "departure": coordinate,
                "lamp_mura_contrast": contrast,
                "mean_luminance_cd_m2": result["mean_luminance_cd_m2"],
                "outcome": outcome(contrast, design.goal.contrast_target),
                "paths": result["paths"],
            }
        )
    return found


def _with_overrides(job: dict[str, Any], coordinate: dict[str, float]) -> dict[str, Any]:
    """Return a job's document with the stack's values of a coordinate."""
    stack = dict(job["stack"])
    values = {k.rpartition(".")[2]: v for k, v in coordinate.items() if "." in k}
    return {**job, "stack": {**stack, "override": {**stack.get("override", {}), **values}}}
