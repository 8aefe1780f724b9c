"""What the report's section on confidence shows: probabilities, what they hang on, what to do."""

from typing import TYPE_CHECKING, Any

from mpfcad.report.drawing.figure import FILM_COLOUR, styled
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.number import with_interval

if TYPE_CHECKING:
    import plotly.graph_objects as go

Record = dict[str, Any]


def confidence_values(record: Record) -> Record | None:
    """Return what the section shows; None where the job did not ask for it."""
    found = record.get("confidence")
    if found is None:
        return None
    return {
        "likely": [
            (f"contrast at most {one['limit']:g}", with_interval(one, 2))
            for one in found["probability"].values()
        ],
        "contrast": with_interval(found["contrast"], 4),
        "bars": plot(_bars(found["inputs"]), "confidence"),
        "inputs": [
            [
                one["name"],
                f"{one['value']:.6g}",
                f"{one['sigma']:.3g}",
                f"{one['share_of_variance']:.1%}",
                one["source"],
            ]
            for one in found["inputs"]
        ],
        "measure": [
            [
                one["measurement"],
                f"{one['contrast_spread_before']:.4f} → {one['contrast_spread']:.4f}",
                f"{one['probability_if_confirmed']:.2f}",
            ]
            for one in found["measure_next"]
        ],
        "left_out": found["left_out"],
        "paths": f"{found['paths'] / 1e6:.1f} million",
    }


def _bars(inputs: list[Record]) -> "go.Figure":
    """Return each input's share of the curve's variance, the largest on top."""
    import plotly.graph_objects as go

    shown = inputs[::-1]
    figure = go.Figure(
        go.Bar(
            x=[round(100 * one["share_of_variance"], 2) for one in shown],
            y=[one["name"] for one in shown],
            orientation="h",
            marker={"color": FILM_COLOUR},
        )
    )
    figure.update_xaxes(title_text="share of the curve's variance [%]")
    styled(figure, 110 + 24 * len(shown))
    figure.update_layout(hovermode="closest", margin={"t": 10})
    return figure
