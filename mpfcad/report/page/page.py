"""The report: one self-contained HTML page that a person can decide from."""

from html import escape
from pathlib import Path
from typing import Any

from mpfcad.report.drawing.figure import PRINT_SCRIPT, plotly_script
from mpfcad.report.page.cad_section import cad_section
from mpfcad.report.page.evidence import Evidence
from mpfcad.report.page.section import (
    film_section,
    input_section,
    luminance_section,
    mask_section,
    traceability_section,
    verdict_section,
)
from mpfcad.report.page.style import STYLE


def write_report(path: Path, record: dict[str, Any], evidence: Evidence) -> None:
    """Write the page; the same record and files give the same bytes."""
    path.write_bytes(build_page(record, evidence).encode())


def build_page(record: dict[str, Any], evidence: Evidence) -> str:
    """Return the page as HTML that needs no network."""
    sections = (
        ("1 Verdict", verdict_section(record)),
        ("2 Traceability", traceability_section(record)),
        ("3 Inputs", input_section(record, evidence)),
        ("4 Curvature, fill, aperture", film_section(record, evidence)),
        ("5 Mask", mask_section(record, evidence)),
        ("6 CAD files", cad_section(record, evidence)),
        ("7 Luminance over the lamp pitch", luminance_section(record)),
    )
    body = "".join(f"<section><h2>{title}</h2>{content}</section>" for title, content in sections)
    name = escape(record["name"])
    version = escape(record["provenance"]["versions"]["mpfcad"])
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{record['verdict']}: {name}</title><style>{STYLE}</style>"
        f"<script>{plotly_script()}</script></head><body><main>"
        f'<h1>{name}</h1><p class="sub">Multi-performance film: verification report of mpfcad '
        f"{version}</p>{body}<footer>Lengths in mm, angles in degrees, luminance in cd/m². Every "
        f"figure of this page is in verification.json or curvature.csv.</footer></main>"
        f"<script>{PRINT_SCRIPT}</script></body></html>\n"
    )
