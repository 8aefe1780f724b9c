"""Write a film whose curvature varies along its grooves as one exact solid; no CAD library is used.

Between two bends of C(y) a groove's surface is one patch. Without bare walls it is a polynomial of
degree 2 across and 1 along. With them it ends at the contact line x_c = 2 s/C - w, a hyperbola in
the wall's plane: with weights C, rational of degree 2 both ways and still exact. Where the resin
ends the patch shrinks to a point of the valley.
"""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.step.file import PLAIN, Header, real
from mpfcad.cad.step.patch_solid import PatchSolid, Place
from mpfcad.errors import InputError
from mpfcad.film import FieldPiece

#: Most patches of a solid; beyond, files are too long for every reader.
MOST_PATCHES = 20_000
#: Grooves of one cap: kernels slow down with the square or cube of a face's edges.
GROOVES_PER_CAP = 16
#: A curvature [1/mm] within this of 0, or of where walls or resin vanish, is that.
EXACT = 1e-9
#: Bernstein coefficients, degree 2, of 1, v and v² over v = -1 … 1.
_ONE, _V, _V2 = np.array([1.0, 1, 1]), np.array([-1.0, 0, 1]), np.array([1.0, -1, 1])
_KNOTS = {1: ("(2,2)", "(0.,1.)"), 2: ("(3,3)", "(0.,1.)")}


class _Bend:
    """A place along a groove where one patch ends and the next begins."""

    def __init__(self, film: FieldPiece, index: int, y: float, curvature: float) -> None:
        w, s = film.groove.half_width, film.groove.wall_slope
        self.y, self.curvature = y, curvature
        left, right = (float(x) for x in film.tip_position[index : index + 2])
        self.centre, top = float(film.groove_position[index]), film.thickness
        self.tips: tuple[Place, Place] = ((left, y, top), (right, y, top))
        contact = float(film.contact(curvature))
        self.is_bare = contact < w and curvature - film.groove.curvature_covered > EXACT
        self.is_empty = self.is_bare and film.groove.curvature_empty - curvature < EXACT
        self.ends = self.tips
        if self.is_empty:
            self.ends = ((self.centre, y, film.base),) * 2
        elif self.is_bare:
            z = film.base + s * contact
            self.ends = ((self.centre - contact, y, z), (self.centre + contact, y, z))


def write_field_step(
    film: FieldPiece, path: Path, *, name: str = "film", header: Header = PLAIN
) -> None:
    """Write the piece as one solid `film` in mm; same film, same bytes.

    Raises
    ------
    InputError
        when it takes too many patches: the text says how large a piece may be.
    """
    rows = [
        [_Bend(film, index, float(y), float(c)) for y, c in zip(*film.split(row), strict=True)]
        for index, row in enumerate(film.curvature)
    ]
    count = sum(len(row) - 1 for row in rows)
    if count > MOST_PATCHES:
        width, length = film.size
        raise InputError(
            f"film: {width:.6g} x {length:.6g} mm: {count} patches: expected at most "
            f"{MOST_PATCHES} in a STEP file: "
            f"{math.floor(width * length * MOST_PATCHES / count)} mm² of this map fit"
        )
    solid = PatchSolid(header)
    near = [rows[0], *(a + b for a, b in pairwise(rows)), rows[-1]]
    tip = film.tip_position
    lines = [
        [(float(x), y, film.thickness) for y in sorted({bend.y for bend in bends})]
        for x, bends in zip(tip, near, strict=True)
    ]
    for index, row in enumerate(rows):
        for low, high in pairwise(row):
            if not (low.is_empty and high.is_empty):
                _draw_patch(solid, film, low, high, lines[index : index + 2])
        _draw_walls(solid, film, row, lines[index : index + 2])
    _draw_block(solid, film, rows, lines)
    solid.write(path, name)


def _between(line: list[Place], low: float, high: float) -> list[Place]:
    """Return the corners of a tip line from y = `low` to `high`, both among them."""
    return [place for place in line if low <= place[1] <= high]


