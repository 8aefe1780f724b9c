"""The page of `mpfcad judge`: a measured luminance, its verdict, and the prediction beside it."""

from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.report.drawing.angle_figure import cell_figure
from mpfcad.report.drawing.figure import BASE_COLOUR, FILM_COLOUR, line, rounded, styled
from mpfcad.report.drawing.plot import Plot, plot
from mpfcad.report.page.environment import render

Record = dict[str, Any]


def write_judge_page(path: Path, record: Record) -> None:
    """Write the page; the same record gives the same bytes."""
    gate = record["gates"][0]
    page = render(
        "judge.html.j2",
        record=record,
        gate=gate,
        percent=[100 * gate["limit"], 100 * gate["marginal_limit"]],
        plots=_plots(record),
        rows=_rows(record),
    )
    path.write_bytes(page.encode())


def _rows(record: Record) -> list[tuple[str, Record, int, str]]:
    contrast = "lamp-Mura contrast (L_{max} − L_{min})/(L_{max} + L_{min})"
    rows = [(contrast, record["lamp_mura_contrast"], 3)]
    if record["kind"] == "stripes":
        each = record["lamp_mura_contrast_of_pitches"]
        rows += [(f"the same of pitch {i}", found, 3) for i, found in enumerate(each, 1)]
        rows += [
            (f"harmonic {i} of the pitch / mean", found, 3)
            for i, found in enumerate(record["harmonic_amplitude"], 1)
        ]
        rows.append(("L_{min}/L_{max} on 9 points", record["uniformity_9_points"], 4))
    else:
        rows += [
            (f"harmonic {name.replace('_', ' ')} / mean", found, 3)
            for name, found in record["harmonic_amplitude"].items()
        ]
    rows += [
        ("σ / mean", record["sigma_over_mean"], 3),
        ("mean luminance [cd/m²]", record["mean_luminance_cd_m2"], 5),
    ]
    return [(*row, "–") for row in rows]


def _plots(record: Record) -> list[Plot]:
    if record["kind"] == "spots":
        plots = [plot(cell_figure(record["cell"]), "cell")]
        if "against" in record:
            off = {**record["cell"], "luminance_cd_m2": 1 + np.array(record["against"]["residual"])}
            plots.append(plot(cell_figure(off), "difference"))
        return plots
    plots = [plot(_curve_figure(record), "curve")]
    if "against" in record:
        plots.append(plot(_difference_figure(record["against"]), "difference"))
    return plots


def _curve_figure(record: Record) -> Any:
    """Return the measured luminance over its mean, pitch by pitch."""
    import plotly.graph_objects as go

    curve, mean = record["luminance"], record["mean_luminance_cd_m2"]["value"]
    figure = go.Figure()
    figure.add_scatter(
        x=rounded(curve["position_pitch"], 5),
        y=rounded(np.array(curve["luminance_cd_m2"]) / mean * 100 - 100, 4),
        error_y={"array": rounded(1.96 * np.array(curve["standard_error_cd_m2"]) / mean * 100, 4),
                 "thickness": 0.7, "width": 2},
        mode="lines+markers", marker={"size": 4, "color": FILM_COLOUR},
        line=line(FILM_COLOUR, 1.5), name="measured",
    )  # fmt: skip
    figure.update_xaxes(title_text="position [lamp pitch]")
    figure.update_yaxes(title_text="luminance over its mean [%]")
    return styled(figure, 380)


def _difference_figure(against: Record) -> Any:
    """Return measured and predicted curve over their means, and their difference."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=1, cols=2, horizontal_spacing=0.1, subplot_titles=(
        "over its own mean [%]", "measured − predicted [%]"))  # fmt: skip
    x = rounded(against["position_pitch"], 5)
    for name, colour in (("measured", FILM_COLOUR), ("predicted", BASE_COLOUR)):
        value = np.array(against[f"{name}_over_mean"]) * 100 - 100
        figure.add_scatter(x=x, y=rounded(value, 4), mode="lines", name=name,
                           line=line(colour, 2), row=1, col=1)  # fmt: skip
    figure.add_scatter(
        x=x, y=rounded(np.array(against["residual"]) * 100, 4), mode="lines+markers",
        error_y={"array": rounded(196 * np.array(against["residual_standard_error"]), 4)},
        line=line(FILM_COLOUR, 1.5), name="difference", showlegend=False, row=1, col=2,
    )  # fmt: skip
    figure.update_xaxes(title_text="position [lamp pitch]; lamps at 0 and 1", range=[0, 1])
    return styled(figure, 380)
