"""Where the lamps' light goes, as a flow."""

from typing import TYPE_CHECKING, Any

from mpfcad.report.drawing.figure import BASE_COLOUR, FILM_COLOUR, styled

if TYPE_CHECKING:
    import plotly.graph_objects as go

_IN, _LOST = "#c79a12", "#b02a1d"
_OUT_BAND, _ABSORBED_BAND = "rgba(11,95,165,0.35)", "rgba(138,109,59,0.3)"
#: A share below this is not drawn.
_LEAST = 1e-6


def energy_figure(energy: dict[str, Any]) -> "go.Figure":
    """Return the flow from the lamps to the viewer and to what absorbs, as shares."""
    import plotly.graph_objects as go

    ends = [("to the viewer", energy["out"], FILM_COLOUR, _OUT_BAND)]
    ends += [
        (f"absorbed by {name}", share, BASE_COLOUR, _ABSORBED_BAND)
        for name, share in energy["absorbed_by"].items()
    ]
    ends.append(("lost", energy["lost"], _LOST, _ABSORBED_BAND))
    ends = [end for end in ends if end[1] > _LEAST]
    labels = ["light that the lamps emit"] + [f"{name}: {share:.1%}" for name, share, *_ in ends]
    figure = go.Figure(
        go.Sankey(
            node={"label": labels, "color": [_IN, *(end[2] for end in ends)], "pad": 18},
            link={
                "source": [0] * len(ends),
                "target": list(range(1, len(ends) + 1)),
                "value": [round(end[1], 6) for end in ends],
                "color": [end[3] for end in ends],
                "hovertemplate": "%{value:.2%}<extra></extra>",
            },
        )
    )
    styled(figure, 280)
    figure.update_layout(margin={"l": 10, "r": 10, "t": 10, "b": 10}, hovermode="closest")
    return figure
