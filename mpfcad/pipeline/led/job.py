"""The job of a map that a design for LEDs has found."""

import os
from pathlib import Path
from typing import Any

from mpfcad.export import write_text
from mpfcad.film import CurvatureSeries
from mpfcad.job import build_job
from mpfcad.job.led_design import LedDesign

#: Tables of a design that go into its job as they are.
_OWN = ("film", "process", "mask", "resin", "halftone")


def job_tables(design: LedDesign, found: CurvatureSeries) -> dict[str, Any]:
    """Return the document of the job of a map, its files as the design names them."""
    tables = design.model_dump(mode="json", by_alias=True, exclude_unset=True)
    limit = design.constraint
    cad: dict[str, Any] = {"levels": limit.levels}
    # Pieces of cells are cells; how finely a halftone is held hangs on its levelling.
    free = design.halftone is not None and "piece_mm" not in limit.model_fields_set
    if not design.has_cells and not free:
        cad["piece_mm"] = limit.piece_mm
    if limit.angle_tolerance_deg is not None:
        cad["angle_tolerance_deg"] = limit.angle_tolerance_deg
    return {
        "schema": 1,
        "name": design.name,
        # Another than the search's: the map was chosen by that one's noise.
        "seed": design.seed + 1,
        "map": {"series_per_mm": found.coefficient.tolist()},
        **({"crossed": {}} if design.films == 2 else {}),
        **{name: tables[name] for name in _OWN if name in tables},
        "cad": cad,
        "stack": dict(tables["stack"]),
    }


def write_job(
    path: Path, design: LedDesign, design_file: Path, stack: str, tables: dict[str, Any]
) -> None:
    """Write the job of `tables`; a stack's file is `stack` from beside the job."""
    import tomli_w

    document = {**tables, "stack": dict(tables["stack"])}
    if design.stack.file:
        document["stack"]["file"] = stack
    calibration = document.get("process", {}).get("calibration")
    if calibration is not None:
        document["process"] = dict(document["process"])
        document["process"]["calibration"] = os.path.relpath(
            design_file.parent / calibration, path.parent
        )
    build_job(document, str(design_file))
    head = f"# Found by mpfcad design {design_file.name}\n# mpfcad run {path.name}\n"
    write_text(path, head + tomli_w.dumps(document))
