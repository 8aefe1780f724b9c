"""The page of `mpfcad fit`: values with widths, residuals, what is held, what to measure next."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.report.drawing.figure import BASE_COLOUR, FILM_COLOUR, broken, line, styled
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.environment import render

if TYPE_CHECKING:
    import plotly.graph_objects as go

Record = dict[str, Any]
_SIGN = {"equal": "", "at_least": "≥ ", "at_most": "≤ "}


def write_fit_page(path: Path, record: Record) -> None:
    """Write the page; the same record gives the same bytes."""
    path.write_bytes(build_fit_page(record).encode())


def build_fit_page(record: Record) -> str:
    """Return the page as HTML that needs no network."""
    return render(
        "fit.html.j2",
        record=record,
        million_paths=f"{record['paths'] / 1e6:.1f}",
        widths=plot(_widths(record["values"]), "widths"),
        residuals=plot(_residuals(record["data"]), "residuals"),
        values=[_value(row) for row in record["values"]],
        data=[_datum(row) for row in record["data"]],
        combinations=[
            (f"{one['width']:.3f}", ", ".join(f"{v:+.2f} {k}" for k, v in one["parts"].items()))
            for one in record["combinations"]
        ],
        predictions=[
            (one["name"], f"{one['value']:.5g}", f"{one['ci95'][0]:.5g} … {one['ci95'][1]:.5g}",
             f"{one['trace_sigma']:.2g}")
            for one in record["predictions"]
        ],
        advice=[(one["measurement"], f"{one['left']:.3f}") for one in record["measure_next"]],
    )  # fmt: skip


def _value(row: Record) -> list[str]:
    prior = (
        "none" if row["prior_sigma"] is None else f"{row['prior']:.5g} ± {row['prior_sigma']:.2g}"
    )
    low, high = row["ci95"]
    return [
        row["name"],
        prior,
        f"{row['value']:.5g} ± {row['sigma']:.2g}" + (" (at its limit)" if row["at_limit"] else ""),
        f"{low:.5g} … {high:.5g}",
        "–" if row["left"] is None else f"{row['left']:.2f}",
        row["prior_source"],
    ]


def _datum(row: Record) -> list[str]:
    return [
        row["name"],
        f"{_SIGN[row['kind']]}{row['measured']:.5g} ± {row['sigma']:.2g}",
        f"{row['by_prior']:.5g}",
        f"{row['predicted']:.5g} ± {row['predicted_sigma']:.2g}",
        f"{row['residual']:+.2f}",
        f"{row['share_of_trace_noise']:.0%}",
    ]


def _widths(values: list[Record]) -> "go.Figure":
    """Return each value's width left over its prior's, and how far it moved, in prior widths."""
    import plotly.graph_objects as go

    shown = [row for row in values[::-1] if row["left"] is not None]
    moved = [(row["value"] - row["prior"]) / row["prior_sigma"] for row in shown]
    figure = go.Figure()
    figure.add_scatter(
        x=[0.0] * len(shown), y=[row["name"] for row in shown], mode="markers", name="prior",
        error_x={"array": [1.0] * len(shown), "thickness": 1.2, "color": BASE_COLOUR},
        marker={"size": 6, "color": BASE_COLOUR},
    )  # fmt: skip
    figure.add_scatter(
        x=[round(one, 4) for one in moved], y=[row["name"] for row in shown], mode="markers",
        error_x={"array": [round(row["left"], 4) for row in shown], "thickness": 3,
                 "color": FILM_COLOUR},
        marker={"size": 9, "color": FILM_COLOUR}, name="fitted",
    )  # fmt: skip
    figure.update_xaxes(title_text="in σ of the prior")
    styled(figure, 130 + 26 * len(shown))
    figure.update_layout(hovermode="closest", margin={"t": 10})
    return figure


def _residuals(data: list[Record]) -> "go.Figure":
    """Return how far each prediction lies off, in standard deviations of both."""
    import plotly.graph_objects as go

    shown = data[::-1]
    figure = go.Figure(
        go.Bar(
            x=[round(row["residual"], 3) for row in shown],
            y=[broken(row["name"]) for row in shown],
            orientation="h",
            marker={"color": FILM_COLOUR},
        )
    )
    for sign in (-2, 2):
        figure.add_vline(sign, line=line("#777", 1, "dot"))
    figure.update_xaxes(title_text="predicted − measured [σ]")
    styled(figure, 110 + 36 * len(shown))
    figure.update_layout(hovermode="closest", margin={"t": 10})
    return figure
