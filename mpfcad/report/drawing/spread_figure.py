"""Figures of point spread functions: the light of one LED, and of one zone."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.measure import reach
from mpfcad.report.drawing.figure import FILM_COLOUR, THIRD_COLOUR, line, place_map, rounded, styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Least value of the map's scale, over the largest luminance.
_LEAST = 1e-3
#: Degrees of freedom of a profile's standard errors: of 32 batches.
_FREEDOM = 31.0


def spread_figure(led: dict[str, Any]) -> "go.Figure":
    """Return the luminance that one LED makes, over its largest, on a logarithmic scale."""
    value = np.array(led["luminance_cd_m2"])
    across, along = (
        rounded((np.arange(n) + 0.5 - n / 2) * size, 3)
        for n, size in zip(value.shape, led["bin_mm"], strict=True)
    )
    shown = np.log10(np.maximum(value / value.max(), _LEAST))
    ticks = list(range(round(np.log10(_LEAST)), 1))
    bar = {"title": {"text": "over largest"}, "tickvals": ticks,
           "ticktext": [f"{10.0**tick:g}" for tick in ticks]}  # fmt: skip
    rows = [rounded(row, 3) for row in shown.T]
    return place_map(across, along, rows, bar, "10^%{z}", zmin=ticks[0], zmax=0)


def block_figure(block: dict[str, Any]) -> "go.Figure":
    """Return the luminance of a zone alone along both lines through its middle."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for axis, colour in (("across", FILM_COLOUR), ("along", THIRD_COLOUR)):
        found = block[f"profile_{axis}"]
        error = reach(_FREEDOM) * np.array(found["standard_error_cd_m2"])
        figure.add_scatter(
            x=rounded(found["from_middle_mm"], 3), y=rounded(found["luminance_cd_m2"], 1),
            error_y={"array": rounded(error, 1), "thickness": 0.7, "width": 1},
            name=f"{axis} the grooves", mode="lines+markers", marker={"size": 3},
            line=line(colour, 1.5),
        )  # fmt: skip
    for axis, (low, high) in zip(("x", "y"), block["from_to_mm"], strict=True):
        half, colour = (high - low) / 2, FILM_COLOUR if axis == "x" else THIRD_COLOUR
        for edge in (-half, half):
            figure.add_vline(edge, line=line(colour, 1, "dot"))
    figure.update_xaxes(title_text="from the zone's middle [mm]; dotted: its edges")
    figure.update_yaxes(title_text="luminance [cd/m²]", rangemode="tozero")
    return styled(figure, 400)
