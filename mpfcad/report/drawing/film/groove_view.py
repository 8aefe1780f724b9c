"""A few grooves in three dimensions, as a plotly figure that turns under the mouse."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import MadeFilm
from mpfcad.report.drawing.film.groove_drawing import read_section
from mpfcad.units import um

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Grooves shown, how long a piece of them, and how much of the base below the valleys [mm].
GROOVES, LENGTH, BASE_SHOWN = 3, 0.12, 0.03
PRISM_COLOUR, RESIN_COLOUR = "#9fc0de", "#f2b84b"
#: Narrow triangles have normals too: no epsilon.
LIGHTING = {
    "ambient": 0.55,
    "diffuse": 0.7,
    "specular": 0.15,
    "roughness": 0.6,
    "facenormalsepsilon": 0,
    "vertexnormalsepsilon": 0,
}
#: Coordinates are shown to this many decimals of a micrometre.
DECIMALS = 4


def groove_view(mesh: Path, made: MadeFilm) -> "go.Figure":
    """Return the grooves in the middle of the piece: the surface from film.stl, walls as made.

    Where prism and resin are not known apart they are one body.
    """
    film = made.film
    x, surface, wall = _profile(mesh, made)
    low = film.base - BASE_SHOWN
    if wall is None:
        bodies = [("film", PRISM_COLOUR, x, surface, np.full_like(x, low))]
    else:
        bodies = [
            ("prism", PRISM_COLOUR, x, wall, np.full_like(x, low)),
            ("resin", RESIN_COLOUR, x, surface, wall),
        ]
    length = min(LENGTH, film.length)
    return scene(
        (name, colour, *_extrude(across, upper, lower, length))
        for name, colour, across, upper, lower in bodies
    )


def scene(
    bodies: Iterable[tuple[str, str, NDArray[np.float64], NDArray[np.int64]]],
) -> "go.Figure":
    """Return the figure of bodies: name, colour, vertices (v, 3) [mm] and triangles (t, 3)."""
    import plotly.graph_objects as go

    figure = go.Figure()
    corners = []
    for name, colour, vertex, triangle in bodies:
        if len(triangle) == 0:
            continue
        vertex = np.round(vertex / um, DECIMALS)
        corners += [vertex.min(axis=0), vertex.max(axis=0)]
        figure.add_mesh3d(
            **dict(zip("xyz", vertex.T.tolist(), strict=True)),
            **dict(zip("ijk", triangle.T.tolist(), strict=True)),
            name=name,
            color=colour,
            flatshading=True,
            showlegend=True,
            hovertemplate="x %{x:.2f} µm<br>z %{z:.2f} µm<extra>" + name + "</extra>",
            lighting=LIGHTING,
            lightposition={"x": -4000, "y": -9000, "z": 12000},
        )
    away = _away(np.ptp(corners, axis=0))
    axis = {"backgroundcolor": "#fafbfc", "gridcolor": "#dde2e7", "zeroline": False}
    figure.update_layout(
        template="none",
        paper_bgcolor="rgba(0,0,0,0)",
        height=460,
        margin={"l": 0, "r": 0, "t": 10, "b": 0},
        font={"family": "system-ui, sans-serif", "size": 12, "color": "#222"},
        legend={"orientation": "h", "y": 0.98, "x": 0.02},
        scene={
            "xaxis": {"title": {"text": "across [µm]"}, **axis},
            "yaxis": {"title": {"text": "along [µm]"}, **axis},
            "zaxis": {"title": {"text": "up [µm]"}, **axis},
            "aspectmode": "data",
            "camera": {"eye": {"x": 1.15 * away, "y": -1.95 * away, "z": 1.15 * away}},
        },
    )
    return figure


def _away(size: NDArray[np.float64]) -> float:
    """Return how much farther off a long body has to be looked at, so that all of it is seen.

    plotly draws a box of size (3,) with its volume as 1.
    """
    shape = size / np.prod(size) ** (1 / 3)
    return round(max(float(np.linalg.norm(shape)) / 2, 1.0), 3)


def _profile(
    mesh: Path, made: MadeFilm
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64] | None]:
    """Return x from the first tip shown, surface and prism [mm], from corner to corner."""
    film = made.film
    corner = read_section(mesh)
    first = max((film.groove_count - GROOVES) // 2, 0)
    last = min(first + GROOVES, film.groove_count)
    tip, pitch = film.tip_position, film.groove.pitch
    inside = (corner[:, 0] > tip[first] - pitch / 1000) & (corner[:, 0] < tip[last] + pitch / 1000)
    valley = film.groove_position[first:last]
    kinks = np.concatenate([tip[first : last + 1], valley])
    x = np.union1d(corner[inside, 0], kinks)
    rounded = np.abs(x[:, None] - kinks).min(axis=1) < film.groove.pitch / 1000
    x = x[~rounded | np.isin(x, kinks)]
    surface = np.interp(x, corner[inside, 0], corner[inside, 1])
    wall = made.bare_height(x)
    if wall is None:
        return x - tip[first], surface, None
    # Bare walls are the surface: no resin thinner than what float32 rounds away.
    wall = np.where(surface - wall < 1e-2 * um, surface, wall)
    return x - tip[first], surface, wall


def _extrude(
    x: NDArray[np.float64],
    upper: NDArray[np.float64],
    lower: NDArray[np.float64],
    length: float,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (v, 3) and triangles (t, 3) of what lies between two lines over x."""
    count = len(x)
    corners = [
        np.stack([x, np.full(count, y), z], axis=1) for y in (0.0, length) for z in (lower, upper)
    ]
    thick = upper > lower
    left = np.flatnonzero(thick[:-1] | thick[1:])

    def quads(first: int, second: int) -> NDArray[np.int64]:
        """Return the strip between two of the four rows of corners."""
        a, b = left + first * count, left + second * count
        return np.concatenate([np.stack([a, a + 1, b + 1], 1), np.stack([a, b + 1, b], 1)])

    faces = [quads(0, 1), quads(3, 2), quads(1, 3), quads(2, 0)]
    for end in (0, count - 1):
        low_near, high_near, low_far, high_far = (end + row * count for row in range(4))
        if thick[end]:
            side = np.array([[low_near, high_near, high_far], [low_near, high_far, low_far]])
            faces.append(side if end == 0 else side[:, ::-1])
    return np.concatenate(corners), np.concatenate(faces)
