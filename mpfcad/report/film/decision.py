"""What decides: the verdict, the contrast on a scale, how the films look, what is assumed."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.record.traced import comparison_words, traced_films
from mpfcad.report.drawing.angle_figure import cell_figure
from mpfcad.report.drawing.figure import luminance_figure
from mpfcad.report.drawing.plot import plot
from mpfcad.report.drawing.strip import (
    PITCHES,
    ROWS,
    common_reach,
    deviation_strip,
    scale_strip,
    seen_strip,
    strip_of,
)
from mpfcad.report.film.wording import label_of, verdict_sentence

if TYPE_CHECKING:
    import plotly.graph_objects as go

Record = dict[str, Any]
#: The scale of contrasts holds so much of the wider limit, this film's interval with some room, and
#: the other films' as far as the limits can still be told apart.
_LIMITS_SHOWN, _ROOM, _MOST = 1.5, 1.05, 4.0
#: Inputs named in a line of what is assumed.
_NAMED = 6


def decision_values(record: Record) -> Record:
    """Return what the first page shows."""
    films = [(film.words, film.found) for film in traced_films(record)]
    return {
        "sentence": verdict_sentence(record),
        "others": _other_gates(record),
        "figures": _figures(record),
        "notes": _notes(record),
        "scale": scale_values(record, _with_widths(record, films)),
        "sure": _sure(record.get("confidence")),
        "strips": strip_values(films),
        "luminance": plot(_luminance(record), "luminance"),
        "luminance_words": _luminance_words(record),
        "limit_percent": f"{record['gates'][0]['limit'] * 100:g}",
        "assumed": _assumed(record),
    }


def _luminance(record: Record) -> "go.Figure":
    """Return the luminance over the pitch, or over a cell of LEDs."""
    return cell_figure(record["cell"]) if record.get("cell") else luminance_figure(record)


def _notes(record: Record) -> list[str]:
    """Return what is compared with what, of a finite panel where its contrast is, and notes."""
    judged = record.get("judged")
    own = [f"{note}." for note in record.get("notes", ())]
    if not judged:
        return [comparison_words(record), *own]
    place = f"Contrast: {judged['words']}. Luminance, pictures and curves: the panel's middle."
    return [place, comparison_words(record), *own]


def _luminance_words(record: Record) -> str:
    """Return what stands under that figure."""
    if record.get("cell"):
        return "Luminance over one cell of LEDs over its mean, an LED in the middle."
    limit = f"{record['gates'][0]['limit'] * 100:g}"
    which = "the lamp pitch in the panel's middle" if record.get("judged") else "one lamp pitch"
    return (
        f"Luminance over {which} with its 95 % band, and each curve over its own mean; the "
        f"dotted lines stand at ± {limit} %."
    )


def _with_widths(record: Record, films: list[tuple[str, Record]]) -> list[tuple[str, Record]]:
    """Return the films, this one once more with all inputs' widths where these are known."""
    found, words = record.get("confidence"), "this film, with all widths"
    if not found:
        found, words = record.get("printed"), "this film, as printed"
    if not found:
        return films
    return [
        films[0],
        (words, {"lamp_mura_contrast": found["contrast"]}),
        *films[1:],
    ]


def _sure(found: Record | None) -> Record | None:
    """Return how likely the limits are met, what that hangs on, and what to measure next."""
    if not found:
        return None
    return {
        "limits": [
            {
                "limit": f"{one['limit']:g}",
                "likely": f"{one['value']:.0%}",
                "range": f"{one['ci95'][0]:.0%} … {one['ci95'][1]:.0%}",
            }
            for one in found["probability"].values()
        ],
        "inputs": [
            {
                "name": one["name"],
                "width": f"± {one['sigma']:.3g}",
                "share": round(100 * one["share_of_variance"], 1),
            }
            for one in found["inputs"][:_NAMED]
        ],
        "next": found["measure_next"][0] if found["measure_next"] else None,
    }


def _other_gates(record: Record) -> Record:
    others = record["gates"][1:]
    missed = [gate for gate in others if gate["outcome"] != "PASS"]
    return {
        "count": len(others),
        "missed": [(label_of(gate["name"]), gate["outcome"]) for gate in missed],
    }


def _figures(record: Record) -> list[tuple[str, str, str]]:
    """Return (what, value, its 95 % interval) of the figures that a reader looks for first."""
    contrast, mean = record["lamp_mura_contrast"], record["mean_luminance_cd_m2"]
    if contrast is None:
        return [("lamp-Mura contrast", "not traced", record["gates"][0].get("detail", ""))]
    return [
        (
            "lamp-Mura contrast",
            f"{contrast['value']:.4f}",
            f"95 %: {contrast['ci95'][0]:.4f} … {contrast['ci95'][1]:.4f}",
        ),
        (
            "mean normal luminance",
            f"{mean['value']:.0f} cd/m²",
            f"95 %: {mean['ci95'][0]:.0f} … {mean['ci95'][1]:.0f}",
        ),
        (
            "share of the baseline's luminance",
            f"{record['relative_luminance'] * 100:.1f} %",
            f"{record['baseline']['mean_luminance_cd_m2']['value']:.0f} cd/m²",
        ),
    ]


