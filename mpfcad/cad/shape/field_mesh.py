"""A film whose curvature varies along its grooves as one closed triangle mesh. Plain numpy.

Corners stand in rows across the film, one a station along. Each groove has the same number of
corners in all of them: they follow its contact lines, so that the mesh has an edge along a line
that moves. Where a groove's wall or resin vanishes, its corners fall together, and the facets
between them with them. x is rounded to float32 first, z taken at the rounded x: the corners lie on
the true surface.
"""

import math

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.shape.cell_mesh import MOST_FACETS, close_top
from mpfcad.cad.shape.mesh import Mesh
from mpfcad.cad.step.outline import SLIVER
from mpfcad.errors import InputError
from mpfcad.film import FieldPiece
from mpfcad.units import deg

#: Shares of the angle for chords across and stations along; the rest is for rounding.
SHARE_ACROSS = SHARE_ALONG = 0.48
#: Fewest chords to each side of a groove's centre.
LEAST_CHORDS = 4


def build_field_mesh(film: FieldPiece, angle_tolerance: float) -> Mesh:
    """Return the piece as one closed mesh, facets within `angle_tolerance` [rad] of the surface.

    Raises
    ------
    InputError
        when that takes too many facets: the text says how long a piece may be.
    """
    along = _stations(film, angle_tolerance * SHARE_ALONG)
    chords = _chords(film, angle_tolerance * SHARE_ACROSS)
    _check_count(film, angle_tolerance, len(along), chords)
    rows = [_row(film, float(y), chords) for y in along.astype(np.float32)]
    vertices = np.concatenate([corners for corners, _ in rows])
    width = len(rows[0][0])
    number = np.stack([same for _, same in rows]) + width * np.arange(len(rows))[:, None]
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    d, c = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    first = np.stack([a, b, c], 1)[(a != b) & (b != c)]
    second = np.stack([a, c, d], 1)[(a != d) & (c != d)]
    rim = np.concatenate(
        [_distinct(number[0]), number[1:, -1], _distinct(number[-1])[-2::-1], number[-2:0:-1, 0]]
    )
    return close_top(film.size, vertices, rim, np.concatenate([first, second]))


def mesh_sliver(film: FieldPiece) -> float:
    """Return the width [mm] below which a part is merged: 0.1 µm or eight float32 steps."""
    return max(SLIVER, 8 * float(np.spacing(np.float32(film.size[0]))))


