"""`compare_cases`: films and stacks side by side, what they are held against first.

Under tubes that is the conventional stack. Under LEDs it is the first case's own stack, without
prism films and with bare ones.
"""

from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.export import canonical_json, export_folder, write_manifest, write_text
from mpfcad.pipeline.confidence.find import refuse_cell_confidence
from mpfcad.pipeline.measure.case import Case, baseline_case
from mpfcad.pipeline.measure.figures import Measuring, case_confidence, measure_case
from mpfcad.pipeline.measure.led_case import plain_cases
from mpfcad.pipeline.measure.measure import describe_case, screen
from mpfcad.pipeline.progress import SILENT, Progress

COMPARE_FILE = "compare.json"
COMPARE_PAGE = "compare.html"
_WHAT = ("contrast", "angular", "flux")
#: Under LEDs; a forward trace finds with the contrast how much light leaves.
_CELL_WHAT = ("contrast",)


def compare_cases(
    cases: list[Case],
    out: Path,
    measuring: Measuring,
    progress: Progress = SILENT,
    *,
    confidence: bool = False,
) -> dict[str, Any]:
    """Measure cases into the folder `out`, which appears whole or not at all; return the record.

    What is measured is kept by the hash of mesh, stack, seed and effort: a comparison that was
    interrupted, or that gets one more case, traces only what is new. With `confidence` each case
    says how likely its contrast holds with every input's uncertainty.

    Raises
    ------
    InputError
        when `out` is something else than an older comparison, or LEDs light some cases and tubes
        others, or the confidence is asked of LEDs or a finite panel.
    """
    from mpfcad.report import write_compare_page

    is_cell = _all_leds(cases)
    if confidence:
        for case in cases:
            refuse_cell_confidence(case.lit.stack)
    bases = plain_cases(cases[0].lit) if is_cell else [baseline_case(cases[0].lit.stack.polarised)]
    known = [base.lit.case for base in bases]
    others = [case for case in cases if case.lit.case not in known]
    what = _CELL_WHAT if is_cell else _WHAT
    with export_folder(out, "compare") as folder:
        rows = [_row(case, what, measuring, progress) for case in (*bases, *others)]
        base = rows[len(bases) - 1]
        for row in rows:
            row |= _relative(row, base)
        if confidence:
            for case, row in zip((*bases, *others), rows, strict=True):
                progress.stage(f"{row['label']}: confidence")
                row["confidence"] = case_confidence(case, row["contrast"], measuring, progress)
        record = {
            "schema": 1,
            "baseline": base["label"],
            "seed": measuring.seed,
            "effort": measuring.effort,
            "cases": rows,
        }
        write_text(folder / COMPARE_FILE, canonical_json(record))
        progress.stage(f"writing {COMPARE_PAGE}")
        write_compare_page(folder / COMPARE_PAGE, record)
        write_manifest(folder, out.name, "compare")
    return record


def _all_leds(cases: list[Case]) -> bool:
    """Return whether LEDs light all cases; tubes light all others."""
    lit = {case.lit.is_cell: case for case in cases}
    if len(lit) > 1:
        led, tube = lit[True], lit[False]
        raise InputError(
            f"{led.name}: stack {led.lit.stack.name}: LEDs; {tube.name}: stack "
            f"{tube.lit.stack.name}: tubes: expected one kind of light to compare"
        )
    return True in lit


def _row(
    case: Case, what: tuple[str, ...], measuring: Measuring, progress: Progress
) -> dict[str, Any]:
    stack = case.lit.stack
    return {
        "label": f"{case.name} in {stack.name}",
        "traced": describe_case(case, measuring),
        "screen": screen(case.lit),
        "sheet_count": stack.sheet_count,
        **measure_case(case, what, measuring, progress),
    }


def _relative(row: dict[str, Any], base: dict[str, Any]) -> dict[str, Any]:
    """Return a case's luminance and efficiency over the baseline's; the baseline's own are 1."""
    from mpfcad.measure import Estimate
    from mpfcad.record import describe_estimate, ratio

    pairs = {"relative_luminance": ("contrast", "mean_luminance_cd_m2")}
    if "flux" in row:
        pairs["relative_efficiency"] = ("flux", "efficiency_lm_per_lm")
    if row is base:
        return dict.fromkeys(pairs, describe_estimate(Estimate(1.0, 1.0, 1.0, 0.0)))
    return {name: ratio(row[part][key], base[part][key]) for name, (part, key) in pairs.items()}
