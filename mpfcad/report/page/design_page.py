"""The page of a design: every map that was traced, what it gave, and what it cost."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.report.drawing.figure import FINE, styled
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import number, with_interval
from mpfcad.report.page.thickness_section import thickness_values

if TYPE_CHECKING:
    import plotly.graph_objects as go

_CHOSEN, _OTHER = "#0b5fa5", "#b9c4cf"


def write_design_page(path: Path, record: dict[str, Any]) -> None:
    """Write the page; the same record gives the same bytes."""
    path.write_bytes(build_design_page(record).encode())


def build_design_page(record: dict[str, Any]) -> str:
    """Return the page as HTML that needs no network."""
    return render(
        "design.html.j2",
        record=record,
        result=_result(record),
        thickness=record["thickness"] and thickness_values(record["thickness"]),
        likely=record["confidence"] and _likely(record["confidence"]),
        curves=plot(curves_figure(record), "curves"),
        progress=plot(progress_figure(record), "progress"),
        iterations=_iterations(record),
        method=_method(record),
    )


def _result(record: dict[str, Any]) -> list[tuple[str, str]]:
    best = record["iterations"][record["chosen"]]
    rows = np.array(best["curvature_per_mm"])
    facts = [
        ("backlight", f"{record['stack']['title']}; {record['thickness_mm']:g} mm"),
        ("chosen map", f"{best['label']}: C {rows.min():.2f} … {rows.max():.2f} /mm"),
        ("lamp-Mura contrast, traced", with_interval(best["lamp_mura_contrast"], 4)),
        ("mean normal luminance [cd/m²]", with_interval(best["mean_luminance_cd_m2"], 0)),
        ("paths of all traces", f"{record['paths'] / 1e6:.2f} million"),
    ]
    if record.get("screen"):
        facts.append(("screen that the map is limited to", str(record["screen"])))
    if record["model"]:
        model = record["model"]
        facts.append(
            (
                "short traces for the model",
                f"{model['film_passages'] / 1e6:.2f} million through the film alone, "
                f"{model['world_segments'] / 1e6:.2f} million from the film back to it",
            )
        )
    if record["reach"]:
        facts.append(("luminance between the lamps over that above, found with C in its range",
                      _reach_words(record["reach"])))  # fmt: skip
    return facts


def _reach_words(reach: dict[str, Any]) -> str:
    """Return the extremes that the model gives, and the trace that proves the nearer one."""
    low, high = reach["luminance_ratio"]
    words = f"{low:.4f} … {high:.4f} by the corrected model"
    if low <= 1 <= high:
        words += ": they can be made equal"
    if reach["traced"]:
        words += f"; the map of that extreme, traced: {reach['traced']['luminance_ratio']:.4f}"
    if reach["free_contrast"] is not None:
        words += (
            f". Least contrast found for a map of 10 harmonics that may change as steeply as it "
            f"likes: {reach['free_contrast']:.4f}"
        )
    if reach["contrast_bound"] is not None:
        words += (
            f". No map that is the same on both sides of the lamp, steep or not, has a contrast "
            f"below {reach['contrast_bound']:.4f}: a bound over all of them, by the corrected model"
        )
    return words


def _likely(found: dict[str, Any]) -> dict[str, Any]:
    """Return both designs beside each other, and what the model has promised."""
    rows = []
    for name in ("nominal", "confidence"):
        one = found[name]
        rows.append(
            [
                f"{name}: {one['label']}" + (" (chosen)" if name == found["chosen"] else ""),
                *(with_interval(one["probability"][key], 2) for key in ("pass", "marginal")),
                with_interval(one["contrast"], 4),
                f"{one['traced_within']} of {found['traced_draws']}",
                f"{np.mean(one['traced_contrast']):.4f}",
            ]
        )
    limits = found["nominal"]["probability"]
    head = [
        "design",
        *(f"likely at most {limits[key]['limit']:g}" for key in ("pass", "marginal")),
        "contrast with all widths, median and 95 % range",
        f"traced draws at most {limits['marginal']['limit']:g}",
        "their mean contrast",
    ]
    share = [f"{value:.2f}" for value in found["predicted_share"]]
    return {"head": head, "rows": rows, "share": share}


def _iterations(record: dict[str, Any]) -> dict[str, Any]:
    rows, spent = [], 0
    moved = record["design"]["constraint"]["registration_mm"]
    for one in record["iterations"]:
        spent += one["paths"]
        curvature, predicted = one["curvature_per_mm"], one["predicted"]
        rows.append(
            [
                one["label"],
                f"{min(curvature):.2f} … {max(curvature):.2f}",
                "–" if predicted is None else f"{predicted['lamp_mura_contrast']:.4f}",
                with_interval(one["lamp_mura_contrast"], 4),
                with_interval(one["mean_luminance_cd_m2"], 0),
                number(spent / 1e6, 4),
            ]
        )
        if moved:
            shifted = one["shifted_lamp_mura_contrast"]
            rows[-1].append("–" if shifted is None else with_interval(shifted, 4))
    head = ["", "C [1/mm]", "contrast: model", "traced [95 %]", "mean luminance [cd/m²]",
            "paths so far [million]"]  # fmt: skip
    if moved:
        head.append(f"shifted {moved:g} mm, traced")
    return {"head": head, "rows": rows}


def _method(record: dict[str, Any]) -> list[tuple[str, str]]:
    design, constraint = record["design"], record["constraint"]
    shown = {
        "method": design["search"]["method"],
        "aim": design["goal"]["aim"],
        "contrast_target": design["goal"]["contrast_target"],
        "profile": design["film"]["profile"],
        "smallest and largest C [1/mm]": f"{constraint['curvature_min_per_mm']:.4g} … "
        f"{constraint['curvature_max_per_mm']:.4g}",
        "largest change [1/mm per mm]": constraint["change_max_per_mm2"],
        "harmonics": design["constraint"]["harmonics"],
        "levels": design["constraint"]["levels"] or "any",
        "shift to be borne [mm]": design["constraint"]["registration_mm"],
        "seed": design["seed"],
    }
    return [(name, str(value)) for name, value in shown.items()]


def curves_figure(record: dict[str, Any]) -> "go.Figure":
    """Return the maps, and the luminance of each over its mean."""
    from plotly.subplots import make_subplots

    made = make_subplots(
        rows=1,
        cols=2,
        horizontal_spacing=0.1,
        subplot_titles=("curvature C [1/mm]", "luminance over its own mean [%]"),
    )
    for index, one in enumerate(record["iterations"]):
        chosen = index == record["chosen"]
        line = {"color": _CHOSEN if chosen else _OTHER, "width": 3 if chosen else 1.5}
        shared = {"name": one["label"], "legendgroup": one["label"], "mode": "lines", "line": line}
        curvature = np.array(one["curvature_per_mm"])
        position = np.linspace(0, 1, len(curvature))
        made.add_scatter(
            x=position.round(6).tolist(), y=curvature.round(4).tolist(), row=1, col=1, **shared
        )
        value = (_series(one["fit_coefficient_cd_m2"]) - 1) * 100
        made.add_scatter(
            x=FINE.round(6).tolist(),
            y=value.round(4).tolist(),
            row=1,
            col=2,
            showlegend=False,
            **shared,
        )
    made.update_xaxes(title_text="position [lamp pitch]; lamps at 0 and 1", range=[0, 1])
    return styled(made, 400)


def _series(coefficient: list[float]) -> np.ndarray:
    """Return a Fourier series over its mean at the positions `FINE`."""
    value = np.ones_like(FINE)
    for h in range(1, len(coefficient) // 2 + 1):
        angle = 2 * np.pi * h * FINE
        value += coefficient[2 * h - 1] / coefficient[0] * np.cos(angle)
        value += coefficient[2 * h] / coefficient[0] * np.sin(angle)
    return value


def progress_figure(record: dict[str, Any]) -> "go.Figure":
    """Return the contrast of every traced map over the paths spent."""
    import plotly.graph_objects as go

    done = record["iterations"]
    contrast = [one["lamp_mura_contrast"] for one in done]
    value = np.array([c["value"] for c in contrast])
    low, high = np.array([c["ci95"] for c in contrast]).T
    made = go.Figure()
    made.add_scatter(
        x=np.cumsum([one["paths"] / 1e6 for one in done]).round(4).tolist(),
        y=value.round(6).tolist(),
        error_y={
            "type": "data",
            "array": (high - value).round(6).tolist(),
            "arrayminus": (value - low).round(6).tolist(),
        },
        text=[one["label"] for one in done],
        mode="lines+markers",
        marker={"size": 8, "color": _CHOSEN},
        line={"color": _OTHER},
        name="traced",
        showlegend=False,
    )
    target = record["design"]["goal"]["contrast_target"]
    made.add_hline(target, line={"color": "#777", "width": 1, "dash": "dot"})
    made.update_xaxes(title_text="paths traced [million]", rangemode="tozero")
    made.update_yaxes(title_text="lamp-Mura contrast", rangemode="tozero")
    return styled(made, 340)
