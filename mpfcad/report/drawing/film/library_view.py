"""A few groove pieces in three dimensions, drawn from the instances in film.3mf."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mpfcad.cad.check.library import read_pieces
from mpfcad.film import PieceLibrary
from mpfcad.report.drawing.film.groove_view import BASE_SHOWN, GROOVES, LENGTH, PRISM_COLOUR, scene

if TYPE_CHECKING:
    import plotly.graph_objects as go


def library_view(mesh: Path, film: PieceLibrary) -> "go.Figure":
    """Return the pieces in the middle of the film; base and length are cut off."""
    found = read_pieces(mesh)
    shape = np.array(film.chosen.shape)
    shown = np.minimum(shape, (GROOVES, max(1, round(LENGTH / film.length))))
    step = np.array([film.groove.pitch, film.length])
    low = (shape - shown) // 2 * step
    at = found.place - low
    inside = np.all((at > -step / 2) & (at < (shown - 0.5) * step), axis=1)
    vertex, triangle, start = [], [], 0
    for identity, place in zip(found.number[inside], at[inside], strict=True):
        point = found.point[int(identity)] + np.append(place, 0.0)
        point[:, 1] = np.minimum(point[:, 1], LENGTH)
        point[:, 2] = np.maximum(point[:, 2], film.base - BASE_SHOWN)
        vertex.append(point)
        triangle.append(found.facet[int(identity)] + start)
        start += len(point)
    return scene([("film", PRISM_COLOUR, np.concatenate(vertex), np.concatenate(triangle))])