def _draw_patch(
    solid: PatchSolid, film: FieldPiece, low: _Bend, high: _Bend, lines: list[list[Place]]
) -> None:
    """Add the resin's surface between two bends."""
    for bend in (low, high):
        if not bend.is_empty and bend.curvature > EXACT:
            drop = bend.curvature / 2 * film.groove.half_width**2
            bottom = (bend.centre, bend.y, film.thickness - drop)
            if (bend.ends[0], bend.ends[1]) not in solid.edges:
                solid.edge(*bend.ends, solid.bowl(bottom, (1.0, 0.0), bend.curvature))
    if low.is_bare or high.is_bare:
        points, weights = _rational(film, low, high)
        sides = [[low.ends[side], high.ends[side]] for side in (0, 1)]
        for side, (start, end) in enumerate(sides):
            if low.curvature != high.curvature:
                solid.edge(start, end, _conic(solid, points[2 * side], weights))
        surface = _surface(solid, points, weights)
    else:
        sides = [_between(line, low.y, high.y) for line in lines]
        surface = _surface(solid, _polynomial(film, low, high), None)
    loop = [*sides[1], *sides[0][::-1]]
    kept = [place for k, place in enumerate(loop) if place != loop[k - 1]]
    solid.face(kept, surface)


def _polynomial(film: FieldPiece, low: _Bend, high: _Bend) -> NDArray[np.float64]:
    """Return the control points, (3, 2, 3) [mm], across and along, of a patch from tip to tip."""
    w = film.groove.half_width
    points = np.empty((3, 2, 3))
    for along, bend in enumerate((low, high)):
        points[:, along, 0] = [bend.tips[0][0], bend.centre, bend.tips[1][0]]
        points[:, along, 1] = bend.y
        points[:, along, 2] = film.thickness - bend.curvature / 2 * w**2 * (_ONE - _V2)
    return points


