"""Grooves whose curvature varies along them: a map of C, and a few of them in three dimensions."""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import FieldPiece
from mpfcad.report.drawing.film.groove_view import (
    BASE_SHOWN,
    GROOVES,
    PRISM_COLOUR,
    RESIN_COLOUR,
    scene,
)

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Most stations drawn along, and lines to each side of a groove's centre.
STATIONS, LINES = 61, 8
#: How much longer than wide the drawing is, at most: grooves are drawn shortened.
LENGTH_TO_WIDTH = 2.0


def field_figure(film: FieldPiece) -> "go.Figure":
    """Return the map of C over the piece, from its lower left corner."""
    return curvature_figure(film.groove_position, film.along, film.curvature)


def curvature_figure(
    across: NDArray[np.float64], along: NDArray[np.float64], curvature: NDArray[np.float64]
) -> "go.Figure":
    """Return the map of C (n, m) [1/mm] over x (n,) and y (m,) [mm]."""
    import plotly.graph_objects as go

    figure = go.Figure(
        go.Heatmap(
            x=across.round(6).tolist(),
            y=along.round(6).tolist(),
            z=curvature.T.round(4).tolist(),
            colorscale="Viridis",
            colorbar={"title": {"text": "C [/mm]"}},
            hovertemplate="x %{x:.3f} mm<br>y %{y:.3f} mm<br>C %{z:.2f} /mm<extra></extra>",
        )
    )
    figure.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        height=380,
        margin={"l": 60, "r": 10, "t": 10, "b": 50},
        font={"family": "system-ui, sans-serif", "size": 12, "color": "#222"},
        xaxis={"title": {"text": "across [mm]"}, "constrain": "domain"},
        yaxis={"title": {"text": "along [mm]"}, "scaleanchor": "x"},
    )
    return figure


def field_view(mesh: Path, film: FieldPiece) -> "go.Figure":
    """Return the grooves in the middle of the piece over its whole length, as film.stl has them.

    Where they are much longer than wide they are drawn shortened.
    """
    first = max((film.groove_count - GROOVES) // 2, 0)
    shown = range(first, min(first + GROOVES, film.groove_count))
    rows = _read_rows(mesh, film.tip_position[[first, shown[-1] + 1]])
    stations = np.array(list(rows))
    few = np.linspace(0, len(stations) - 1, min(STATIONS, len(stations))).round().astype(int)
    along = stations[np.unique(few)]
    bodies = [_groove(film, groove, along, rows) for groove in shown]
    low = film.tip_position[first]
    named = [("prism", PRISM_COLOUR), ("resin", RESIN_COLOUR)]
    if film.profile == "ideal":
        named = [("film", PRISM_COLOUR)]
    figure = scene(
        (name, colour, *_joined([body[k] for body in bodies], low))
        for k, (name, colour) in enumerate(named)
    )
    width = len(shown) * film.groove.pitch
    stretch = min(film.size[1] / width, LENGTH_TO_WIDTH)
    up = (film.groove.depth + BASE_SHOWN) / width
    ratio = {"x": 1.0, "y": stretch, "z": up}
    eye = {"x": 1.5, "y": -2.3, "z": 1.6}
    figure.update_layout(
        scene_aspectmode="manual", scene_aspectratio=ratio, scene_camera={"eye": eye}
    )
    return figure


def _read_rows(
    mesh: Path, window: NDArray[np.float64]
) -> dict[float, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return x and z [mm] of the corners of the top at each station, those from tip to tip."""
    import trimesh

    corner = np.asarray(trimesh.load(mesh, file_type="stl").vertices, float)
    room = (window[1] - window[0]) / 1000
    inside = (corner[:, 0] > window[0] - room) & (corner[:, 0] < window[1] + room)
    corner = corner[inside & (corner[:, 2] > 0)]
    corner = corner[np.lexsort([corner[:, 0], corner[:, 1]])]
    station, first = np.unique(corner[:, 1], return_index=True)
    parts = np.split(corner, first[1:])
    return {float(y): (part[:, 0], part[:, 2]) for y, part in zip(station, parts, strict=True)}


_Body = tuple[NDArray[np.float64], NDArray[np.int64]]


def _groove(
    film: FieldPiece,
    groove: int,
    along: NDArray[np.float64],
    rows: dict[float, tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> list[_Body]:
    """Return prism and resin of a groove, or what an ideal one is made of."""
    centre, w = film.groove_position[groove], film.groove.half_width
    contact = film.contact(film.curvature_at(groove, along))
    x = centre + np.linspace(-1, 1, 2 * LINES + 1) * contact[:, None]
    surface = np.stack([np.interp(line, *rows[y]) for line, y in zip(x, along, strict=True)])
    floor = film.base - BASE_SHOWN
    if film.profile == "ideal":
        return [_body(x, along, surface, np.full_like(x, floor))]
    wall = film.base + film.groove.wall_slope * np.abs(x - centre)
    bare = np.tile(centre + np.array([-w, 0.0, w]), (len(along), 1))
    high = film.base + film.groove.wall_slope * np.abs(bare - centre)
    return [
        _body(bare, along, high, np.full_like(high, floor)),
        _body(x, along, surface, np.minimum(wall, surface)),
    ]


def _body(
    x: NDArray[np.float64],
    along: NDArray[np.float64],
    upper: NDArray[np.float64],
    lower: NDArray[np.float64],
) -> _Body:
    """Return vertices and triangles of top, ends and sides of what is between two surfaces."""
    y = np.broadcast_to(along[:, None], x.shape)
    vertex = np.concatenate([np.stack([x, y, z], axis=-1).reshape(-1, 3) for z in (upper, lower)])
    top = np.arange(x.size).reshape(x.shape)
    low = top + x.size
    strips = [
        (low[0], top[0]), (top[-1], low[-1]), (top[:, 0], low[:, 0]), (low[:, -1], top[:, -1]),
        *pairwise(top),
    ]  # fmt: skip
    faces = []
    for near, far in strips:
        a, b, c, d = near[:-1], near[1:], far[1:], far[:-1]
        faces += [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    return vertex, np.concatenate(faces)


def _joined(bodies: list[_Body], low: float) -> _Body:
    """Return bodies as one, x from `low` [mm] on."""
    start = np.cumsum([0, *(len(vertex) for vertex, _ in bodies)])
    vertex = np.concatenate([vertex for vertex, _ in bodies]) - (low, 0.0, 0.0)
    return vertex, np.concatenate([t + s for (_, t), s in zip(bodies, start, strict=False)])
