"""A page that shows a BSDF table: energy over incidence, and where the light goes."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.bsdf.basis import AngleBasis, klems_basis
from mpfcad.optics.bsdf.rebin import overlap
from mpfcad.optics.bsdf.table import SIDES, WAYS, BsdfTable
from mpfcad.report.drawing.figure import BASE_COLOUR, FILM_COLOUR, broken, styled
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.environment import render

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Incidences [deg] that are drawn, each in azimuth 0 (across).
SHOWN_DEG = (0.0, 30.0, 60.0)
_MOST_BINS = 400
_DECADES = 3
#: Room [px] for the titles of four plots beside each other.
_LEAST_WIDTH = 560
#: Signs in a line of such a title.
_TITLE = 16


def bsdf_page(table: BsdfTable) -> str:
    """Return the page as HTML that needs no network; the same table gives the same bytes."""
    light = [
        [f"Lambertian light from {side}", *(f"{table.hemispherical[way, s]:.4f}" for way in (0, 1))]
        for s, side in enumerate(SIDES)
    ]
    return render(
        "bsdf.html.j2",
        table_read=table,
        reciprocity_error=f"{table.reciprocity_error:.2e}",
        light=light,
        energy=plot(energy_figure(table), "energy"),
        lobes=plot(lobe_figure(table), "lobes", _LEAST_WIDTH),
    )


def energy_figure(table: BsdfTable) -> "go.Figure":
    """Return transmittance and reflectance over the polar angle of incidence, from each side."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=1, cols=2, subplot_titles=[f"light from {s}" for s in SIDES])
    polar = np.degrees(table.basis.polar).round(6)
    ring = np.arange(len(polar)) if table.isotropic else table.basis.ring
    for side in (0, 1):
        for way, colour in ((0, FILM_COLOUR), (1, BASE_COLOUR)):
            share = table.energy[way, side]
            rows = [share[ring == r] for r in range(len(polar))]
            low, high = [r.min() for r in rows], [r.max() for r in rows]
            shared = {"row": 1, "col": side + 1, "legendgroup": WAYS[way]}
            figure.add_scatter(
                x=[*polar, *polar[::-1]], y=np.round([*high, *low[::-1]], 6).tolist(),
                fill="toself", mode="lines", line={"width": 0}, fillcolor=colour, opacity=0.2,
                hoverinfo="skip", showlegend=False, **shared,
            )  # fmt: skip
            figure.add_scatter(
                x=polar.tolist(), y=np.round([r.mean() for r in rows], 6).tolist(),
                name=WAYS[way], line={"color": colour}, mode="lines+markers",
                showlegend=side == 0, **shared,
            )  # fmt: skip
    figure.update_xaxes(title_text="incidence [°]", range=[0, 90])
    figure.update_yaxes(range=[0, 1.02])
    return styled(figure, 340)


def lobe_figure(table: BsdfTable) -> "go.Figure":
    """Return polar plots of each bin's BSDF: a row an incidence, a column a side and way."""
    from plotly.subplots import make_subplots

    titles = [
        broken(f"{theta:g}° from {side}, {way}", _TITLE)
        for theta in SHOWN_DEG
        for side in SIDES
        for way in WAYS
    ]
    figure = make_subplots(
        rows=len(SHOWN_DEG), cols=4, specs=[[{"type": "polar"}] * 4] * len(SHOWN_DEG),
        subplot_titles=titles, horizontal_spacing=0.03, vertical_spacing=0.09,
    )  # fmt: skip
    rows = [_lobes(table, np.radians(theta)) for theta in SHOWN_DEG]
    basis = rows[0][0]
    most = max(float(value.max()) for _, value in rows)
    top = np.log10(most) if most > 0 else 0.0
    degrees = np.degrees(basis.edge)
    for number, (_, value) in enumerate(rows):
        for column, bins in enumerate(value.transpose(1, 0, 2).reshape(4, -1)):
            height = np.log10(np.maximum(bins, most * 10.0**-_DECADES) if most > 0 else bins + 1)
            figure.add_barpolar(
                r=np.diff(degrees)[basis.ring].tolist(), base=degrees[:-1][basis.ring].tolist(),
                theta=np.degrees(basis.azimuth).round(6).tolist(),
                width=(360 / basis.azimuths[basis.ring]).tolist(),
                marker={"color": np.round(height, 4).tolist(), "coloraxis": "coloraxis",
                        "line": {"width": 0}},
                hovertext=[f"{b:.4g} /sr" for b in bins], hoverinfo="text", showlegend=False,
                row=number + 1, col=column + 1,
            )  # fmt: skip
    figure.update_polars(
        radialaxis={"range": [0, 90], "showticklabels": False, "dtick": 30, "gridcolor": "#ccc"},
        angularaxis={"showticklabels": False, "dtick": 90, "gridcolor": "#ccc"},
        bgcolor="rgba(0,0,0,0)",
    )
    figure.update_layout(
        coloraxis={"colorscale": "Viridis", "cmin": top - _DECADES, "cmax": top,
                   "colorbar": {"title": "log₁₀ BSDF", "thickness": 12}}
    )  # fmt: skip
    styled(figure, 250 * len(SHOWN_DEG)).update_annotations(font_size=11)
    return figure.update_layout(hovermode="closest")


def _lobes(table: BsdfTable, theta: float) -> tuple[AngleBasis, NDArray[np.float64]]:
    """Return outgoing bins, coarse enough to draw, and the BSDF (2, 2, o) for one incidence."""
    i = int(np.clip(np.searchsorted(table.basis.edge, theta, "right") - 1, 0, None))
    i = i if table.isotropic else int(table.basis.first[i])
    value = table.value[:, :, i]
    if table.basis.count <= _MOST_BINS:
        return table.basis, value
    basis = klems_basis("LBNL/Klems Full")
    share = overlap(basis, table.basis) / basis.projected[:, None]
    return basis, value @ share.T
