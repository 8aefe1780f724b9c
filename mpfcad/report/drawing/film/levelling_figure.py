"""The ripple of a print: what the apertures leave, and what is left of it after levelling."""

from typing import TYPE_CHECKING

import numpy as np

from mpfcad.mask.screen.levelled import LevelledWindow
from mpfcad.report.drawing.figure import rounded, styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

_OPEN = [[0, "#ffffff"], [1, "#0b5fa5"]]
_DEVIATION = [[0, "#08306b"], [0.5, "#f4f4f0"], [1, "#8c2d04"]]
#: Decimals of the curvature: what is below is not a matter of print.
_DIGITS = 7


def levelling_figure(window: LevelledWindow) -> "go.Figure":
    """Return the grooves as printed beside C after levelling less its mean [1/mm]."""
    from plotly.subplots import make_subplots

    figure = make_subplots(
        rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.16,
        subplot_titles=("printed: open share of the groove", "C after levelling − mean [1/mm]"),
    )  # fmt: skip
    x = rounded(window.position, 5)
    y = [str(window.first + n) for n in range(len(window.printed))]
    reach = max(float(np.abs(window.curvature).max()), 10.0**-_DIGITS)
    pictures = (
        (1, window.printed, 3, _OPEN, (0.0, 1.0), 0.79),
        (2, window.curvature, _DIGITS, _DEVIATION, (-reach, reach), 0.21),
    )
    for row, value, digits, colours, (low, high), place in pictures:
        figure.add_heatmap(
            x=x, y=y, z=[rounded(line, digits) for line in value], colorscale=colours,
            zmin=low, zmax=high, row=row, col=1,
            colorbar={"y": place, "len": 0.46, "thickness": 12, "exponentformat": "power"},
            hovertemplate="%{x} mm, groove %{y}: %{z}<extra></extra>",
        )  # fmt: skip
    figure.update_xaxes(title_text="along the groove [mm]", row=2, col=1)
    figure.update_yaxes(type="category", title_text="groove")
    styled(figure, 440)
    figure.update_layout(hovermode="closest", margin={"r": 70})
    return figure
