"""`compare_cases`: films and stacks side by side, the conventional stack first."""

from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.export import canonical_json, export_folder, write_manifest, write_text
from mpfcad.pipeline.measure.case import Case, Measuring, baseline_case, measure_case
from mpfcad.pipeline.measure.measure import describe_case, screen
from mpfcad.pipeline.progress import SILENT, Progress

COMPARE_FILE = "compare.json"
COMPARE_PAGE = "compare.html"
_WHAT = ("contrast", "angular", "flux")


def compare_cases(
    cases: list[Case], out: Path, measuring: Measuring, progress: Progress = SILENT
) -> dict[str, Any]:
    """Measure cases into the folder `out`, which appears whole or not at all; return the record.

    What is measured is kept by the hash of mesh, stack, seed and effort: a comparison that was
    interrupted, or that gets one more case, traces only what is new.

    Raises
    ------
    InputError
        when `out` is something else than an older comparison, or LEDs light a case.
    """
    from mpfcad.report import write_compare_page

    for case in cases:
        if case.lit.is_cell:
            raise InputError(
                f"{case.name}: stack {case.lit.stack.name}: LEDs: expected stacks of tubes "
                "to compare; mpfcad measure takes it alone"
            )
    base = baseline_case()
    others = [case for case in cases if case.lit.case != base.lit.case]
    with export_folder(out, "compare") as folder:
        rows = [_row(case, measuring, progress) for case in (base, *others)]
        for row in rows:
            row |= _relative(row, rows[0])
        record = {
            "schema": 1,
            "baseline": rows[0]["label"],
            "seed": measuring.seed,
            "effort": measuring.effort,
            "cases": rows,
        }
        write_text(folder / COMPARE_FILE, canonical_json(record))
        progress.stage(f"writing {COMPARE_PAGE}")
        write_compare_page(folder / COMPARE_PAGE, record)
        write_manifest(folder, out.name, "compare")
    return record


def _row(case: Case, measuring: Measuring, progress: Progress) -> dict[str, Any]:
    stack = case.lit.stack
    return {
        "label": f"{case.name} in {stack.name}",
        "traced": describe_case(case, measuring),
        "screen": screen(case.lit),
        "sheet_count": stack.sheet_count,
        **measure_case(case, _WHAT, measuring, progress),
    }


def _relative(row: dict[str, Any], base: dict[str, Any]) -> dict[str, Any]:
    """Return a case's luminance and efficiency over the baseline's; the baseline's own are 1."""
    from mpfcad.measure import Estimate
    from mpfcad.record import describe_estimate, ratio

    if row is base:
        one = describe_estimate(Estimate(1.0, 1.0, 1.0, 0.0))
        return {"relative_luminance": one, "relative_efficiency": one}
    return {
        "relative_luminance": ratio(
            row["contrast"]["mean_luminance_cd_m2"], base["contrast"]["mean_luminance_cd_m2"]
        ),
        "relative_efficiency": ratio(
            row["flux"]["efficiency_lm_per_lm"], base["flux"]["efficiency_lm_per_lm"]
        ),
    }
