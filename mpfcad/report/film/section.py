"""What the report's sections on inputs and luminance show."""

from typing import Any

from mpfcad.record.traced import traced_films
from mpfcad.report.drawing.angle_figure import angular_figure, conoscope_figure
from mpfcad.report.drawing.convergence_figure import facets_figure, paths_figure
from mpfcad.report.drawing.energy_drawing import SOURCES, draw_energy
from mpfcad.report.drawing.plot import plot
from mpfcad.report.drawing.stack_drawing import draw_stack
from mpfcad.report.film.cell_section import cell_rows, way_words
from mpfcad.report.film.evidence import Evidence
from mpfcad.report.film.influence import assumed_rows
from mpfcad.report.film.wording import sources_of
from mpfcad.report.page.number import number, with_interval
from mpfcad.report.page.spread_part import spread_values

Record = dict[str, Any]


def input_values(record: Record, evidence: Evidence) -> dict[str, Any]:
    """Return the drawing of the stack, and what each assumed input would change."""
    return {"drawing": draw_stack(evidence.stack), "rows": assumed_rows(record, evidence.stack)}


def chain_values(record: Record) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return the steps from the job to this page, each with (file, its SHA-256)."""
    provenance = record["provenance"]
    made, traced = provenance["sha256"], provenance["traced"]

    def files(*starts: str) -> list[tuple[str, str]]:
        return [(name, digest) for name, digest in made.items() if name.startswith(starts)]

    steps = [
        ("job and map", list(provenance["inputs_sha256"].items())),
        ("curvature", files("curvature.", "curvature-crossed.")),
        (
            "mask",
            [
                pair
                for pair in files("mask.", "mask-crossed.")
                if not pair[0].endswith((".png", ".lyrdb"))
            ],
        ),
        ("CAD", files("film.", "film-crossed.")),
        ("traced", [(traced["file"], traced["sha256"])]),
    ]
    return [(step, found) for step, found in steps if found]


def direction_values(record: Record, evidence: Evidence) -> Record | None:
    """Return the polar map and the cuts; None where none were traced."""
    found = record.get("directions")
    if not found:
        return None
    level = evidence.stack.panel_length >= evidence.stack.panel_width
    axes = ("vertical", "horizontal") if level else ("horizontal", "vertical")
    error = max(max(row) for row in found["map"]["standard_error_cd_m2"])
    return {
        "map": plot(conoscope_figure(found["map"], level), "directions"),
        "cuts": plot(
            angular_figure(found["cut"], dict(zip(("across", "along"), axes, strict=True))), "cuts"
        ),
        "paths": found["paths"],
        "largest_error": f"{error:.0f}",
    }


def convergence_values(record: Record) -> Record:
    """Return how the contrast settled over the paths, and the mesh over its facets."""
    rows = record.get("facets")
    own = record["job"]["resolved"]["cad"]["angle_tolerance_deg"]
    return {
        "paths": plot(paths_figure(record), "paths") if record.get("convergence") else None,
        "facets": plot(facets_figure(rows, own), "facets") if rows else None,
    }


def luminance_values(record: Record) -> dict[str, Any]:
    """Return the figures of every trace, and their energy balances beside each other."""
    sources = sources_of(record)
    traces = {film.name: film.found for film in traced_films(record)}
    return {
        "traces": list(traces.items()),
        "pitches": _pitch_rows(record),
        "cell": cell_rows(record) if record.get("cell") else [],
        "way": way_words(record) if record.get("estimator") else "",
        "psf": spread_values(record["psf"]) if "psf" in record else None,
        "flow": draw_energy(record["energy"], sources) if record["energy"] else None,
        "energy_head": [f"share of the light of the {sources}", *traces],
        "energy": _energy_rows([found["energy"] for found in traces.values()], sources),
    }


def _pitch_rows(record: Record) -> list[list[str]]:
    """Return the contrast of each lamp pitch of a finite panel."""
    return [
        [
            "{:.1f} … {:.1f}".format(*one["from_to_mm"]),
            with_interval(one, 4),
            "yes" if one["judged"] else "no: in the rim",
        ]
        for one in record.get("pitches", [])
    ]


def _energy_rows(shares: list[dict[str, Any]], sources: str, prefix: str = "") -> list[list[str]]:
    """Return the rows of several energy balances, those of each element among them."""
    rows: list[list[str]] = []
    for key in dict.fromkeys(key for share in shares for key in share):
        label = prefix + (sources if key == SOURCES else key.replace("_", " "))
        found = [share.get(key, "–") for share in shares]
        if any(isinstance(entry, dict) for entry in found):
            parts = [entry if isinstance(entry, dict) else {} for entry in found]
            rows += _energy_rows(parts, sources, label + " ")
        else:
            rows.append([label, *(number(entry, 5) for entry in found)])
    return rows
