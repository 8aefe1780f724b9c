"""The curves of the report, as plotly figures; their ids are fixed so that the bytes are too."""

from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mpfcad.measure import reach
from mpfcad.record.traced import BASELINE, PLAIN, THIS, traced_films

if TYPE_CHECKING:
    import plotly.graph_objects as go

FILM_COLOUR, BASE_COLOUR, THIRD_COLOUR = "#0b5fa5", "#8a6d3b", "#3f7f4f"
FOURTH_COLOUR, FIFTH_COLOUR = "#c03a6b", "#7a4d9f"
FILM_BAND, BASE_BAND = "rgba(11,95,165,0.18)", "rgba(138,109,59,0.18)"
THIRD_BAND = "rgba(63,127,79,0.14)"
#: Colours of each traced film: its line and its 95 % band.
_DRESS = {
    THIS: (FILM_COLOUR, FILM_BAND),
    PLAIN: (THIRD_COLOUR, THIRD_BAND),
    BASELINE: (BASE_COLOUR, BASE_BAND),
}
#: Signs in a line of a label.
LABEL = 34
#: Positions [pitch] at which the fitted curves are drawn.
FINE = np.linspace(0, 1, 129)


def luminance_figure(record: dict[str, Any]) -> "go.Figure":
    """Return luminance over the pitch: absolute, and each curve over its own mean."""
    from plotly.subplots import make_subplots

    figure = make_subplots(
        rows=1,
        cols=2,
        horizontal_spacing=0.1,
        subplot_titles=("normal luminance [cd/m²]", "over its own mean [%]"),
    )
    for place, name, _, found in traced_films(record):
        curve = found["luminance"]
        x = np.array(curve["position_pitch"])
        value = np.array(curve["luminance_cd_m2"])
        error = reach(found["degrees_of_freedom"]) * np.array(curve["standard_error_cd_m2"])
        fit = fitted_curve(found, FINE)
        mean = found["mean_luminance_cd_m2"]["value"]
        dress = (name, *_DRESS[place])
        _add_band(figure, x, value, error, fit, dress, column=1)
        _add_band(
            figure,
            x,
            (value / mean - 1) * 100,
            error / mean * 100,
            (fit / mean - 1) * 100,
            dress,
            column=2,
        )
    limit = record["gates"][0]["limit"] * 100
    for sign in (-1, 1):
        figure.add_hline(sign * limit, line=line("#777", 1, "dot"), row=1, col=2)
    figure.update_xaxes(title_text="position [lamp pitch]; lamps at 0 and 1", range=[0, 1])
    return styled(figure, 380)


def film_figure(
    position: ArrayLike,
    curvature: ArrayLike,
    fitted: ArrayLike,
    fill: ArrayLike,
    aperture: ArrayLike | None,
    recovered: ArrayLike | None,
) -> "go.Figure":
    """Return curvature [1/mm], fill and aperture ratio [%] over the position [mm], on one axis."""
    import plotly.graph_objects as go

    figure = go.Figure()
    curves = [
        ("C through the tips", curvature, line(FILM_COLOUR, 2)),
        ("C, least-squares fit (profiler)", fitted, line(BASE_COLOUR, 1.5)),
        ("C from the mask file", recovered, line(FOURTH_COLOUR, 2, "dot")),
    ]
    shares = [
        ("fill (right)", fill, line(THIRD_COLOUR, 2, "dash")),
        ("aperture ratio (right)", aperture, line(FIFTH_COLOUR, 2, "dashdot")),
    ]
    x = rounded(position, 4)
    for name, values, dress in curves:
        if values is not None and len(np.asarray(values)):
            figure.add_scatter(x=x, y=rounded(values, 5), name=name, line=dress)
    drawn = [one for one in shares if one[1] is not None and len(np.asarray(one[1]))]
    for name, values, dress in drawn:
        percent = rounded(np.asarray(values) * 100, 4)
        figure.add_scatter(x=x, y=percent, name=name, line=dress, yaxis="y2")
    styled(figure, 400)
    figure.update_xaxes(title_text="from the lamp's axis [mm]")
    figure.update_yaxes(title_text="curvature C [1/mm]")
    if drawn:
        figure.update_layout(
            yaxis2={"title": {"text": "share [%]"}, "overlaying": "y", "side": "right",
                    "rangemode": "tozero", "showgrid": False, "zeroline": False,
                    "tickmode": "auto"},
            margin={"r": 60},
        )  # fmt: skip
    return figure


