"""Figures of luminance over direction, pitch and panel, for the measurements' pages."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.measure import reach
from mpfcad.report.drawing.figure import (
    FILM_COLOUR,
    FINE,
    THIRD_COLOUR,
    fitted_curve,
    line,
    place_map,
    rounded,
    styled,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go

_SHOWN_DEG = 80
_GRID = 161


def angular_figure(
    angular: dict[str, Any], axes: dict[str, str], beside: str = "lamps"
) -> "go.Figure":
    """Return luminance over the viewing angle, across and along the lamps, with its 95 % band.

    Under LEDs it is `beside` the grooves.
    """
    colours = {"across": FILM_COLOUR, "along": THIRD_COLOUR}
    return angular_overlay(
        [
            (f"{axes[plane]}: {plane} the {beside}", angular[plane], colour)
            for plane, colour in colours.items()
        ]
    )


def angular_overlay(curves: list[tuple[str, dict[str, Any], str]]) -> "go.Figure":
    """Return the angular curves of several (name, curve, colour) over each other."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for name, curve, colour in curves:
        error = reach(curve["degrees_of_freedom"]) * np.array(curve["standard_error_cd_m2"])
        figure.add_scatter(
            x=curve["angle_deg"], y=rounded(curve["luminance_cd_m2"], 2),
            error_y={"array": rounded(error, 2), "thickness": 1, "width": 2},
            name=name, mode="lines+markers", marker={"size": 4}, line=line(colour, 2),
        )  # fmt: skip
    figure.update_xaxes(title_text="from the normal [°]", range=[-82, 82], dtick=20)
    figure.update_yaxes(title_text="luminance [cd/m²]", rangemode="tozero")
    return styled(figure, 400)


def conoscope_figure(conoscope: dict[str, Any], lamps_level: bool) -> "go.Figure":
    """Return the conoscopic map as the screen's viewer sees it: radius is the polar angle."""
    import plotly.graph_objects as go

    axis = np.linspace(-_SHOWN_DEG, _SHOWN_DEG, _GRID)
    right, up = np.meshgrid(axis, axis)
    # Azimuth 0 is across the lamps: up the screen where they lie level.
    across, along = (up, right) if lamps_level else (right, up)
    polar = np.hypot(across, along)
    shown = _on_map(conoscope, polar, np.degrees(np.arctan2(along, across)) % 360)
    shown[polar > _SHOWN_DEG] = np.nan
    rows = [[None if np.isnan(v) else round(float(v), 1) for v in row] for row in shown]
    figure = go.Figure(
        go.Contour(
            x=axis,
            y=axis,
            z=rows,
            colorscale="Viridis",
            ncontours=16,
            contours={"coloring": "heatmap"},
            line={"width": 0.6, "color": "rgba(255,255,255,.6)"},
            colorbar={"title": {"text": "cd/m²"}},
            hovertemplate="right %{x}°, up %{y}°: %{z} cd/m²<extra></extra>",
        )
    )
    for ring in (20, 40, 60, 80):
        turn = np.radians(np.arange(0, 361, 4))
        figure.add_scatter(
            x=rounded(ring * np.cos(turn), 3), y=rounded(ring * np.sin(turn), 3), mode="lines",
            line=line("rgba(60,60,60,.55)", 1, "dot"), hoverinfo="skip", showlegend=False,
        )  # fmt: skip
        figure.add_annotation(
            x=0, y=ring, text=f"{ring}°", showarrow=False, yshift=7, font={"size": 10}
        )
    styled(figure, 560)
    hidden = {"showgrid": False, "visible": False, "range": [-88, 88]}
    figure.update_xaxes(**hidden)
    figure.update_yaxes(scaleanchor="x", **hidden)
    figure.update_layout(hovermode="closest", margin={"l": 20, "r": 20, "t": 20, "b": 20})
    return figure


def _on_map(conoscope: dict[str, Any], polar: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Return the luminance between the map's points, straight in polar angle and azimuth."""
    rings, spokes = conoscope["polar_deg"], conoscope["azimuth_deg"]
    value = np.array(conoscope["luminance_cd_m2"])
    value = np.c_[value, value[:, 0]]
    i = np.clip(polar / rings[1], 0, len(rings) - 1.001)
    k = azimuth / spokes[1]
    i0, k0 = i.astype(int), k.astype(int)
    p, q = i - i0, k - k0
    low = value[i0, k0] * (1 - q) + value[i0, k0 + 1] * q
    high = value[i0 + 1, k0] * (1 - q) + value[i0 + 1, k0 + 1] * q
    return low * (1 - p) + high * p


def panel_figure(panel: dict[str, Any], lamps_level: bool) -> "go.Figure":
    """Return the panel's map as it lies on the screen."""
    value = np.array(panel["luminance_cd_m2"])
    across, along = rounded(panel["across_mm"], 3), rounded(panel["along_mm"], 3)
    x, y, shown = (along, across, value) if lamps_level else (across, along, value.T)
    rows, bar = [rounded(row, 1) for row in shown], {"title": {"text": "cd/m²"}}
    return place_map(x, y, rows, bar, "%{z} cd/m²", ("[mm]", "[mm]"))


def cell_figure(cell: dict[str, Any]) -> "go.Figure":
    """Return the luminance over a cell of LEDs over its mean, the cell's middle at 0."""
    value = np.array(cell["luminance_cd_m2"])
    bins = (np.arange(len(value)) + 0.5) / len(value) - 0.5
    x, y = (rounded(bins * cell[side], 3) for side in ("across_mm", "along_mm"))
    rows = [rounded(row, 4) for row in (value / value.mean() - 1).T]
    return place_map(x, y, rows, {"title": {"text": "over mean − 1"}}, "%{z}")


def pitch_figure(curves: list[tuple[str, dict[str, Any], str]]) -> "go.Figure":
    """Return luminance over the pitch of several (name, contrast record, colour), over its mean."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for name, found, colour in curves:
        mean = found["mean_luminance_cd_m2"]["value"]
        curve = found["luminance"]
        value = np.array(curve["luminance_cd_m2"]) / mean - 1
        error = np.array(curve["standard_error_cd_m2"]) / mean
        error *= reach(found["degrees_of_freedom"])
        fit = fitted_curve(found, FINE) / mean - 1
        figure.add_scatter(
            x=rounded(FINE, 5), y=rounded(fit * 100, 4), mode="lines", name=name,
            line=line(colour, 2), legendgroup=name, hoverinfo="skip",
        )  # fmt: skip
        figure.add_scatter(
            x=rounded(curve["position_pitch"], 5), y=rounded(value * 100, 4), mode="markers",
            error_y={"array": rounded(error * 100, 4), "thickness": 0.7, "width": 2},
            marker={"size": 4, "color": colour}, name=name, legendgroup=name, showlegend=False,
        )  # fmt: skip
    figure.update_xaxes(title_text="position [lamp pitch]; lamps at 0 and 1", range=[0, 1])
    figure.update_yaxes(title_text="luminance over its mean [%]")
    return styled(figure, 400)
