"""The luminance over a pitch as the inputs would have it: what the page's sliders move."""

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from mpfcad.measure import POINTS
from mpfcad.measure.contrast.fit import basis
from mpfcad.report.drawing.figure import (
    BASE_COLOUR,
    FILM_COLOUR,
    FINE,
    fitted_curve,
    line,
    rounded,
    styled,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go

Record = dict[str, Any]
#: The inputs' effects were traced at 1.5 standard uncertainties; sliders go a little farther.
REACH = 3.0


def response_figure(record: Record) -> "go.Figure":
    """Return the traced curve over its mean, and a second one that the sliders move."""
    import plotly.graph_objects as go

    start = rounded((_start(record) - 1) * 100, 4)
    figure = go.Figure()
    for name, colour, dash in (("as traced", BASE_COLOUR, "dot"), ("as set", FILM_COLOUR, None)):
        figure.add_scatter(x=rounded(FINE, 5), y=start, mode="lines", name=name,
                           line=line(colour, 2, dash))  # fmt: skip
    figure.update_xaxes(title_text="position [lamp pitch]; lamps at 0 and 1", range=[0, 1])
    figure.update_yaxes(title_text="luminance over its mean [%]")
    return styled(figure, 340)


def response_data(record: Record, effects: list[Record]) -> Markup:
    """Return what the sliders need: the traced curve, and each input's effect on it, as JSON."""
    inputs = [
        {
            "name": one["name"],
            "value": one["value"],
            "sigma": one["sigma"],
            "low": one.get("low"),
            "high": one.get("high"),
            "slope": rounded(_over_pitch(one["effect_of_sigma"]), 7),
            "bend": rounded(_over_pitch(one.get("second_order", [])), 7),
        }
        for one in effects
    ]
    content = {"start": rounded(_start(record), 7), "inputs": inputs}
    return Markup(json.dumps(content).replace("<", r"\u003c"))


def _start(record: Record) -> np.ndarray:
    """Return the traced curve over its mean at `FINE`."""
    curve = fitted_curve(record, FINE)
    return np.asarray(curve / curve[:-1].mean())


def _over_pitch(coefficient: list[float]) -> np.ndarray:
    """Return relative coefficients as a curve at `FINE`: of a series, or of the points' own."""
    if not any(coefficient):
        return np.zeros(0)
    if len(coefficient) == POINTS:
        return np.interp(FINE, np.linspace(0, 1, POINTS), coefficient)
    return np.asarray(basis(FINE, len(coefficient) // 2)[:, 1:] @ np.array(coefficient))
