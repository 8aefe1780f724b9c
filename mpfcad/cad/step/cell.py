"""Write a film of cells as one exact solid of a STEP file; no CAD library is used.

A pyramid's faces are parabolas extruded along its valleys; two of them meet in a parabola in the
diagonal's plane. A dish is one biquadratic patch. Edges and corners are shared between neighbours.
"""

import math
from pathlib import Path

from mpfcad.cad.step.file import PLAIN, Header
from mpfcad.cad.step.outline import drawn_sliver
from mpfcad.cad.step.patch_solid import PatchSolid, Place
from mpfcad.cad.step.product import Products
from mpfcad.errors import InputError
from mpfcad.film import CellFilm

#: Most cells of a solid; beyond, files are too long for every reader.
MOST_CELLS = 20_000
#: A profile flatter than this [mm] is no surface with an edge between its cells.
FLAT = 1e-6


def write_cell_step(
    film: CellFilm, path: Path, *, name: str = "film", header: Header = PLAIN
) -> None:
    """Write the film as one solid `film` in mm; same film, same bytes.

    Raises
    ------
    InputError
        when the film is flat, or has too many cells.
    """
    cells = film.count[0] * film.count[1]
    if cells > MOST_CELLS:
        raise InputError(f"film: {cells} cells: expected at most {MOST_CELLS} in a STEP file")
    _refuse_flat(film)
    solid = PatchSolid(header)
    draw = _draw_pyramid if film.shape == "pyramid" else _draw_dish
    for i in range(film.count[0]):
        for j in range(film.count[1]):
            draw(solid, film, i, j)
    _draw_block(solid, film)
    solid.write(path, name)


def _refuse_flat(film: CellFilm) -> None:
    least = min(film.both)
    if least / 2 * film.groove.half_width**2 < FLAT:
        raise InputError(
            f"film: curvature {least:g} /mm: flat to {FLAT * 1e6:g} nm: expected cells"
        )