def mesh_contact(film: FieldPiece, curvature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return |x| [mm] up to which each groove of curvature C [1/mm] is meshed as a parabola."""
    w, sliver = film.groove.half_width, mesh_sliver(film)
    contact = film.contact(curvature)
    contact = np.where(contact < sliver, 0.0, contact)
    return np.where(w - contact < sliver, w, contact)


def _stations(film: FieldPiece, tolerance: float) -> NDArray[np.float64]:
    """Return the places along, (s,) [mm], between which no slope across turns by more.

    The slope where the parabola ends turns most: C w, or s x_c(C) C/s = 2 s - C w with walls.
    """
    w, s = film.groove.half_width, film.groove.wall_slope
    slope = film.curvature * w
    if film.profile == "filled":
        slope = np.minimum(slope, 2 * s - slope)
    turn = np.abs(np.diff(np.arctan(slope), axis=1))
    if film.profile == "filled":
        # Up to the covered groove's slope and down again, where C passes it in between.
        low, high = film.curvature[:, :-1], film.curvature[:, 1:]
        limit = film.groove.curvature_covered
        past = (low - limit) * (high - limit) < 0
        over = 2 * math.atan(s) - np.arctan(slope[:, :-1]) - np.arctan(slope[:, 1:])
        turn = np.where(past, over, turn)
    pieces = np.maximum(np.ceil(turn.max(axis=0) / tolerance), 1).astype(np.int64)
    start = np.repeat(film.along[:-1], pieces)
    step = np.repeat(np.diff(film.along) / pieces, pieces)
    inner = np.arange(len(start)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.append(start + step * inner, film.along[-1])


def _chords(film: FieldPiece, tolerance: float) -> NDArray[np.int64]:
    """Return how many chords each half groove has, (n,)."""
    contact = film.contact(film.curvature)
    slope = film.curvature * contact
    if film.profile == "filled":
        passed = (film.curvature.min(axis=1) < film.groove.curvature_covered) & (
            film.curvature.max(axis=1) > film.groove.curvature_covered
        )
        slope = np.where(passed[:, None], film.groove.wall_slope, slope)
    turn = np.arctan(slope).max(axis=1)
    return np.maximum(np.ceil(turn / (2 * tolerance)), LEAST_CHORDS).astype(np.int64)


def _check_count(
    film: FieldPiece, angle_tolerance: float, stations: int, chords: NDArray[np.int64]
) -> None:
    """Refuse a mesh of too many facets; the underside and the sides are not counted."""
    each = 2.0 * (2 * np.sum(chords) + 2 * len(chords))
    facets = each * (stations - 1)
    if facets <= MOST_FACETS:
        return
    width, length = film.size
    room = MOST_FACETS / facets
    raise InputError(
        f"film: {width:.6g} x {length:.6g} mm at {angle_tolerance / deg:g} deg: "
        f"{facets / 1e6:.3g} million facets: expected at most {MOST_FACETS / 1e6:g} million: "
        f"{math.floor(width * length * room):g} mm² of this map fit, or about "
        f"{math.ceil(angle_tolerance / deg / math.sqrt(room) * 10) / 10:g} deg"
    )


def _row(
    film: FieldPiece, y: float, chords: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return the corners across at y [mm], (m, 3), and which of them each one falls together with.

    A groove has its left tip, then 2 k + 1 corners of the parabola from contact to contact.
    """
    groove = np.arange(film.groove_count)
    curvature = film.curvature_at(groove, y)
    contact = mesh_contact(film, curvature)
    count = 2 * chords + 2
    start = np.cumsum(count) - count
    owner = np.repeat(groove, count)
    corner = np.arange(len(owner)) - start[owner] - 1
    ratio = corner / chords[owner] - 1
    angle = np.arctan(curvature * contact)[owner]
    steep = angle > 1e-9
    turn = np.divide(np.tan(angle * ratio), np.tan(angle), out=ratio.copy(), where=steep)
    local = turn * contact[owner]
    centre = film.groove_position[owner]
    x = np.append(centre + local, film.size[0]).astype(np.float32)
    x[start] = film.tip_position[:-1]
    end = (corner == 0) | (corner == 2 * chords[owner])
    _stay_inside(x[:-1], centre, np.where(end, contact[owner], np.inf))
    z = _height(film, x[:-1].astype(float) - centre, curvature[owner], contact[owner])
    z[start] = film.thickness
    corners = np.column_stack([x, np.full(len(x), y), np.append(z, film.thickness)])
    return corners.astype(np.float32), _same(film, contact, chords, start, owner)


def _stay_inside(
    x: NDArray[np.float32], centre: NDArray[np.float64], limit: NDArray[np.float64]
) -> None:
    """Move corners that rounding put beyond `limit` from the centre one step towards it."""
    beyond = np.abs(x.astype(float) - centre) > limit
    x[beyond] = np.nextafter(x[beyond], centre[beyond].astype(np.float32))


def _height(
    film: FieldPiece,
    local: NDArray[np.float64],
    curvature: NDArray[np.float64],
    contact: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return z [mm] at `local` from the centre; a groove whose resin is merged has its bare V."""
    surface = film.base + film.groove.height(local, curvature, film.profile)
    bare = film.base + film.groove.wall_slope * np.abs(local)
    return np.where(contact > 0, surface, bare)


def _same(
    film: FieldPiece,
    contact: NDArray[np.float64],
    chords: NDArray[np.int64],
    start: NDArray[np.int64],
    owner: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Return which corner of the row each one falls together with."""
    same = np.arange(len(owner) + 1)
    empty = (contact == 0)[owner]
    same[:-1][empty] = (start + 1 + chords)[owner][empty]
    same[start] = start
    full = contact == film.groove.half_width
    same[start[full] + 1] = start[full]
    last = start + 2 * chords + 1
    same[last[full]] = last[full] + 1
    return same


def _distinct(line: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a line of corners without repetitions."""
    return line[np.concatenate([[True], line[1:] != line[:-1]])]