def scale_values(record: Record, films: list[tuple[str, Record]]) -> Record:
    """Return limits, threshold and intervals of (name, trace) as percent of the scale's length."""
    gate = record["gates"][0]
    widest = max(found["lamp_mura_contrast"]["ci95"][1] for _, found in films)
    end = max(
        _LIMITS_SHOWN * gate["marginal_limit"],
        min(_ROOM * widest, _MOST * gate["marginal_limit"]),
        _ROOM * (gate["ci95"] or (0, 0))[1],
    )

    def place(value: float) -> float:
        return round(100 * min(max(value / end, 0.0), 1.0), 3)

    rows = []
    for name, found in films:
        contrast = found["lamp_mura_contrast"]
        low, high = contrast["ci95"]
        rows.append(
            {
                "name": name,
                "words": f"{contrast['value']:.4f} [{low:.4f}, {high:.4f}]",
                "left": place(low),
                "width": round(max(place(high) - place(low), 0.4), 3),
                "at": place(contrast["value"]),
                "beyond": low > end,
            }
        )
    marks = [
        {"words": f"PASS ≤ {gate['limit']:g}", "at": place(gate["limit"])},
        {"words": f"MARGINAL ≤ {gate['marginal_limit']:g}", "at": place(gate["marginal_limit"])},
    ]
    eye = record.get("eye")
    seen = None
    if eye:
        seen = {
            "at": place(eye["threshold_contrast"]),
            "value": f"{eye['threshold_contrast']:.4f}",
            "pitch": f"{eye['stripe_pitch_mm']:g}",
            "distance": f"{eye['viewing_distance_mm'] / 1000:g}",
            "luminance": f"{eye['luminance_at_eye_cd_m2']:.0f}",
        }
    over = "one cell of LEDs" if record.get("cell") else "one lamp pitch"
    return {"end": f"{end:.3g}", "rows": rows, "marks": marks, "eye": seen, "over": over}


def strip_values(films: list[tuple[str, Record]]) -> Record:
    """Return pictures of several (name, trace) on common scales."""
    curves = [strip_of(found) for _, found in films]
    is_cell = any("cell" in found for _, found in films)
    white, reach = 1.05 * max(float(np.max(curve)) for curve in curves), common_reach(curves)
    rows = [
        {
            "name": name,
            "seen": seen_strip(curve, white),
            "deviation": deviation_strip(curve, reach),
            "range": f"{curve.min():.0f} … {curve.max():.0f} cd/m²",
        }
        for (name, _), curve in zip(films, curves, strict=True)
    ]
    return {
        "rows": rows,
        "white": f"{white:.0f}",
        "reach": f"{reach * 100:.3g}",
        "scale": scale_strip(),
        # Cells are shown in proportion; a strip of stripes is as high as one likes.
        "style": "height:auto" if is_cell else "",
        "words": _strip_words(is_cell, any(found.get("judged") for _, found in films)),
    }


def _strip_words(is_cell: bool, is_panel: bool) -> str:
    """Return what the strips show."""
    if is_cell:
        return f"{PITCHES} × {ROWS} cells of LEDs, from the fitted series"
    if is_panel:
        return "The lamp pitch in the panel's middle, made from the curve below"
    return f"{PITCHES} lamp pitches, made from the curve below: one pitch, repeated"


def _assumed(record: Record) -> list[tuple[str, str]]:
    """Return what is assumed, a line each of backlight, print, and the rest of the job."""
    stack = [entry for entry in record["inputs"] if entry["name"].startswith("stack.")]
    assumed = [entry["name"].removeprefix("stack.") for entry in stack if _is_assumed(entry)]
    words = f"{len(assumed)} of {len(stack)} values are assumed, not measured"
    lines = [("Backlight", words + _listed(assumed))]
    if record["process"]:
        lines.append(("Printing process", _process_words(record)))
    else:
        lines.append(("Printing process", "none: this film is not printed."))
    rest = [
        entry["name"]
        for entry in record["inputs"]
        if _is_assumed(entry) and not entry["name"].startswith(("stack.", "process."))
    ]
    lines.append(("Mask and CAD", f"{len(rest)} values of the job are defaults" + _listed(rest)))
    return lines


def _process_words(record: Record) -> str:
    """Return what the process is known by, and how well it sets C."""
    caveats = record["process"]["caveats"]
    words = caveats[0] if caveats else "calibrated"
    half = (record.get("printing") or {}).get("curvature_half_width_per_mm")
    if half:
        words += f"; it sets C to ± {half:.2g} /mm (95 %)"
    computed = (record.get("printing") or {}).get("mesh_computed")
    if computed:
        words += f"; {computed} of its mesh are computed, not a weaver's figures"
    return words + "."


def _listed(names: list[str]) -> str:
    """Return the first names after a colon, and how many more there are."""
    if not names:
        return "."
    more = len(names) - _NAMED
    return f": {', '.join(names[:_NAMED])}" + (f" and {more} more." if more > 0 else ".")


def _is_assumed(entry: Record) -> bool:
    return entry["tag"] == "assumed"
