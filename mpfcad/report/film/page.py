"""The report: one self-contained HTML page that a person can decide from."""

from pathlib import Path
from typing import Any

from mpfcad.report.film.cad_section import cad_values
from mpfcad.report.film.confidence_section import confidence_values
from mpfcad.report.film.decision import decision_values
from mpfcad.report.film.evidence import Evidence
from mpfcad.report.film.mask_section import mask_values
from mpfcad.report.film.section import (
    chain_values,
    convergence_values,
    direction_values,
    input_values,
    luminance_values,
)
from mpfcad.report.film.slider_section import slider_values
from mpfcad.report.film.wording import gate_values, states_confidence
from mpfcad.report.page.colour_part import colour_part
from mpfcad.report.page.environment import render

#: Files that a run makes besides those whose hashes the record holds.
BESIDE = ("order.pdf", "coupons.csv")
#: Title and template of each section, in the page's order.
SECTIONS = (
    ("Every gate", "gate"),
    ("Backlight and inputs", "input"),
    ("Curvature, fill, aperture", "film"),
    ("Mask", "mask"),
    ("CAD files", "cad"),
    ("Light: directions, traces, energy", "luminance"),
    ("Confidence in the real backlight", "confidence"),
    ("Traceability", "traceability"),
)


def write_report(path: Path, record: dict[str, Any], evidence: Evidence) -> None:
    """Write the page; the same record and files give the same bytes."""
    path.write_bytes(build_page(record, evidence).encode())


def build_page(record: dict[str, Any], evidence: Evidence) -> str:
    """Return the page as HTML that needs no network."""
    versions = record["provenance"]["versions"]
    recovered = None
    if record["mask"]:
        recovered = next(iter(record["mask"]["curvature"]["recovered_per_mm"].values()))
    return render(
        "report.html.j2",
        record=record,
        sections=SECTIONS,
        decision=decision_values(record),
        gates=[gate_values(gate) for gate in record["gates"]],
        chain=chain_values(record),
        beside=[name for name in BESIDE if (evidence.folder / name).is_file()],
        versions=", ".join(f"{name} {value}" for name, value in versions.items()),
        input=input_values(record, evidence),
        film=evidence.kind.film_section(
            evidence.piece, evidence.position, evidence.aperture_ratio, recovered
        ),
        mask=mask_values(record, evidence),
        cad=cad_values(record, evidence),
        luminance=luminance_values(record),
        directions=direction_values(record, evidence),
        convergence=convergence_values(record),
        confidence=confidence_values(record),
        states_confidence=states_confidence(record),
        sliders=slider_values(record),
        colour=colour_part(record["colour"], record["inputs"]) if "colour" in record else None,
    )
