"""What the report's sections on inputs and luminance show."""

from typing import Any

from mpfcad.record.traced import traced_films
from mpfcad.report.drawing.energy_figure import energy_figure
from mpfcad.report.drawing.plot import plot
from mpfcad.report.drawing.stack_drawing import draw_stack
from mpfcad.report.film.evidence import Evidence
from mpfcad.report.page.number import number

Record = dict[str, Any]


def input_values(evidence: Evidence) -> dict[str, Any]:
    """Return the drawing of the stack."""
    return {"drawing": draw_stack(evidence.stack)}


def chain_values(record: Record) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the steps from the job to the trace, each with (file, its SHA-256)."""
    provenance = record["provenance"]
    made, traced = provenance["sha256"], provenance["traced"]

    def files(*starts: str) -> list[tuple[str, str]]:
        return [(name, digest) for name, digest in made.items() if name.startswith(starts)]

    steps = [
        ("job and map", list(provenance["inputs_sha256"].items())),
        ("curvature", files("curvature.")),
        ("mask", [pair for pair in files("mask.") if not pair[0].endswith((".png", ".lyrdb"))]),
        ("CAD", files("film.")),
        ("traced", [(traced["file"], traced["sha256"])]),
    ]
    return [(step, found) for step, found in steps if found]


def luminance_values(record: Record) -> dict[str, Any]:
    """Return the figures of every trace, and their energy balances beside each other."""
    traces = {film.name: film.found for film in traced_films(record)}
    return {
        "traces": list(traces.items()),
        "flow": plot(energy_figure(record["energy"]), "energy") if record["energy"] else None,
        "energy_head": ["share of the lamps' light", *traces],
        "energy": _energy_rows([found["energy"] for found in traces.values()]),
    }


def _energy_rows(shares: list[dict[str, Any]], prefix: str = "") -> list[list[str]]:
    """Return the rows of several energy balances, those of each element among them."""
    rows: list[list[str]] = []
    for key in dict.fromkeys(key for share in shares for key in share):
        label = prefix + key.replace("_", " ")
        found = [share.get(key, "–") for share in shares]
        if any(isinstance(entry, dict) for entry in found):
            parts = [entry if isinstance(entry, dict) else {} for entry in found]
            rows += _energy_rows(parts, prefix=label + " ")
        else:
            rows.append([label, *(number(entry, 5) for entry in found)])
    return rows
