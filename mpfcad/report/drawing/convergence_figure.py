"""How figures settle: the contrast over the paths traced, a mesh's errors over its facets."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.report.drawing.figure import (
    BASE_COLOUR,
    FILM_BAND,
    FILM_COLOUR,
    THIRD_COLOUR,
    line,
    rounded,
    styled,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go


def paths_figure(record: dict[str, Any]) -> "go.Figure":
    """Return the contrast after each round of paths with its 95 % band, and the job's limits."""
    import plotly.graph_objects as go

    found, gate = record["convergence"], record["gates"][0]
    paths = rounded(np.array(found["paths"]) / 1e6, 4)
    low, high = np.array(found["ci95"]).T
    figure = go.Figure()
    figure.add_scatter(
        x=paths + paths[::-1], y=rounded([*high, *low[::-1]], 6), fill="toself",
        fillcolor=FILM_BAND, line={"width": 0}, mode="lines", hoverinfo="skip",
        name="95 % interval",
    )  # fmt: skip
    figure.add_scatter(
        x=paths, y=rounded(found["contrast"], 6), mode="lines+markers", name="contrast",
        marker={"size": 5}, line=line(FILM_COLOUR, 2),
        error_y={"array": rounded(high - found["contrast"], 6), "thickness": 0.7, "width": 2,
                 "arrayminus": rounded(found["contrast"] - low, 6)},
    )  # fmt: skip
    for name, colour in (("limit", THIRD_COLOUR), ("marginal_limit", BASE_COLOUR)):
        words = {"limit": "PASS", "marginal_limit": "MARGINAL"}[name]
        figure.add_scatter(
            x=[0.8 * paths[0], 1.25 * paths[-1]], y=[gate[name]] * 2, mode="lines",
            hoverinfo="skip", name=f"{words} ≤ {gate[name]:g}", line=line(colour, 1.5, "dot"),
        )  # fmt: skip
    figure.update_xaxes(title_text="paths [million]", **_ticks(paths))
    figure.update_yaxes(title_text="lamp-Mura contrast", rangemode="tozero")
    return styled(figure, 340)


def _ticks(values: list[float]) -> dict[str, Any]:
    """Return a logarithmic axis with ticks at 1, 2, 3, 5 and 7 times powers of ten."""
    low, high = np.log10(min(values)), np.log10(max(values))
    powers = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    ticks = [float(f"{n}e{power}") for power in powers for n in (1, 2, 3, 5, 7)]
    return {"type": "log", "tickvals": ticks, "ticktext": [f"{tick:g}" for tick in ticks]}


def facets_figure(rows: list[dict[str, Any]], own_tolerance: float) -> "go.Figure":
    """Return a mesh's largest angle and volume errors over the facets of a groove.

    The rows of the job's own tolerance [°] are marked.
    """
    from plotly.subplots import make_subplots

    figure = make_subplots(
        rows=1, cols=2, horizontal_spacing=0.12,
        subplot_titles=("largest error of a facet's normal [°]", "relative error of the volume"),
    )  # fmt: skip
    x = [round(row["facets_per_groove"], 2) for row in rows]
    own = [row["angle_tolerance_deg"] == own_tolerance for row in rows]
    for column, key in ((1, "normal_error_deg_max"), (2, "volume_error")):
        value = [float(f"{abs(row[key]):.5g}") for row in rows]
        figure.add_scatter(
            x=x, y=value, mode="lines+markers", line=line(BASE_COLOUR, 1.5), marker={"size": 6},
            name="other tolerances", showlegend=column == 1, row=1, col=column,
        )  # fmt: skip
        figure.add_scatter(
            x=[a for a, here in zip(x, own, strict=True) if here],
            y=[a for a, here in zip(value, own, strict=True) if here],
            mode="markers", marker={"size": 12, "color": FILM_COLOUR},
            name=f"film.stl: {own_tolerance:g}°", showlegend=column == 1, row=1, col=column,
        )  # fmt: skip
    figure.update_xaxes(title_text="facets of a groove", **_ticks(x))
    figure.update_yaxes(row=1, col=1, **_ticks([row["normal_error_deg_max"] for row in rows]))
    figure.update_yaxes(type="log", exponentformat="power", dtick=1, row=1, col=2)
    styled(figure, 340)
    figure.update_layout(hovermode="closest")
    return figure