def _draw_pyramid(solid: PatchSolid, film: CellFilm, i: int, j: int) -> None:
    """Add the four sides of a pyramid: a curved part each, and a plane one where it is bare."""
    pitch, w = film.groove.pitch, film.groove.half_width
    reach, low = _bare_ring(film)
    contact = film.base + film.groove.wall_slope * reach
    tip = ((i + 0.5) * pitch, (j + 0.5) * pitch, film.thickness)
    ground = [((i + a) * pitch, (j + b) * pitch, low) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    inward = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ring = [
        (x + a * reach, y + b * reach, contact)
        for (x, y, _), (a, b) in zip(ground, inward, strict=True)
    ]
    if reach == 0:
        ring = ground
    elif reach == w:
        ring = [tip] * 4
    if reach:
        for start, end, (a, b) in zip(ground, ring, inward, strict=True):
            # Along the diagonal a step is √2 longer: half the curvature.
            curve = solid.bowl(start, (a / math.sqrt(2), b / math.sqrt(2)), film.curvature / 2)
            solid.edge(start, end, curve)
    for k in range(4):
        first, second = ground[k], ground[(k + 1) % 4]
        if reach:
            places = [first, second, ring[(k + 1) % 4]]
            places += [] if reach == w else [ring[k]]
            solid.face(places, _valley(solid, film, first, k))
        if reach < w:
            a, b = ((0, 1), (-1, 0), (0, -1), (1, 0))[k]
            size, s = math.hypot(1, film.groove.wall_slope), film.groove.wall_slope
            across = (b, -a, 0)
            normal = (-a * s / size, -b * s / size, 1 / size)
            solid.flat([ring[k], ring[(k + 1) % 4], tip], normal, across)


def draw_single(film: CellFilm, products: Products) -> str:
    """Return the solid of a cell from tip to tip, its valleys in the middle, in an open file.

    Raises
    ------
    InputError
        for a pyramid of two curvatures, whose ridges are no conics, or a cell that is flat.
    """
    if film.shape == "pyramid" and film.both[0] != film.both[1]:
        raise InputError(
            f"film: a pyramid of C {film.both[0]:g} x {film.both[1]:g} /mm: its ridges are no "
            "conics: expected one curvature for STEP, or 3MF, STL"
        )
    _refuse_flat(film)
    solid = PatchSolid(products=products)
    if film.shape == "paraboloid":
        _draw_dish(solid, film, 0, 0)
    else:
        for k in range(4):
            _draw_valley_side(solid, film, k)
    _draw_foot(solid, film)
    return solid.solid()


#: Of the sides of a cell, in their order: outward, and to the left of it as seen from above.
_SIDES = (((0, -1), (1, 0)), ((1, 0), (0, 1)), ((0, 1), (-1, 0)), ((-1, 0), (0, -1)))


def _side_chain(film: CellFilm, k: int) -> list[Place]:
    """Return tip, end of the resin, its other end, next tip of side k, anticlockwise."""
    w = film.groove.half_width
    reach, low = _bare_ring(film)
    (ox, oy), (lx, ly) = _SIDES[k]
    contact = film.base + film.groove.wall_slope * reach if reach < w else film.thickness
    at = [(-w, film.thickness), (-reach, contact), (reach, contact), (w, film.thickness)]
    if reach == 0:
        at = [at[0], (0.0, low), at[3]]
    elif reach == w:
        at = [at[0], at[3]]
    return [(w + ox * w + lx * t, w + oy * w + ly * t, z) for t, z in at]


def _draw_valley_side(solid: PatchSolid, film: CellFilm, k: int) -> None:
    """Add the valley that runs from a cell's middle to its side k."""
    w = film.groove.half_width
    reach, low = _bare_ring(film)
    (ox, oy), (lx, ly) = _SIDES[k]
    middle = (w, w, low)
    chain = _side_chain(film, k)
    # The ends of the resin on both ridges, which run to the tips.
    ridge = [
        (w + reach * (ox + sign * lx), w + reach * (oy + sign * ly), chain[1][2])
        for sign in (-1, 1)
    ]
    if reach:
        ends = [chain[0], chain[-1]] if reach == w else ridge
        for sign, end in ((-1, ends[0]), (1, ends[1])):
            along = ((ox + sign * lx) / math.sqrt(2), (oy + sign * ly) / math.sqrt(2))
            if (middle, end) not in solid.edges:
                solid.edge(middle, end, solid.bowl(middle, along, film.curvature / 2))
        left, right = (chain[0], chain[-1]) if reach == w else (chain[1], chain[2])
        bottom = (w + ox * w, w + oy * w, low)
        solid.edge(left, right, solid.bowl(bottom, (lx, ly), film.curvature))
        places = [middle, left, right] if reach == w else [middle, ends[0], left, right, ends[1]]
        # It runs across the side, as the valley at a side before does.
        solid.face(places, _valley(solid, film, middle, k + 1))
    if reach < w:
        size, s = math.hypot(1, film.groove.wall_slope), film.groove.wall_slope
        for sign, tip, inner, outer in (
            (-1, chain[0], ridge[0], chain[1]),
            (1, chain[-1], ridge[1], chain[-2]),
        ):
            start = middle if reach == 0 else inner
            places = [start, tip, outer] if sign < 0 else [start, outer, tip]
            normal = (-sign * lx * s / size, -sign * ly * s / size, 1 / size)
            solid.flat(places, normal, (ox, oy, 0))


def _draw_foot(solid: PatchSolid, film: CellFilm) -> None:
    """Add underside and sides of one cell from tip to tip."""
    pitch = film.groove.pitch
    feet = [(0.0, 0.0, 0.0), (pitch, 0.0, 0.0), (pitch, pitch, 0.0), (0.0, pitch, 0.0)]
    solid.flat([feet[0], feet[3], feet[2], feet[1]], (0, 0, -1), (1, 0, 0))
    for k, ((ox, oy), _) in enumerate(_SIDES):
        chain = _side_chain(film, k)
        if film.shape == "paraboloid":
            chain = [chain[0], chain[-1]]
        solid.flat([feet[k], feet[(k + 1) % 4], *chain[::-1]], (ox, oy, 0), (0, 0, 1))


def _bare_ring(film: CellFilm) -> tuple[float, float]:
    """Return how far from the valley the parabola reaches, and the valley's height [mm]."""
    w = film.groove.half_width
    if film.profile == "ideal":
        return w, film.lowest
    reach = float(film.groove.contact_position(film.curvature))
    sliver = drawn_sliver(max(film.size))
    if reach < sliver:
        return 0.0, film.base
    return (w if w - reach < sliver else reach), film.lowest


def _valley(solid: PatchSolid, film: CellFilm, at: Place, side: int) -> str:
    """Return the parabola drawn along the valley at a side of a cell, its normal upward."""
    file = solid.file
    # Sides 0 and 2 have their valley along x: the profile runs along y, and is drawn along -x.
    across = (0.0, 1.0) if side % 2 == 0 else (1.0, 0.0)
    along = file.direction(-1, 0, 0) if side % 2 == 0 else file.direction(0, 1, 0)
    bottom = (0.0, at[1], at[2]) if side % 2 == 0 else (at[0], 0.0, at[2])
    curve = solid.bowl(bottom, across, film.curvature)
    return file.share("SURFACE_OF_LINEAR_EXTRUSION", curve, file.vector(along))


def _draw_dish(solid: PatchSolid, film: CellFilm, i: int, j: int) -> None:
    """Add one dish: a biquadratic patch between four parabolas."""
    pitch, w, top = film.groove.pitch, film.groove.half_width, film.thickness
    drops = [curvature / 2 * w**2 for curvature in film.both]
    corner = [((i + a) * pitch, (j + b) * pitch, top) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for k in range(4):
        start, end = corner[k], corner[(k + 1) % 4]
        # Drawn to the right or upward, whichever cell comes first.
        start, end = min(start, end), max(start, end)
        if (start, end) not in solid.edges:
            axis = 0 if start[1] == end[1] else 1
            bottom = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, top - drops[axis])
            along = (1.0 - axis, float(axis))
            solid.edge(start, end, solid.bowl(bottom, along, film.both[axis]))
    # Of the height over one coordinate, (C/2)(t² - w²): Bézier heights 0, -2 drop, 0.
    sag, sag_along = ((0.0, -2 * drop, 0.0) for drop in drops)
    rows = [
        "(" + ",".join(
            solid.file.point((i + a / 2) * pitch, (j + b / 2) * pitch, top + sag[a] + sag_along[b])
            for b in range(3)
        ) + ")"
        for a in range(3)
    ]  # fmt: skip
    knots = "(3,3),(3,3),(0.,1.),(0.,1.),.UNSPECIFIED."
    patch = solid.file.add(
        f"B_SPLINE_SURFACE_WITH_KNOTS('',2,2,({','.join(rows)}),.UNSPECIFIED.,.F.,.F.,.F.,{knots})"
    )
    solid.face(corner, patch)


def _draw_block(solid: PatchSolid, film: CellFilm) -> None:
    """Add underside and sides."""
    (width, length), (nx, ny) = film.size, film.count
    pitch = film.groove.pitch
    rim = _bare_ring(film)[1] if film.shape == "pyramid" else film.thickness
    feet = [(0.0, 0.0, 0.0), (width, 0.0, 0.0), (width, length, 0.0), (0.0, length, 0.0)]
    solid.flat([feet[0], feet[3], feet[2], feet[1]], (0, 0, -1), (1, 0, 0))
    sides = (
        ([(i * pitch, 0.0, rim) for i in range(nx + 1)], (0, -1, 0)),
        ([(nx * pitch, j * pitch, rim) for j in range(ny + 1)], (1, 0, 0)),
        ([(i * pitch, ny * pitch, rim) for i in range(nx, -1, -1)], (0, 1, 0)),
        ([(0.0, j * pitch, rim) for j in range(ny, -1, -1)], (-1, 0, 0)),
    )
    for k, (edge, normal) in enumerate(sides):
        solid.flat([feet[k], feet[(k + 1) % 4], *edge[::-1]], normal, (0, 0, 1))
