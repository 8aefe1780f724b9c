"""`measure_film`: a case measured, beside the conventional stack, into a folder that is whole."""

from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.export import canonical_json, export_folder, write_manifest, write_text
from mpfcad.measure import Lit
from mpfcad.pipeline.confidence.find import refuse_cell_confidence
from mpfcad.pipeline.estimator import chosen_estimator
from mpfcad.pipeline.measure.case import Case, baseline_case
from mpfcad.pipeline.measure.figures import (
    CELL_WHAT,
    ONLY_CELL,
    UNBANDED,
    WHAT,
    Measuring,
    case_confidence,
    measure_case,
)
from mpfcad.pipeline.progress import SILENT, Progress

MEASURE_FILE = "measure.json"
MEASURE_PAGE = "measure.html"
#: What is also measured on the conventional stack, to compare with.
_COMPARED = ("contrast", "flux")
_RIM = "The panel is finite: side walls, lamps of their length, black beside its edges."
_NO_RIM = (
    "Traced without the panel's rim: {0} and film go on sideways without end, so corners are as "
    "bright as the middle, and only the place over the {0} differs."
)


def default_measure_out(case: Case) -> Path:
    """Return where a case's measurement goes unless told otherwise."""
    return Path("exports") / f"{case.name}-measure"


def default_what(case: Case) -> tuple[str, ...]:
    """Return everything that can be measured on a case."""
    from mpfcad.measure import can_connect

    coloured, is_cell = case.lit.spectral is not None, case.lit.is_cell
    connected = is_cell and can_connect(case.lit)
    lacks = {"panel": not case.lit.is_finite, "polarisation": not case.lit.stack.polarised,
             "colour": not coloured, **dict.fromkeys(ONLY_CELL, not connected)}  # fmt: skip
    lacks |= dict.fromkeys(UNBANDED, True) if coloured else {}
    return tuple(name for name in (CELL_WHAT if is_cell else WHAT) if not lacks.get(name))


def measure_film(
    case: Case,
    what: tuple[str, ...],
    out: Path,
    measuring: Measuring,
    progress: Progress = SILENT,
    *,
    confidence: bool = False,
) -> dict[str, Any]:
    """Measure a case into the folder `out`, which appears whole or not at all; return the record.

    With `confidence` also how likely its contrast holds with every input's uncertainty.

    Raises
    ------
    InputError
        when `out` is something else than an older measurement, or `panel` is asked of a stack
        that repeats without end, or what is not measured under LEDs, or the confidence of what
        has none.
    """
    from mpfcad.measure import check_finite, refuse_uncoloured, refuse_unpolarised
    from mpfcad.report import write_measure_page, write_pictures

    wrong = [name for name in what if name not in CELL_WHAT]
    if case.lit.is_cell and wrong:
        raise InputError(
            f"--what: {wrong[0]}: not measured under LEDs: expected {', '.join(CELL_WHAT)}"
        )
    if not case.lit.is_cell and set(what) & set(ONLY_CELL):
        raise InputError(
            f"--what: {ONLY_CELL[0]}: of LEDs alone: expected a stack whose [source] is leds"
        )
    if "panel" in what:
        check_finite(case.lit)
    if "polarisation" in what:
        refuse_unpolarised(case.lit)
    if "colour" in what:
        refuse_uncoloured(case.lit)
    unbanded = [name for name in what if name in UNBANDED]
    if case.lit.spectral is not None and unbanded:
        raise InputError(
            f"--what: {unbanded[0]}: {case.lit.stack.name} states light.bands: expected "
            f"{', '.join(default_what(case))}"
        )
    if confidence:
        refuse_cell_confidence(case.lit.stack)
        if "contrast" not in what:
            raise InputError(
                f"--confidence: --what {','.join(what)}: expected contrast among what is measured"
            )
    chosen_estimator(measuring.estimator, case.lit)
    with export_folder(out, "measure") as folder:
        record = measurement(case, what, measuring, progress)
        if confidence:
            record["confidence"] = case_confidence(case, record["contrast"], measuring, progress)
        write_text(folder / MEASURE_FILE, canonical_json(record))
        if "camera" in record:
            write_pictures(folder, record["camera"], record["screen"]["lamps_level"])
        progress.stage(f"writing {MEASURE_PAGE}")
        write_measure_page(folder / MEASURE_PAGE, record)
        write_manifest(folder, case.name, "measure")
    return record


def measurement(
    case: Case, what: tuple[str, ...], measuring: Measuring, progress: Progress
) -> dict[str, Any]:
    """Return measure.json of a case."""
    from mpfcad.record import ratio

    found = measure_case(case, what, measuring, progress)
    record = {"schema": 1, "name": case.name, "traced": describe_case(case, measuring)}
    record |= {"screen": screen(case.lit), **found}
    compared = tuple(name for name in _COMPARED if name in what)
    if not compared or case.lit.is_cell:
        return record
    base = measure_case(baseline_case(case.lit.stack.polarised), compared, measuring, progress)
    record["baseline"] = {"stack": "thesis-32in-conventional", "film": "BEF", **base}
    if "contrast" in compared:
        record["relative_luminance"] = ratio(
            found["contrast"]["mean_luminance_cd_m2"], base["contrast"]["mean_luminance_cd_m2"]
        )
    if "flux" in compared:
        record["relative_efficiency"] = ratio(
            found["flux"]["efficiency_lm_per_lm"], base["flux"]["efficiency_lm_per_lm"]
        )
    return record


def describe_case(case: Case, measuring: Measuring) -> dict[str, Any]:
    """Return what was traced, in plain values."""
    lit = case.lit
    return {
        "film": case.film,
        "mesh_sha256": lit.case["mesh"],
        "offset_mm": lit.case["offset"],
        "stack": lit.stack.name,
        "title": lit.stack.title,
        "layers": list(lit.stack.layers),
        "inputs": lit.stack.inputs(),
        "accelerator": lit.accelerator,
        "seed": measuring.seed,
        "effort": measuring.effort,
    }


def screen(lit: Lit) -> dict[str, Any]:
    """Return how the lamps lie on the screen: level when the panel's longer side is along them."""
    level = lit.stack.panel_length >= lit.stack.panel_width
    axes = ("vertical", "horizontal") if level else ("horizontal", "vertical")
    return {
        "lamps_level": level,
        "axes": dict(zip(("across", "along"), axes, strict=True)),
        "repeat": "the cell of an LED" if lit.is_cell else "a lamp pitch",
        "rim": _RIM if lit.is_finite else _NO_RIM.format("LEDs" if lit.is_cell else "lamps"),
    }
