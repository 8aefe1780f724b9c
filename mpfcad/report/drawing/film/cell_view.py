"""A few cells in three dimensions, drawn from the corners in film.stl."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CellFilm
from mpfcad.report.drawing.film.groove_view import BASE_SHOWN, PRISM_COLOUR, RESIN_COLOUR, scene
from mpfcad.units import nm

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Cells shown to each side, and the most lines of a dish's grid across them.
CELLS, LINES = 2, 49
#: Resin thinner than this is bare wall.
THIN = 10 * nm


def cell_view(mesh: Path, film: CellFilm) -> "go.Figure":
    """Return the cells in the middle of the piece; resin and prism apart where both are seen."""
    corner = _read_window(mesh, film)
    if film.shape == "paraboloid":
        vertex, triangle = _dish_grid(corner)
        return scene([("film", PRISM_COLOUR, *_with_sides(vertex, triangle, film))])
    vertex, inverse = np.unique(corner.reshape(-1, 3), axis=0, return_inverse=True)
    triangle = inverse.reshape(-1, 3)
    if film.profile == "ideal":
        return scene([("film", PRISM_COLOUR, *_with_sides(vertex, triangle, film))])
    middle = corner.mean(axis=1)
    near = np.abs(film.local(middle[:, 0], middle[:, 1])).min(axis=0)
    resin = middle[:, 2] - film.base - film.groove.wall_slope * near > THIN
    return scene(
        [
            ("prism", PRISM_COLOUR, *_with_sides(vertex, triangle, film, ~resin)),
            ("resin", RESIN_COLOUR, vertex, triangle[resin]),
        ]
    )


def _read_window(mesh: Path, film: CellFilm) -> NDArray[np.float64]:
    """Return the top facets, (t, 3, 3) [mm], of the cells in the middle, from their edges on."""
    import trimesh

    corner = np.asarray(trimesh.load(mesh, file_type="stl").triangles, float)
    pitch = film.groove.pitch
    count = np.array(film.count)
    shown = np.minimum(count, CELLS)
    low = (count - shown) // 2 * pitch
    high = low + shown * pitch
    flat = corner[:, :, :2]
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inside = np.all((flat > low - pitch / 1000) & (flat < high + pitch / 1000), axis=(1, 2))
    chosen = corner[inside & (area[:, 2] > 0)]
    return chosen - np.append(low, 0.0)


def _dish_grid(corner: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return some of the lines of a grid of corners, first and last among them, as a surface."""
    points = np.unique(corner.reshape(-1, 3), axis=0)
    lines = [np.unique(points[:, axis]) for axis in (0, 1)]
    kept = [
        line[np.unique(np.linspace(0, len(line) - 1, min(LINES, len(line))).round().astype(int))]
        for line in lines
    ]
    chosen = points[np.isin(points[:, 0], kept[0]) & np.isin(points[:, 1], kept[1])]
    number = np.arange(len(chosen)).reshape(len(kept[0]), len(kept[1]))
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    return chosen, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def _with_sides(
    vertex: NDArray[np.float64],
    triangle: NDArray[np.int64],
    film: CellFilm,
    kept: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a surface, or what is `kept` of it, with upright sides down to the base shown."""
    edges = np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]], triangle[:, [2, 0]]])
    count = len(vertex)
    key, back = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    rim = edges[~np.isin(key, back)]
    below = vertex * (1.0, 1.0, 0.0) + (0.0, 0.0, film.lowest - BASE_SHOWN)
    start, end = rim[:, 0], rim[:, 1]
    sides = np.concatenate(
        [
            np.stack([start, start + count, end + count], 1),
            np.stack([start, end + count, end], 1),
        ]
    )
    top = triangle if kept is None else triangle[kept]
    return np.concatenate([vertex, below]), np.concatenate([top, sides])