def fitted_curve(found: dict[str, Any], position: np.ndarray) -> np.ndarray:
    """Return the fitted luminance [cd/m²] of a trace at positions, straight between its points."""
    at = found["luminance"]["position_pitch"]
    return np.interp(position, at, found["curve"]["luminance_cd_m2"])


def _add_band(
    figure: "go.Figure",
    x: np.ndarray,
    value: np.ndarray,
    error: np.ndarray,
    fit: np.ndarray,
    dress: tuple[str, str, str],
    column: int,
) -> None:
    """Add points with the band of ± error around them, and the fitted line at `FINE`."""
    name, colour, band = dress
    shared = {"row": 1, "col": column, "legendgroup": name, "showlegend": False}
    figure.add_scatter(
        x=rounded(np.concatenate([x, x[::-1]]), 6),
        y=rounded(np.concatenate([value + error, (value - error)[::-1]]), 4),
        fill="toself",
        fillcolor=band,
        line={"width": 0},
        hoverinfo="skip",
        **shared,
    )
    figure.add_scatter(
        x=rounded(FINE, 6),
        y=rounded(fit, 4),
        mode="lines",
        line=line(colour, 2),
        hoverinfo="skip",
        name=name,
        **(shared | {"showlegend": column == 1}),
    )
    figure.add_scatter(
        x=rounded(x, 6),
        y=rounded(value, 4),
        error_y={"array": rounded(error, 4), "visible": False},
        mode="markers",
        marker={"size": 5, "color": colour},
        name=name,
        **shared,
    )


def line(colour: str, width: float, dash: str | None = None) -> dict[str, Any]:
    """Return the dress of a line."""
    return {"color": colour, "width": width, "dash": dash}


def broken(label: str, signs: int = LABEL) -> str:
    """Return a label in lines of so many signs, which leave the plot some room on a phone."""
    return "<br>".join(wrap(label, signs))


def rounded(values: ArrayLike, digits: int) -> list[float]:
    """Return values with so many decimals, as plain numbers."""
    return np.round(np.asarray(values, float), digits).tolist()


def place_map(
    x: list[float],
    y: list[float],
    rows: list[list[float]],
    bar: dict[str, Any],
    hover: str,
    axes: tuple[str, str] = ("across [mm]", "along [mm]"),
    **scale: float,
) -> "go.Figure":
    """Return a map over places, true to scale: a row of values for each y."""
    import plotly.graph_objects as go

    figure = go.Figure(
        go.Heatmap(
            x=x, y=y, z=rows, colorscale="Viridis", colorbar=bar,
            hovertemplate=f"%{{x}} mm, %{{y}} mm: {hover}<extra></extra>", **scale,
        )
    )  # fmt: skip
    styled(figure, 460)
    figure.update_xaxes(title_text=axes[0], constrain="domain")
    figure.update_yaxes(title_text=axes[1], scaleanchor="x", constrain="domain")
    figure.update_layout(hovermode="closest")
    return figure


def styled(figure: "go.Figure", height: int) -> "go.Figure":
    """Return the figure in the dress of the page."""
    figure.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        height=height,
        margin={"l": 60, "r": 20, "t": 40, "b": 50},
        font={"family": "system-ui, sans-serif", "size": 12, "color": "#222"},
        # At the foot, whatever the height: below the axis and its title.
        legend={"orientation": "h", "x": 0.5, "xanchor": "center",
                "yref": "container", "y": 0, "yanchor": "bottom"},
        hovermode="x unified",
    )  # fmt: skip
    figure.update_annotations(font_size=13)
    axis = {"gridcolor": "#e4e4e4", "linecolor": "#999", "mirror": True, "zeroline": False}
    figure.update_xaxes(title_standoff=6, automargin="height", **axis)
    figure.update_yaxes(automargin="width", **axis)
    return figure
