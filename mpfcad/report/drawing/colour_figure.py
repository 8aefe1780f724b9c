"""Figures of colour: u' and v' over a lamp pitch or a cell, and over direction."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.measure import reach
from mpfcad.report.drawing.figure import (
    BASE_COLOUR,
    FILM_COLOUR,
    THIRD_COLOUR,
    line,
    rounded,
    styled,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go

_THOUSANDTHS = 1000.0


def colour_pitch_figure(found: dict[str, Any]) -> "go.Figure":
    """Return u' and v' over the places across, less the mean's, in thousandths, with 95 % bars."""
    import plotly.graph_objects as go

    places, figure = found["over_screen"], go.Figure()
    for name, colour in (("u_prime", FILM_COLOUR), ("v_prime", BASE_COLOUR)):
        away = np.array(places[name]) - found["mean"][name]["value"]
        _add(figure, places["x_mm"], away, _bars(places, name), _WORDS[name], colour)
    figure.update_xaxes(title_text="from the lamp's axis [mm]")
    figure.update_yaxes(title_text="from the mean [0.001]")
    return styled(figure, 360)


def colour_cell_figure(found: dict[str, Any]) -> "go.Figure":
    """Return Δu'v' from the mean over a cell of LEDs, in thousandths."""
    import plotly.graph_objects as go

    places, mean = found["over_screen"], found["mean"]
    away = np.hypot(
        np.array(places["u_prime"]) - mean["u_prime"]["value"],
        np.array(places["v_prime"]) - mean["v_prime"]["value"],
    )
    x, y = (sorted(set(places[key])) for key in ("x_mm", "y_mm"))
    grid = rounded(away.reshape(len(x), len(y)).T * _THOUSANDTHS, 4)
    heat = go.Heatmap(
        x=rounded(x, 4), y=rounded(y, 4), z=grid, colorscale="Viridis",
        colorbar={"title": {"text": "Δu′v′ [0.001]"}},
    )  # fmt: skip
    figure = go.Figure(heat)
    figure.update_xaxes(title_text="across [mm]", constrain="domain")
    figure.update_yaxes(title_text="along [mm]", scaleanchor="x")
    return styled(figure, 420)


def colour_angle_figure(found: dict[str, Any], axes: dict[str, str]) -> "go.Figure":
    """Return Δu'v' from the normal over the viewing angle, in thousandths, with 95 % bars."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for plane, colour in (("across", FILM_COLOUR), ("along", THIRD_COLOUR)):
        curve = found["over_angle"][plane]
        value, ends = np.array(curve["shift_from_normal"]), np.array(curve["shift_ci95"])
        bars = np.column_stack([ends[:, 1] - value, value - ends[:, 0]])
        _add(figure, curve["angle_deg"], value, bars, f"{axes[plane]} ({plane})", colour)
    figure.update_xaxes(title_text="from the normal [°]", range=[-82, 82], dtick=20)
    figure.update_yaxes(title_text="Δu′v′ from the normal [0.001]", rangemode="tozero")
    return styled(figure, 360)


_WORDS = {"u_prime": "u′ less its mean", "v_prime": "v′ less its mean"}


def _bars(places: dict[str, Any], name: str) -> np.ndarray:
    """Return half the 95 % intervals upward and downward, (p, 2)."""
    error = np.array(places[f"standard_error_{name}"])
    half = reach(places["degrees_of_freedom"]) * error
    return np.column_stack([half, half])


def _add(
    figure: "go.Figure", x: Any, value: np.ndarray, bars: np.ndarray, name: str, colour: str
) -> None:
    up, down = (rounded(part * _THOUSANDTHS, 4) for part in bars.T)
    figure.add_scatter(
        x=rounded(x, 4), y=rounded(value * _THOUSANDTHS, 4), name=name, mode="lines+markers",
        error_y={"array": up, "arrayminus": down, "symmetric": False, "thickness": 1, "width": 2},
        marker={"size": 4}, line=line(colour, 2),
    )  # fmt: skip