def _rational(
    film: FieldPiece, low: _Bend, high: _Bend
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return control points, (3, 3, 3) [mm], and weights along, (3,), of a patch between walls.

    With x = v x_c and n = 2 s - w C = C x_c, linear along as C is: C x = v n and
    C z = thickness C - w² C²/2 + v² n²/2, all of degree 2 along.
    """
    w, s = film.groove.half_width, film.groove.wall_slope
    c = low.curvature, high.curvature
    n = 2 * s - w * c[0], 2 * s - w * c[1]
    weight = _product(c, (1.0, 1.0))
    across = np.multiply.outer(_V, _product(n, (1.0, 1.0))) / weight
    up = np.multiply.outer(_V2, _product(n, n)) / (2 * weight)
    points = np.empty((3, 3, 3))
    points[..., 0] = low.centre + across
    points[..., 1] = _product(c, (low.y, high.y)) / weight
    points[..., 2] = film.thickness - w**2 / 2 * _product(c, c) / weight + up
    return points, weight / c[0]


def _product(f: tuple[float, float], g: tuple[float, float]) -> NDArray[np.float64]:
    """Return the Bernstein coefficients of the product of two linear functions by their ends."""
    return np.array([f[0] * g[0], (f[0] * g[1] + f[1] * g[0]) / 2, f[1] * g[1]])


def _conic(solid: PatchSolid, points: NDArray[np.float64], weights: NDArray[np.float64]) -> str:
    """Return the contact line, a rational curve of degree 2."""
    control = ",".join(solid.file.point(*point) for point in points)
    return solid.file.add(
        f"(BOUNDED_CURVE()B_SPLINE_CURVE(2,({control}),.UNSPECIFIED.,.F.,.F.)"
        "B_SPLINE_CURVE_WITH_KNOTS((3,3),(0.,1.),.UNSPECIFIED.)CURVE()"
        "GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE"
        f"(({','.join(map(real, weights))}))REPRESENTATION_ITEM(''))"
    )


def _surface(
    solid: PatchSolid, points: NDArray[np.float64], weights: NDArray[np.float64] | None
) -> str:
    """Return a Bézier surface; `weights` along, the same in each row across."""
    rows = ",".join(
        "(" + ",".join(solid.file.point(*point) for point in row) + ")" for row in points
    )
    degree = points.shape[1] - 1
    form = f"({rows}),.UNSPECIFIED.,.F.,.F.,.F."
    multiplicity, knots = zip(_KNOTS[2], _KNOTS[degree], strict=True)
    knotted = f"{','.join(multiplicity)},{','.join(knots)},.UNSPECIFIED."
    if weights is None:
        return solid.file.add(f"B_SPLINE_SURFACE_WITH_KNOTS('',2,{degree},{form},{knotted})")
    row = f"({','.join(map(real, weights))})"
    return solid.file.add(
        f"(BOUNDED_SURFACE()B_SPLINE_SURFACE(2,{degree},{form})"
        f"B_SPLINE_SURFACE_WITH_KNOTS({knotted})GEOMETRIC_REPRESENTATION_ITEM()"
        f"RATIONAL_B_SPLINE_SURFACE(({row},{row},{row}))REPRESENTATION_ITEM('')SURFACE())"
    )


def _draw_walls(
    solid: PatchSolid, film: FieldPiece, row: list[_Bend], lines: list[list[Place]]
) -> None:
    """Add the bare walls of a groove: a face to each side of every stretch that has some."""
    size, s = math.hypot(1, film.groove.wall_slope), film.groove.wall_slope
    for run in _bare_runs(row):
        for side in (0, 1):
            contact = [bend.ends[side] for bend in run]
            tip = _between(lines[side], run[0].y, run[-1].y)
            loop = [*tip, *contact[::-1]] if side else [*contact, *tip[::-1]]
            places = [place for k, place in enumerate(loop) if place != loop[k - 1]]
            # Anchored at a tip, which is exact.
            first = places.index(tip[0])
            normal = ((1 - 2 * side) * s / size, 0.0, 1 / size)
            solid.flat(places[first:] + places[:first], normal, (0, 1, 0))


def _bare_runs(row: list[_Bend]) -> list[list[_Bend]]:
    """Return the stretches of a groove that have bare walls, each from end to end."""
    runs: list[list[_Bend]] = []
    for low, high in pairwise(row):
        if low.is_bare and runs and runs[-1][-1] is low:
            runs[-1].append(high)
        elif low.is_bare or high.is_bare:
            runs.append([low, high])
    return runs


def _profile(row: list[_Bend], end: int) -> list[Place]:
    """Return the corners of a groove's section at one of its ends, from tip to tip."""
    bend = row[end]
    line = [bend.tips[0], *bend.ends, bend.tips[1]]
    return [place for k, place in enumerate(line) if k == 0 or place != line[k - 1]]


def _draw_block(
    solid: PatchSolid, film: FieldPiece, rows: list[list[_Bend]], lines: list[list[Place]]
) -> None:
    """Add underside, sides, and ends of a few grooves each."""
    length = film.size[1]
    cuts = [*range(0, len(rows), GROOVES_PER_CAP), len(rows)]
    places = [float(film.tip_position[cut]) for cut in cuts]
    places[-1] = lines[-1][0][0]
    near, far = ([(x, y, 0.0) for x in places] for y in (0.0, length))
    solid.flat([*far, *near[::-1]], (0, 0, -1), (1, 0, 0))
    solid.flat([far[0], near[0], *lines[0]], (-1, 0, 0), (0, 0, 1))
    solid.flat([near[-1], far[-1], *lines[-1][::-1]], (1, 0, 0), (0, 0, 1))
    for k, (first, last) in enumerate(pairwise(cuts)):
        for end, feet in ((0, near), (-1, far)):
            line = [place for row in rows[first:last] for place in _profile(row, end)]
            line = [place for i, place in enumerate(line) if i == 0 or place != line[i - 1]]
            if end == 0:
                solid.flat([feet[k], feet[k + 1], *line[::-1]], (0, -1, 0), (0, 0, 1))
            else:
                solid.flat([feet[k + 1], feet[k], *line], (0, 1, 0), (0, 0, 1))
