"""The page of a sweep: contrast and mean luminance over its axes."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.report.drawing.figure import styled
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import number, with_interval
from mpfcad.report.page.thickness_section import limit_words

if TYPE_CHECKING:
    import plotly.graph_objects as go

_COLOURS = ("#0b5fa5", "#b5541c", "#3f7f4f", "#8a6d3b", "#7a4d9f", "#c03a6b", "#4b8f99", "#555555")


def write_sweep_page(path: Path, record: dict[str, Any]) -> None:
    """Write the page; the same record gives the same bytes."""
    path.write_bytes(build_sweep_page(record).encode())


def build_sweep_page(record: dict[str, Any]) -> str:
    """Return the page as HTML that needs no network."""
    optima = record["optima"]
    return render(
        "sweep.html.j2",
        record=record,
        million_paths=f"{record['paths'] / 1e6:.1f}",
        limit=f"{record['sweep']['contrast_limit']:g}",
        curves=plot(curves_figure(record), "curves") if optima else None,
        optima=_optima(record) if optima else None,
        limits=[
            (_label(one["curve"]), " ".join(limit_words(one))) for one in record["thickness_limits"]
        ],
        points=_points(record),
    )


def _label(coordinate: dict[str, Any]) -> str:
    """Return a curve's name from the values that are its own."""
    words = [
        f"{axis.rpartition('.')[2]} {value:g}" if isinstance(value, float) else str(value)
        for axis, value in coordinate.items()
    ]
    return ", ".join(words) or "all"


def _optima(record: dict[str, Any]) -> dict[str, Any]:
    def ranges(found: list[list[float]]) -> str:
        return ", ".join(f"{low:.4g} … {high:.4g}" for low, high in found) or "none"

    rows = [
        [
            _label(one["curve"]),
            f"{one['optimum']:g}",
            with_interval(one["contrast"], 4),
            with_interval(one["mean_luminance_cd_m2"], 0),
            ranges(one["below_limit"]),
            ranges(one["certain_below_limit"]),
        ]
        for one in record["optima"]
    ]
    axis = record["optima"][0]["axis"].rpartition(".")[2]
    head = ("curve", f"best {axis}", "contrast there", "mean luminance [cd/m²]",
            f"{axis} below the limit", "certainly so (95 %)")  # fmt: skip
    return {"head": head, "rows": rows}


def _points(record: dict[str, Any]) -> dict[str, Any]:
    axes = list(record["sweep"]["axis"])
    rows = [
        [
            *(f"{v:g}" if isinstance(v, float) else v for v in one["coordinate"].values()),
            with_interval(one["lamp_mura_contrast"], 4),
            with_interval(one["mean_luminance_cd_m2"], 0),
            number(one["local_shift_mm"], 4),
            number(one["paths"]),
            one.get("screen") or "none: not printed",
            *_likely(one),
        ]
        for one in record["points"]
    ]
    head = (
        *(axis.rpartition(".")[2] for axis in axes),
        "contrast",
        "mean luminance [cd/m²]",
        "shift [mm]",
        "paths",
        "screen",
        *(["likely in the real backlight"] if "confidence" in record["points"][0] else []),
    )
    return {"head": head, "rows": rows, "numeric": range(len(axes), len(axes) + 4)}


def _likely(point: dict[str, Any]) -> list[str]:
    """Return how likely a point is within the limit and by what; nothing where not asked."""
    if "confidence" not in point:
        return []
    found = point["confidence"]
    first = [f"most by {one['name']}" for one in found["inputs"][:1]]
    return [", ".join([with_interval(found["probability"]["marginal"], 2), *first])]


def curves_figure(record: dict[str, Any]) -> "go.Figure":
    """Return contrast and mean luminance over the main axis, a curve for each of the others."""
    from plotly.subplots import make_subplots

    axis = record["optima"][0]["axis"]
    made = make_subplots(
        rows=1,
        cols=2,
        horizontal_spacing=0.1,
        subplot_titles=("lamp-Mura contrast", "mean normal luminance [cd/m²]"),
    )
    for index, optimum in enumerate(record["optima"]):
        curve = [
            one
            for one in record["points"]
            if json.dumps({k: v for k, v in one["coordinate"].items() if k != axis})
            == json.dumps(optimum["curve"])
        ]
        curve.sort(key=lambda one: one["coordinate"][axis])
        name, colour = _label(optimum["curve"]), _COLOURS[index % len(_COLOURS)]
        for column, key in ((1, "lamp_mura_contrast"), (2, "mean_luminance_cd_m2")):
            found = [one[key] for one in curve]
            made.add_scatter(
                x=[one["coordinate"][axis] for one in curve],
                y=[round(f["value"], 6) for f in found],
                error_y={
                    "type": "data",
                    "array": [round(f["ci95"][1] - f["value"], 6) for f in found],
                    "arrayminus": [round(f["value"] - f["ci95"][0], 6) for f in found],
                    "thickness": 1,
                },
                name=name,
                legendgroup=name,
                showlegend=column == 1,
                mode="lines+markers",
                line={"color": colour, "width": 2},
                row=1,
                col=column,
            )
    limit = {"color": "#777", "width": 1, "dash": "dot"}
    made.add_hline(record["sweep"]["contrast_limit"], line=limit, row=1, col=1)
    made.update_xaxes(title_text=axis)
    made.update_yaxes(rangemode="tozero", row=1, col=1)
    return styled(made, 440)
