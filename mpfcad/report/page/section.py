"""What the report's sections on verdict, inputs and luminance show."""

from typing import Any

from mpfcad.report.drawing.figure import luminance_figure
from mpfcad.report.drawing.plot import plot
from mpfcad.report.drawing.stack_drawing import draw_stack
from mpfcad.report.page.evidence import Evidence
from mpfcad.report.page.number import number
from mpfcad.report.page.wording import gate_values, verdict_words

Record = dict[str, Any]


def verdict_values(record: Record) -> dict[str, Any]:
    """Return the verdict in words, and what stands in the line of each gate."""
    return {
        "words": verdict_words(record),
        "gates": [gate_values(gate) for gate in record["gates"]],
    }


def input_values(evidence: Evidence) -> dict[str, Any]:
    """Return the drawing of the stack."""
    return {"drawing": draw_stack(evidence.stack)}


def luminance_values(record: Record) -> dict[str, Any]:
    """Return luminance over the pitch, against the conventional stack, and the energy balance."""
    base = record["baseline"]
    return {
        "plot": plot(luminance_figure(record), "luminance"),
        "limit_percent": f"{record['gates'][0]['limit'] * 100:g}",
        "traces": [(record["name"], record), ("conventional", base)],
        "energy": _energy_rows(record["energy"], base["energy"]),
    }


def _energy_rows(here: dict[str, Any], there: dict[str, Any], prefix: str = "") -> list[list[str]]:
    """Return the rows of two energy balances, those of each element among them."""
    rows: list[list[str]] = []
    for key in dict.fromkeys([*here, *there]):
        label = prefix + key.replace("_", " ")
        pair = (here.get(key, "–"), there.get(key, "–"))
        if isinstance(pair[0], dict):
            rows += _energy_rows(*pair, prefix=label + " ")
        else:
            rows.append([label, number(pair[0], 5), number(pair[1], 5)])
    return rows
